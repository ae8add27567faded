"""The palette, as a file too, and templates of well-known datasets."""

from __future__ import annotations

from dataclasses import asdict

from fastapi import Response

from pointbrush.errors import BadInputError
from pointbrush.formats.tables.datasets import DATASETS, dataset_named
from pointbrush.names import spelled_out
from pointbrush.values.edits import Edit, Split
from pointbrush.values.labels import (
    AddedLabels,
    Division,
    Label,
    LabelPatch,
    Merge,
    NewLabel,
    OfferedCategories,
    Palette,
    PaletteAddition,
    PaletteLabel,
    PaletteOrder,
)
from pointbrush.web.context import EditId, LabelPath, SequenceId, WholeSequence, Ws
from pointbrush.web.security.auth import Caller, resource
from pointbrush.web.security.roles import needs
from pointbrush.work.palettes import add_labels, add_template, counted_labels, offered

router = resource("labels")


@router.get("/sequences/{seq}/labels", **needs("viewer", 404))
def list_labels(seq: WholeSequence, workspace: Ws) -> list[Label]:
    """List the labels of a recording with the number of points of each."""
    return counted_labels(workspace.labels, seq)


@router.post(
    "/sequences/{seq}/labels",
    status_code=201,
    response_model_exclude_none=True,
    **needs("annotator", 404, 409, 413),
)
def create_label(
    seq: WholeSequence,
    body: NewLabel,
    response: Response,
    workspace: Ws,
    who: Caller,
    edit: EditId = None,
) -> Label:
    """Add a label."""
    label = workspace.labels.create_label(seq, who.author, edit_id=edit, **asdict(body))
    response.headers["Location"] = f"/api/v1/sequences/{seq}/labels/{label.id}"
    return label


@router.get(
    "/sequences/{seq}/labels/{id}", response_model_exclude_none=True, **needs("viewer", 404)
)
def get_label(seq: WholeSequence, id: LabelPath, workspace: Ws) -> Label:
    """Return a label."""
    return workspace.labels.label(seq, id)


@router.patch(
    "/sequences/{seq}/labels/{id}",
    response_model_exclude_none=True,
    **needs("annotator", 404, 409, 413),
)
def update_label(
    seq: WholeSequence,
    id: LabelPath,
    body: LabelPatch,
    workspace: Ws,
    who: Caller,
    edit: EditId = None,
) -> Label:
    """Rename, recolour, recategorise, lock or hide a label."""
    if not (fields := body.to_json()):
        return workspace.labels.label(seq, id)
    return workspace.labels.update_label(seq, who.author, id, edit_id=edit, **fields)


@router.delete("/sequences/{seq}/labels/{id}", **needs("annotator", 404, 409))
def delete_label(
    seq: WholeSequence, id: LabelPath, workspace: Ws, who: Caller, edit: EditId = None
) -> Edit:
    """Remove a label; its points become unlabeled in the same edit."""
    return workspace.labels.delete_label(seq, who.author, id, edit_id=edit)


@router.post("/sequences/{seq}/labels/{id}/merge", **needs("annotator", 404, 409))
def merge_labels(
    seq: WholeSequence,
    id: LabelPath,
    body: Merge,
    workspace: Ws,
    who: Caller,
    edit: EditId = None,
) -> Edit:
    """Give the points of other labels to this label in all frames, and remove them; one edit."""
    return workspace.labels.merge_labels(seq, who.author, id, body.labels, edit_id=edit)


@router.post("/sequences/{seq}/labels/{id}/split", **needs("annotator", 404, 409))
def split_label(
    seq: SequenceId,
    id: LabelPath,
    body: Division,
    workspace: Ws,
    who: Caller,
    edit: EditId = None,
) -> Split:
    """Give each connected part of a label in a frame its own label, except the largest part."""
    split = workspace.splitting.split
    return split(seq, who.author, id, body.frame, edit=edit, gap=body.gap, least=body.least)


@router.get("/templates", **needs("viewer"))
def list_templates() -> dict[str, Palette]:
    """List the palettes of well-known datasets, by name."""
    return {
        name: Palette(
            tuple(
                PaletteLabel(each.name, each.name, each.color) for each in dataset.classes.values()
            )
        )
        for name, dataset in DATASETS.items()
    }


@router.get("/sequences/{seq}/palette", **needs("viewer", 404))
def get_palette(seq: WholeSequence, workspace: Ws) -> Palette:
    """Return the palette; the answer can be posted to another recording."""
    return Palette(
        tuple(
            # An older palette may have characters that names must not contain now.
            PaletteLabel(spelled_out(label.name), spelled_out(label.category), label.color)
            for label in workspace.labels.palette(seq)
        )
    )


@router.post("/sequences/{seq}/palette", **needs("annotator", 404, 409, 413))
def add_palette(
    seq: WholeSequence, body: PaletteAddition, workspace: Ws, who: Caller
) -> AddedLabels:
    """Add the missing labels of a file or a template, as one edit."""
    if (body.template is None) == (not body.labels):
        raise BadInputError("template: expected a template or labels, got both or none of them")
    if body.template is not None:
        dataset = dataset_named(body.template)
        return AddedLabels(tuple(add_template(workspace.labels, seq, dataset, who.author)))
    return AddedLabels(tuple(add_labels(workspace.labels, seq, body.labels, who.author)))


@router.get("/sequences/{seq}/categories", **needs("viewer", 404))
def list_categories(seq: WholeSequence, workspace: Ws) -> OfferedCategories:
    """List the categories for labels: the selection of the project, or all categories."""
    return offered(workspace.labels, seq)


@router.put("/sequences/{seq}/palette/order", **needs("annotator", 404, 409, 413))
def arrange_palette(
    seq: WholeSequence, body: PaletteOrder, workspace: Ws, who: Caller, edit: EditId = None
) -> Edit:
    """Order the labels, as one edit."""
    return workspace.labels.arrange_labels(seq, who.author, body.labels, edit_id=edit)
