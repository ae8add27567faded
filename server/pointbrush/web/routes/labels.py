"""The palette, as a file too, and templates of well-known datasets."""

from __future__ import annotations

from typing import Annotated

from fastapi import Query, Response
from pydantic import BaseModel, Field

from pointbrush.errors import BadInputError
from pointbrush.formats.tables.datasets import DATASETS, dataset_named
from pointbrush.names import spelled_out
from pointbrush.streaming.messages import Color, LabelId, Uuid
from pointbrush.web.auth import Caller, resource
from pointbrush.web.context import LabelPath, SequenceId, WholeSequence, Ws
from pointbrush.web.problems import responses
from pointbrush.web.schemas import (
    VISIBLE,
    Body,
    CountedLabelOut,
    EditOut,
    LabelBody,
    LabelOut,
    LabelPatch,
    MergeBody,
    Name,
    SplitBody,
    SplitOut,
)
from pointbrush.work.palettes import NamedLabel, add_labels, add_template, counted_labels, offered

router = resource("labels")
EditId = Annotated[Uuid | None, Query(description="the edit's UUID, which is applied once")]


@router.get("/sequences/{seq}/labels", responses=responses(404))
def list_labels(seq: WholeSequence, workspace: Ws) -> list[CountedLabelOut]:
    """List the labels of a recording with the number of points of each."""
    return [CountedLabelOut.of(label) for label in counted_labels(workspace.labels, seq)]


@router.post("/sequences/{seq}/labels", status_code=201, responses=responses(404, 409, 413))
def create_label(
    seq: WholeSequence,
    body: LabelBody,
    response: Response,
    workspace: Ws,
    who: Caller,
    edit: EditId = None,
) -> LabelOut:
    """Add a label."""
    label = workspace.labels.create_label(seq, who.author, edit_id=edit, **body.model_dump())
    response.headers["Location"] = f"/api/v1/sequences/{seq}/labels/{label.id}"
    return LabelOut.of(label)


@router.get("/sequences/{seq}/labels/{id}", responses=responses(404))
def get_label(seq: WholeSequence, id: LabelPath, workspace: Ws) -> LabelOut:
    """Return a label."""
    return LabelOut.of(workspace.labels.label(seq, id))


@router.patch("/sequences/{seq}/labels/{id}", responses=responses(404, 409, 413))
def update_label(
    seq: WholeSequence,
    id: LabelPath,
    body: LabelPatch,
    workspace: Ws,
    who: Caller,
    edit: EditId = None,
) -> LabelOut:
    """Rename, recolour, recategorise, lock or hide a label."""
    fields = {name: value for name, value in body.model_dump().items() if value is not None}
    if not fields:
        return LabelOut.of(workspace.labels.label(seq, id))
    return LabelOut.of(workspace.labels.update_label(seq, who.author, id, edit_id=edit, **fields))


@router.delete("/sequences/{seq}/labels/{id}", responses=responses(404, 409))
def delete_label(
    seq: WholeSequence, id: LabelPath, workspace: Ws, who: Caller, edit: EditId = None
) -> EditOut:
    """Remove a label; its points become unlabeled in the same edit."""
    return EditOut.of(workspace.labels.delete_label(seq, who.author, id, edit_id=edit))


@router.post("/sequences/{seq}/labels/{id}/merge", responses=responses(404, 409))
def merge_labels(
    seq: WholeSequence,
    id: LabelPath,
    body: MergeBody,
    workspace: Ws,
    who: Caller,
    edit: EditId = None,
) -> EditOut:
    """Give the points of other labels to this label in all frames, and remove them; one edit."""
    return EditOut.of(workspace.labels.merge_labels(seq, who.author, id, body.labels, edit_id=edit))


@router.post("/sequences/{seq}/labels/{id}/split", responses=responses(404, 409))
def split_label(
    seq: SequenceId,
    id: LabelPath,
    body: SplitBody,
    workspace: Ws,
    who: Caller,
    edit: EditId = None,
) -> SplitOut:
    """Give each connected part of a label in a frame its own label, except the largest part."""
    split = workspace.splitting.split
    return SplitOut.done(
        split(seq, who.author, id, body.frame, edit=edit, gap=body.gap, least=body.least)
    )


class PaletteLabel(BaseModel):
    """A label without its id; other fields of an exported ``palette.json`` are ignored."""

    name: Name
    category: Annotated[str, Field(max_length=200, pattern=f"^{VISIBLE}*$")] = ""
    color: Color | None = None


class PaletteBody(Body):
    """Labels to add, or a template that contains them."""

    template: Annotated[str, Field(max_length=64)] | None = None
    labels: Annotated[list[PaletteLabel], Field(max_length=65534, default_factory=list)]


class OrderBody(Body):
    """Ids of labels, first to last; missing labels follow."""

    labels: Annotated[list[LabelId], Field(max_length=65534)]


class PaletteOut(BaseModel):
    """A palette as a file."""

    labels: list[PaletteLabel]


class OfferedOut(BaseModel):
    """Categories for labels, by number; ``selected``: labels get no other category."""

    selected: bool
    names: list[str]


class Added(BaseModel):
    """Names of the new labels."""

    added: list[str]


@router.get("/templates")
def list_templates() -> dict[str, PaletteOut]:
    """List the palettes of well-known datasets, by name."""
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
def get_palette(seq: WholeSequence, workspace: Ws) -> PaletteOut:
    """Return the palette; the answer can be posted to another recording."""
    return PaletteOut(
        labels=[
            # An older palette may have characters that names must not contain now.
            PaletteLabel(
                name=spelled_out(label.name),
                category=spelled_out(label.category),
                color=label.color,
            )
            for label in workspace.labels.palette(seq)
        ]
    )


@router.post("/sequences/{seq}/palette", responses=responses(404, 409, 413))
def add_palette(seq: WholeSequence, body: PaletteBody, workspace: Ws, who: Caller) -> Added:
    """Add the missing labels of a file or a template, as one edit."""
    if (body.template is None) == (not body.labels):
        raise BadInputError("template: expected a template or labels, got both or none of them")
    if body.template is not None:
        dataset = dataset_named(body.template)
        return Added(added=add_template(workspace.labels, seq, dataset, who.author))
    labels = [NamedLabel(each.name, each.category, each.color) for each in body.labels]
    return Added(added=add_labels(workspace.labels, seq, labels, who.author))


@router.get("/sequences/{seq}/categories", responses=responses(404))
def list_categories(seq: WholeSequence, workspace: Ws) -> OfferedOut:
    """List the categories for labels: the selection of the project, or all categories."""
    selected, names = offered(workspace.labels, seq)
    return OfferedOut(selected=selected, names=names)


@router.put("/sequences/{seq}/palette/order", responses=responses(404, 409, 413))
def arrange_palette(
    seq: WholeSequence, body: OrderBody, workspace: Ws, who: Caller, edit: EditId = None
) -> EditOut:
    """Order the labels, as one edit."""
    return EditOut.of(workspace.labels.arrange_labels(seq, who.author, body.labels, edit_id=edit))
