"""The palette."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

from fastapi import Query, Response

from pointbrush.labels import Label
from pointbrush.streaming.messages import Uuid
from pointbrush.web.auth import Caller, resource
from pointbrush.web.context import LabelPath, SequenceId, Ws
from pointbrush.web.problems import responses
from pointbrush.web.schemas import (
    EditOut,
    LabelBody,
    LabelOut,
    LabelPatch,
    MergeBody,
    SplitBody,
    SplitOut,
)

router = resource("labels")
EditId = Annotated[
    Uuid | None, Query(description="the edit's UUID: the same one twice is applied once")
]


def _out(label: Label) -> LabelOut:
    return LabelOut(**{name: asdict(label)[name] for name in LabelOut.model_fields})


@router.get("/sequences/{seq}/labels", responses=responses(404))
def list_labels(seq: SequenceId, workspace: Ws) -> list[LabelOut]:
    """All labels of a sequence."""
    return [_out(label) for label in workspace.palette(seq)]


@router.post("/sequences/{seq}/labels", status_code=201, responses=responses(404, 409, 413))
def create_label(
    seq: SequenceId,
    body: LabelBody,
    response: Response,
    workspace: Ws,
    who: Caller,
    edit: EditId = None,
) -> LabelOut:
    """Add a label."""
    label = workspace.create_label(seq, who.author, edit_id=edit, **body.model_dump())
    response.headers["Location"] = f"/api/v1/sequences/{seq}/labels/{label.id}"
    return _out(label)


@router.get("/sequences/{seq}/labels/{id}", responses=responses(404))
def get_label(seq: SequenceId, id: LabelPath, workspace: Ws) -> LabelOut:
    """One label."""
    return _out(workspace.label(seq, id))


@router.patch("/sequences/{seq}/labels/{id}", responses=responses(404, 409, 413))
def update_label(
    seq: SequenceId,
    id: LabelPath,
    body: LabelPatch,
    workspace: Ws,
    who: Caller,
    edit: EditId = None,
) -> LabelOut:
    """Rename, recolour, recategorise, lock or hide a label."""
    fields = {name: value for name, value in body.model_dump().items() if value is not None}
    if not fields:
        return _out(workspace.label(seq, id))
    return _out(workspace.update_label(seq, who.author, id, edit_id=edit, **fields))


@router.delete("/sequences/{seq}/labels/{id}", responses=responses(404, 409))
def delete_label(
    seq: SequenceId, id: LabelPath, workspace: Ws, who: Caller, edit: EditId = None
) -> EditOut:
    """Remove a label; its points become unlabeled in the same edit."""
    return EditOut.of(workspace.delete_label(seq, who.author, id, edit_id=edit))


@router.post("/sequences/{seq}/labels/{id}/merge", responses=responses(404, 409))
def merge_labels(
    seq: SequenceId,
    id: LabelPath,
    body: MergeBody,
    workspace: Ws,
    who: Caller,
    edit: EditId = None,
) -> EditOut:
    """Give all points of other labels to this one, in every frame, and remove them: one edit."""
    return EditOut.of(workspace.merge_labels(seq, who.author, id, body.labels, edit_id=edit))


@router.post("/sequences/{seq}/labels/{id}/split", responses=responses(404, 409))
def split_label(
    seq: SequenceId,
    id: LabelPath,
    body: SplitBody,
    workspace: Ws,
    who: Caller,
    edit: EditId = None,
) -> SplitOut:
    """Give each connected part of a label in a frame a label of its own; the largest keeps it."""
    how = {"gap": body.gap, "least": body.least}
    return SplitOut.done(workspace.split_label(seq, who.author, id, body.frame, edit=edit, **how))
