"""The classes of the workspace, as a file too."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path
from pydantic import BaseModel, Field

from pointbrush.labels import BoxAttribute, Category
from pointbrush.labels.boxes.attributes import MOST_CHOICES, AttributeKind, Scope
from pointbrush.labels.boxes.maps import MOST_ATTRIBUTES, NAME_LIMIT
from pointbrush.labels.classes.taxonomy import Taxonomy
from pointbrush.names import HIDDEN
from pointbrush.web.auth import resource
from pointbrush.web.context import Ws
from pointbrush.web.problems import responses
from pointbrush.web.schemas import VISIBLE, Body, Out, Sides

router = resource("taxonomy")
NAME = f"^[^{HIDDEN} ]{VISIBLE}*$"
"""No control characters, and no space in front."""


CategoryNumber = Annotated[int, Field(ge=1, le=65535)]
NumberPath = Annotated[int, Path(ge=1, le=65535, description="number of a category")]
DatasetName = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]{0,63}$")]
DatasetNumber = Annotated[int, Field(ge=0, le=65535)]


class CategoryBody(Body):
    """A class; its number never changes.  ``datasets``: its numbers in other datasets, by name.

    ``size``: length, width, height of its objects, metres, ``spread``: their standard deviation;
    null keeps the stored values.
    """

    number: CategoryNumber
    name: Annotated[str, Field(min_length=1, max_length=256, pattern=NAME)]
    color: Annotated[str, Field(pattern=r"^(#[0-9a-fA-F]{6})?$")] = ""
    datasets: Annotated[
        dict[DatasetName, DatasetNumber], Field(max_length=64, default_factory=dict)
    ]
    size: Sides | None = None
    spread: Sides | None = None

    def category(self) -> Category:
        """Make the class."""
        return Category(
            self.number,
            self.name,
            self.color,
            self.datasets,
            None if self.size is None else (self.size[0], self.size[1], self.size[2]),
            None if self.spread is None else (self.spread[0], self.spread[1], self.spread[2]),
        )


AttributeText = Annotated[str, Field(min_length=1, max_length=NAME_LIMIT, pattern=NAME)]


class AttributeBody(Body):
    """An attribute of boxes, per track or per frame; ``choices`` are for the kind choice."""

    name: AttributeText
    kind: AttributeKind
    scope: Scope = "track"
    choices: Annotated[list[AttributeText], Field(max_length=MOST_CHOICES, default_factory=list)]

    def attribute(self) -> BoxAttribute:
        """Make the definition."""
        return BoxAttribute(self.name, self.kind, self.scope, tuple(self.choices))


class TaxonomyBody(Body):
    """Classes to add, and new names and colours of existing classes.

    ``attributes`` of boxes replace the existing ones; null keeps these.
    """

    categories: Annotated[list[CategoryBody], Field(max_length=65535, default_factory=list)]
    attributes: Annotated[list[AttributeBody], Field(max_length=MOST_ATTRIBUTES)] | None = None


class CategoryOut(Out):
    """A class and its number in every export of this workspace."""

    number: int
    name: str
    color: str
    datasets: dict[str, int]
    size: list[float] | None
    spread: list[float] | None


class AttributeOut(Out):
    """An attribute that boxes may have beside ``occluded``, ``truncated`` and ``parked``."""

    name: str
    kind: AttributeKind
    scope: Scope
    choices: list[str]


class TaxonomyOut(BaseModel):
    """All classes, by number, and the attributes of boxes."""

    categories: list[CategoryOut]
    attributes: list[AttributeOut]

    @classmethod
    def of(cls, taxonomy: Taxonomy) -> TaxonomyOut:
        """Return the answer for the taxonomy of the workspace."""
        return cls(
            categories=[CategoryOut.of(each) for each in taxonomy.listed()],
            attributes=[AttributeOut.of(each) for each in taxonomy.attributes()],
        )


class MergedBody(Body):
    """Numbers of the categories to remove."""

    categories: Annotated[list[CategoryNumber], Field(min_length=1, max_length=65535)]


@router.get("/taxonomy")
def get_taxonomy(workspace: Ws) -> TaxonomyOut:
    """Return the classes of the workspace; the answer can be put into another workspace."""
    return TaxonomyOut.of(workspace.labels.taxonomy)


@router.put("/taxonomy", responses=responses(409, 413))
def put_taxonomy(body: TaxonomyBody, workspace: Ws) -> TaxonomyOut:
    """Add classes, or change their names, colours and sizes; other classes do not change.

    Renaming a class changes no number: its labels and exports show the new name.
    """
    attributes = None if body.attributes is None else [a.attribute() for a in body.attributes]
    wanted = [each.category() for each in body.categories]
    workspace.labels.taxonomy.put(wanted, attributes)
    return TaxonomyOut.of(workspace.labels.taxonomy)


@router.post("/taxonomy/{number}/merge", responses=responses(404, 409))
def merge_categories(number: NumberPath, body: MergedBody, workspace: Ws) -> TaxonomyOut:
    """Merge other classes into this one: their labels in all recordings become labels of it."""
    workspace.labels.taxonomy.merge(number, body.categories)
    return TaxonomyOut.of(workspace.labels.taxonomy)


@router.delete("/taxonomy/{number}", status_code=204, responses=responses(404, 409))
def delete_category(number: NumberPath, workspace: Ws) -> None:
    """Delete a class that no label uses."""
    workspace.labels.taxonomy.remove(number)
