"""Oriented boxes of labels over frames: each change is one edit."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Annotated, Any

from fastapi import Path, Query, Response

from pointbrush.labels import Made
from pointbrush.labels.boxes.maps import box_of, box_value
from pointbrush.values.base import Body
from pointbrush.values.boxes import Box, BoxEdit, Boxes, BoxFit, BoxPatch, BoxPoints, NewBox
from pointbrush.values.edits import Edit
from pointbrush.values.jobs import Job
from pointbrush.values.kinds import FrameIndex, PaintId
from pointbrush.web.context import EditId, SequenceId, WholeSequence, Ws
from pointbrush.web.security.auth import Caller, resource
from pointbrush.web.security.roles import needs

router = resource("boxes")
BoxPath = Annotated[int, Path(ge=1, lt=2**31, description="box id")]


@router.get("/sequences/{seq}/boxes", **needs("viewer", 404))
def list_boxes(
    seq: WholeSequence,
    workspace: Ws,
    frame: Annotated[
        FrameIndex | None, Query(description="boxes with a pose in this frame")
    ] = None,
    label: Annotated[PaintId | None, Query(description="boxes of this label")] = None,
) -> Boxes:
    """List the boxes of a recording with all their poses."""
    found = workspace.labels.boxes.listing(seq, frame=frame, label=label)
    return Boxes(tuple(map(box_value, found.boxes)), found.revision)


@router.post("/sequences/{seq}/boxes", status_code=201, **needs("annotator", 404, 409, 413))
def add_box(
    seq: WholeSequence, body: NewBox, response: Response, workspace: Ws, who: Caller
) -> BoxEdit:
    """Add a box; its frames and its label must exist, and the label must not be locked (409)."""
    box = box_of(0, _without(body, "edit"))
    made = workspace.labels.boxes.add(seq, who.author, box, edit_id=body.edit)
    response.headers["Location"] = f"/api/v1/sequences/{seq}/boxes/{made.box.id}"
    return _edited(made)


@router.post("/sequences/{seq}/boxes/fit", status_code=202, **needs("annotator", 404, 409))
def fit_boxes(seq: SequenceId, body: BoxFit, response: Response, workspace: Ws, who: Caller) -> Job:
    """Fit a box to the points of each label over frames, in a job; the result is one edit.

    The result of the job: ``edit``, ids of ``fitted`` boxes, and ``skipped`` labels with reasons.
    """
    job = workspace.fitting.fit(seq, body, who.author)
    response.headers["Location"] = f"/api/v1/jobs/{job.id}"
    return job


@router.get("/sequences/{seq}/boxes/{id}", **needs("viewer", 404))
def get_box(seq: WholeSequence, id: BoxPath, workspace: Ws) -> Box:
    """Return a box."""
    return box_value(workspace.labels.boxes.get(seq, id))


@router.patch("/sequences/{seq}/boxes/{id}", **needs("annotator", 404, 409, 413))
def change_box(
    seq: WholeSequence, id: BoxPath, body: BoxPatch, workspace: Ws, who: Caller
) -> BoxEdit:
    """Move, turn or resize a box, or change its label or attributes."""
    boxes = workspace.labels.boxes
    return _edited(boxes.change(seq, who.author, id, _change(body), edit_id=body.edit))


@router.delete("/sequences/{seq}/boxes/{id}", **needs("annotator", 404, 409))
def delete_box(
    seq: WholeSequence, id: BoxPath, workspace: Ws, who: Caller, edit: EditId = None
) -> Edit:
    """Remove a box."""
    return workspace.labels.boxes.remove(seq, who.author, id, edit_id=edit)


@router.post("/sequences/{seq}/boxes/{id}/points", **needs("annotator", 404, 409, 413))
def paint_box(seq: SequenceId, id: BoxPath, body: BoxPoints, workspace: Ws, who: Caller) -> Edit:
    """Give the points inside a box its label, in frames that have a pose of it; one edit."""
    return workspace.boxes.paint(
        seq,
        id,
        who.author,
        frames=body.frames,
        only_unlabeled=body.only_unlabeled,
        edit=body.edit,
    )


def _edited(made: Made) -> BoxEdit:
    return BoxEdit(box_value(made.box), made.commit.edit, made.commit.revision)


def _without(body: Body, name: str) -> dict[str, Any]:
    """Return the fields of a body without one."""
    return {key: value for key, value in asdict(body).items() if key != name}  # type: ignore[call-overload]


def _change(body: BoxPatch) -> dict[str, Any]:
    """Return the fields to change, without nulls that remove nothing."""
    poses = {frame: pose and pose.to_json() for frame, pose in body.poses.items()}
    return replace(body, edit=None).to_json() | {"poses": poses}
