"""The classes of the workspace, as a file too."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Field

from pointbrush.labels import Category
from pointbrush.names import HIDDEN
from pointbrush.web.auth import resource
from pointbrush.web.context import Ws
from pointbrush.web.problems import responses
from pointbrush.web.schemas import VISIBLE, Body, Out

router = resource("taxonomy")
NAME = f"^[^{HIDDEN} ]{VISIBLE}*$"
"""No control characters, and no space in front."""


DatasetName = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]{0,63}$")]
DatasetNumber = Annotated[int, Field(ge=0, le=65535)]


class CategoryBody(Body):
    """A class; its number never changes.  ``datasets`` are its numbers in those by name."""

    number: Annotated[int, Field(ge=1, le=65535)]
    name: Annotated[str, Field(min_length=1, max_length=256, pattern=NAME)]
    color: Annotated[str, Field(pattern=r"^(#[0-9a-fA-F]{6})?$")] = ""
    datasets: Annotated[
        dict[DatasetName, DatasetNumber], Field(max_length=64, default_factory=dict)
    ]


class TaxonomyBody(Body):
    """Classes to add, and new names and colours of those that there are."""

    categories: Annotated[list[CategoryBody], Field(max_length=65535)]


class CategoryOut(Out):
    """A class and its number in every export of this workspace."""

    number: int
    name: str
    color: str
    datasets: dict[str, int]


class TaxonomyOut(BaseModel):
    """All classes, by number."""

    categories: list[CategoryOut]

    @classmethod
    def of(cls, entries: list[Category]) -> TaxonomyOut:
        """From the workspace's."""
        return cls(categories=[CategoryOut.of(each) for each in entries])


@router.get("/taxonomy")
def get_taxonomy(workspace: Ws) -> TaxonomyOut:
    """All classes of the workspace; the answer can be put into another one."""
    return TaxonomyOut.of(workspace.labels.taxonomy.entries())


@router.put("/taxonomy", responses=responses(409, 413))
def put_taxonomy(body: TaxonomyBody, workspace: Ws) -> TaxonomyOut:
    """Add classes, or change their names and colours; those left out stay."""
    wanted = [
        Category(each.number, each.name, each.color, each.datasets) for each in body.categories
    ]
    return TaxonomyOut.of(workspace.labels.taxonomy.put(wanted))
