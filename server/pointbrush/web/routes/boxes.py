"""Oriented boxes of labels over frames: each change is one edit."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import Path, Query, Response
from pydantic import BaseModel, Field

from pointbrush.geometry.oriented_box import BoxProvenance
from pointbrush.labels import Made
from pointbrush.labels.boxes.maps import MOST_ATTRIBUTES, box_of
from pointbrush.streaming.encoding import box_message
from pointbrush.streaming.messages import (
    AttributeName,
    AttributeValue,
    Box,
    FrameIndex,
    Quaternion,
    Uuid,
    Vec3,
)
from pointbrush.web.auth import Caller, resource
from pointbrush.web.context import SequenceId, WholeSequence, Ws
from pointbrush.web.problems import responses
from pointbrush.web.schemas import Body, EditOut, PaintId, Sides
from pointbrush.web.schemas_work import JobOut

router = resource("boxes")
BoxPath = Annotated[int, Path(ge=1, lt=2**31, description="box id")]
FrameKey = Annotated[str, Field(pattern=r"^(0|[1-9][0-9]{0,8})$", description="frame number")]
Attributes = Annotated[dict[AttributeName, AttributeValue], Field(max_length=MOST_ATTRIBUTES)]
Merged = Annotated[dict[AttributeName, AttributeValue | None], Field(max_length=MOST_ATTRIBUTES)]
Confidence = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]


class PoseBody(Body):
    """Pose of a box in a frame: centre and rotation in source coordinates."""

    centre: Vec3
    quaternion: Quaternion
    provenance: BoxProvenance = "drawn"
    confidence: Confidence = 1.0
    attributes: Attributes = Field(default_factory=dict)


class BoxBody(Body):
    """A new box; ``edit``: the edit's UUID, which is applied once."""

    label: PaintId
    size: Sides
    poses: Annotated[dict[FrameKey, PoseBody], Field(min_length=1)]
    attributes: Attributes = Field(default_factory=dict)
    provenance: BoxProvenance = "drawn"
    heading_known: bool = True
    edit: Uuid | None = None


class PoseChange(Body):
    """Changes of a pose; missing fields do not change, a given position counts as *drawn*."""

    centre: Vec3 | None = None
    quaternion: Quaternion | None = None
    provenance: BoxProvenance | None = None
    confidence: Confidence | None = None
    attributes: Merged = Field(default_factory=dict)


class BoxChange(Body):
    """Changes of a box: poses are merged by frame, attributes by name; null removes one."""

    label: PaintId | None = None
    size: Sides | None = None
    poses: dict[FrameKey, PoseChange | None] = Field(default_factory=dict)
    attributes: Merged = Field(default_factory=dict)
    provenance: BoxProvenance | None = None
    heading_known: bool | None = None
    edit: Uuid | None = None

    def asked(self) -> dict[str, Any]:
        """Return the given fields as a change, without nulls that remove nothing."""
        given = self.model_dump(exclude_unset=True, exclude={"edit"})
        poses = given.pop("poses", {})
        plain = {name: value for name, value in given.items() if value is not None}
        return plain | {"poses": {frame: pose and _given(pose) for frame, pose in poses.items()}}


def _given(pose: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in pose.items() if value is not None}


class PointsBody(Body):
    """Frames ``I:J`` in which to label points; null: all frames with a pose of the box."""

    frames: Annotated[str, Field(pattern=r"^[0-9]{0,9}(:[0-9]{0,9})?$")] | None = None
    only_unlabeled: bool = False
    edit: Uuid | None = None


class FitBody(Body):
    """Labels to fit boxes to (by default all), a category of labels, frames ``I:J``.

    ``redraw``: also replace drawn boxes.  ``id``: the UUID of the job and of its edit.
    """

    labels: Annotated[list[PaintId], Field(max_length=65535)] | None = None
    category: Annotated[str, Field(max_length=256)] | None = None
    frames: Annotated[str, Field(pattern=r"^[0-9]{0,9}(:[0-9]{0,9})?$")] | None = None
    redraw: bool = False
    id: Uuid | None = None


class BoxesOut(BaseModel):
    """Boxes, and the revision of the recording."""

    boxes: list[Box]
    revision: int


class BoxEditOut(BaseModel):
    """A box after its edit, which is durable."""

    box: Box
    edit: str
    revision: int

    @classmethod
    def of(cls, made: Made) -> BoxEditOut:
        """Return the answer for the store's result."""
        commit = made.commit
        return cls(box=box_message(made.box), edit=commit.edit_id, revision=commit.revision)


@router.get("/sequences/{seq}/boxes", responses=responses(404))
def list_boxes(
    seq: WholeSequence,
    workspace: Ws,
    frame: Annotated[
        FrameIndex | None, Query(description="boxes with a pose in this frame")
    ] = None,
    label: Annotated[PaintId | None, Query(description="boxes of this label")] = None,
) -> BoxesOut:
    """List the boxes of a recording with all their poses."""
    found = workspace.labels.boxes.listing(seq, frame=frame, label=label)
    return BoxesOut(boxes=[box_message(box) for box in found.boxes], revision=found.revision)


@router.post("/sequences/{seq}/boxes", status_code=201, responses=responses(404, 409, 413))
def add_box(
    seq: WholeSequence, body: BoxBody, response: Response, workspace: Ws, who: Caller
) -> BoxEditOut:
    """Add a box; its frames and its label must exist, and the label must not be locked (409)."""
    box = box_of(0, body.model_dump(exclude={"edit"}))
    made = workspace.labels.boxes.add(seq, who.author, box, edit_id=body.edit)
    response.headers["Location"] = f"/api/v1/sequences/{seq}/boxes/{made.box.id}"
    return BoxEditOut.of(made)


@router.post("/sequences/{seq}/boxes/fit", status_code=202, responses=responses(404, 409))
def fit_boxes(
    seq: SequenceId, body: FitBody, response: Response, workspace: Ws, who: Caller
) -> JobOut:
    """Fit a box to the points of each label over frames, in a job; the result is one edit.

    The result of the job: ``edit``, ids of ``fitted`` boxes, and ``skipped`` labels with reasons.
    """
    given = body.model_dump(exclude={"id"})
    job = workspace.fitting.fit(seq, author=who.author, edit=body.id, **given)
    response.headers["Location"] = f"/api/v1/jobs/{job.id}"
    return JobOut.of(job)


@router.get("/sequences/{seq}/boxes/{id}", responses=responses(404))
def get_box(seq: WholeSequence, id: BoxPath, workspace: Ws) -> Box:
    """Return a box."""
    return box_message(workspace.labels.boxes.get(seq, id))


@router.patch("/sequences/{seq}/boxes/{id}", responses=responses(404, 409, 413))
def change_box(
    seq: WholeSequence, id: BoxPath, body: BoxChange, workspace: Ws, who: Caller
) -> BoxEditOut:
    """Move, turn or resize a box, or change its label or attributes."""
    boxes = workspace.labels.boxes
    return BoxEditOut.of(boxes.change(seq, who.author, id, body.asked(), edit_id=body.edit))


@router.delete("/sequences/{seq}/boxes/{id}", responses=responses(404, 409))
def delete_box(
    seq: WholeSequence,
    id: BoxPath,
    workspace: Ws,
    who: Caller,
    edit: Annotated[Uuid | None, Query(description="the edit's UUID")] = None,
) -> EditOut:
    """Remove a box."""
    return EditOut.of(workspace.labels.boxes.remove(seq, who.author, id, edit_id=edit))


@router.post("/sequences/{seq}/boxes/{id}/points", responses=responses(404, 409, 413))
def paint_box(
    seq: SequenceId, id: BoxPath, body: PointsBody, workspace: Ws, who: Caller
) -> EditOut:
    """Give the points inside a box its label, in frames that have a pose of it; one edit."""
    return EditOut.of(
        workspace.boxes.paint(
            seq,
            id,
            who.author,
            frames=body.frames,
            only_unlabeled=body.only_unlabeled,
            edit=body.edit,
        )
    )
