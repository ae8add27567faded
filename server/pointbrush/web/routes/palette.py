"""A recording's palette as a file, and templates of well-known datasets."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Field

from pointbrush.errors import BadInputError
from pointbrush.formats.datasets import DATASETS, dataset_named
from pointbrush.streaming.messages import Color, LabelId
from pointbrush.web.auth import Caller, resource
from pointbrush.web.context import SequenceId, Ws
from pointbrush.web.problems import responses
from pointbrush.web.routes.labels import EditId
from pointbrush.web.schemas import Body, EditOut, Name
from pointbrush.workspace import NamedLabel

router = resource("labels")


class PaletteLabel(BaseModel):
    """A label without its id; further fields of an exported ``palette.json`` are passed over."""

    name: Name
    category: Annotated[str, Field(max_length=200, pattern=r"^[^\x00-\x1f\x7f]*$")] = ""
    color: Color | None = None


class PaletteBody(Body):
    """Labels to add, or the template that has them."""

    template: Annotated[str, Field(max_length=64)] | None = None
    labels: Annotated[list[PaletteLabel], Field(max_length=65534, default_factory=list)]


class OrderBody(Body):
    """Ids of labels, first to last; labels that it does not name follow."""

    labels: Annotated[list[LabelId], Field(max_length=65534)]


class PaletteOut(BaseModel):
    """A palette as a file."""

    labels: list[PaletteLabel]


class Added(BaseModel):
    """Names of labels that were not there before."""

    added: list[str]


@router.get("/templates")
def list_templates() -> dict[str, PaletteOut]:
    """Palettes of well-known datasets, by name."""
    return {
        name: PaletteOut(
            labels=[
                PaletteLabel(name=each.name, category=each.name, color=each.color)
                for each in dataset.classes.values()
            ]
        )
        for name, dataset in DATASETS.items()
    }


@router.get("/sequences/{seq}/palette", responses=responses(404))
def get_palette(seq: SequenceId, workspace: Ws) -> PaletteOut:
    """The palette; the answer can be posted to another recording."""
    return PaletteOut(
        labels=[
            PaletteLabel(name=label.name, category=label.category, color=label.color)
            for label in workspace.palette(seq)
        ]
    )


@router.post("/sequences/{seq}/palette", responses=responses(404, 409, 413))
def add_palette(seq: SequenceId, body: PaletteBody, workspace: Ws, who: Caller) -> Added:
    """Add the labels of a file or a template that are not there yet, as one edit."""
    if (body.template is None) == (not body.labels):
        raise BadInputError("template: expected a template or labels, got both or none of them")
    if body.template is not None:
        dataset = dataset_named(body.template)
        return Added(added=workspace.add_template(seq, dataset, who.author))
    labels = [NamedLabel(each.name, each.category, each.color) for each in body.labels]
    return Added(added=workspace.add_labels(seq, labels, who.author))


@router.put("/sequences/{seq}/palette/order", responses=responses(404, 409, 413))
def arrange_palette(
    seq: SequenceId, body: OrderBody, workspace: Ws, who: Caller, edit: EditId = None
) -> EditOut:
    """Put the labels in an order, as one edit."""
    return EditOut.of(workspace.arrange_labels(seq, who.author, body.labels, edit_id=edit))
