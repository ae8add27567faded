"""Oriented boxes of labels over frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

from pointbrush.values.base import Body, Complete, Limits, Meanings, Rule, Value
from pointbrush.values.kinds import (
    Finite,
    FrameRange,
    PaintId,
    Quaternion,
    Sides,
    Uuid,
    Vector,
)
from pointbrush.values.taxonomy import MOST_ATTRIBUTES, NAME_LIMIT, TEXT_LIMIT

AttributeName = Annotated[str, Rule(min_length=1, max_length=NAME_LIMIT)]
AttributeValue = Annotated[str, Rule(max_length=TEXT_LIMIT)] | Finite | bool
Attributes = Annotated[Mapping[AttributeName, AttributeValue], Limits(max_length=MOST_ATTRIBUTES)]
ChangedAttributes = Annotated[
    Mapping[AttributeName, AttributeValue | None], Limits(max_length=MOST_ATTRIBUTES)
]
FrameKey = Annotated[str, Limits(pattern=r"^(0|[1-9][0-9]{0,8})$")]
Confidence = Annotated[float, Rule(ge=0, le=1, allow_inf_nan=False)]
BoxProvenance = Annotated[
    Literal["fitted", "drawn", "imported"],
    Meanings(
        {
            "fitted": "fitted to the label's points",
            "drawn": "drawn or moved by a person",
            "imported": "read from a file",
        }
    ),
]


@dataclass(frozen=True, slots=True)
class BoxPose(Complete):
    """Pose of a box in one frame."""

    centre: Vector
    """Centre of the box, source coordinates, metres."""
    quaternion: Quaternion
    """x, y, z, w: from the box's axes (x forward, y left, z up) to the axes of the frame."""
    provenance: BoxProvenance = "drawn"
    """Origin of the pose."""
    confidence: Confidence = 1.0
    """Confidence in the pose, 0 to 1."""
    attributes: Attributes = field(default_factory=dict)
    """Attributes in this frame, by name; they take precedence over the box's."""


@dataclass(frozen=True)
class _Numbered(Value):
    id: Annotated[int, Rule(ge=1, lt=2**31)]
    """Number of the box, never given to another box of the recording."""


@dataclass(frozen=True)
class BoxFields(Complete):
    """Fields of a box: one size, and a pose in each of its frames."""

    label: PaintId
    """Id of the label."""
    size: Sides
    """Length, width and height along the box's x, y and z, metres."""
    poses: Annotated[Mapping[FrameKey, BoxPose], Limits(min_length=1)]
    """Pose in each frame, by the frame's number."""
    attributes: Attributes = field(default_factory=dict)
    """Attributes of the box in all frames, by name."""
    provenance: BoxProvenance = "drawn"
    """Origin of the box."""
    heading_known: bool = True
    """False: the front of the object may also be at the opposite end of the box."""


@dataclass(frozen=True)
class Box(BoxFields, _Numbered):
    """An oriented box of a label."""


@dataclass(frozen=True)
class NewBox(BoxFields, Body):
    """A new box."""

    edit: Uuid | None = None
    """UUID of the edit, which is applied once."""


@dataclass(frozen=True, slots=True)
class PosePatch(Body):
    """Changes of a pose; missing fields and null do not change it."""

    centre: Vector | None = None
    """New centre, source coordinates, metres; counts as drawn."""
    quaternion: Quaternion | None = None
    """New rotation x, y, z, w; counts as drawn."""
    provenance: BoxProvenance | None = None
    """New origin of the pose."""
    confidence: Confidence | None = None
    """New confidence in the pose, 0 to 1."""
    attributes: ChangedAttributes = field(default_factory=dict)
    """Attributes in this frame by name; null removes one, others do not change."""


@dataclass(frozen=True, slots=True)
class BoxPatch(Body):
    """Changes of a box; missing fields do not change it."""

    label: PaintId | None = None
    """Id of its new label."""
    size: Sides | None = None
    """New length, width and height, metres."""
    poses: Mapping[FrameKey, PosePatch | None] = field(default_factory=dict)
    """Changes of poses by frame; null removes one, others do not change."""
    attributes: ChangedAttributes = field(default_factory=dict)
    """Attributes by name; null removes one, others do not change."""
    provenance: BoxProvenance | None = None
    """New origin of the box."""
    heading_known: bool | None = None
    """False: the front of the object may also be at the opposite end of the box."""
    edit: Uuid | None = None
    """UUID of the edit, which is applied once."""


@dataclass(frozen=True, slots=True)
class BoxPoints(Body):
    """Frames in which to label the points inside a box."""

    frames: FrameRange | None = None
    """Frames ``I:J``; null: all frames with a pose of the box."""
    only_unlabeled: bool = False
    """Points with another label keep it."""
    edit: Uuid | None = None
    """UUID of the edit, which is applied once."""


@dataclass(frozen=True, slots=True)
class BoxFit(Body):
    """Labels to fit boxes to."""

    labels: Annotated[tuple[PaintId, ...], Rule(max_length=65535)] | None = None
    """Ids of labels; null: all labels."""
    category: Annotated[str, Rule(max_length=256)] | None = None
    """Only labels of this category; null: of any."""
    frames: FrameRange | None = None
    """Frames ``I:J``; null: all frames."""
    redraw: bool = False
    """Also replace poses that a person has drawn."""
    id: Uuid | None = None
    """UUID of the job and of its edit: a repeated call does not begin another job."""


@dataclass(frozen=True, slots=True)
class Boxes(Value):
    """The boxes of a recording."""

    boxes: tuple[Box, ...]
    """Boxes by id, with all their poses."""
    revision: int
    """Revision of the recording."""


@dataclass(frozen=True, slots=True)
class BoxEdit(Value):
    """A box after its edit, which is durable."""

    box: Box
    """The box."""
    edit: str
    """UUID of the edit."""
    revision: int
    """Revision of the recording after the edit."""


@dataclass(frozen=True, slots=True)
class FittedBoxes(Value):
    """Result of a fit of boxes, which is one edit."""

    edit: str | None
    """UUID of the edit; null: no box was fitted."""
    fitted: tuple[int, ...]
    """Ids of the fitted boxes."""
    skipped: Mapping[str, str]
    """Reason for each skipped label, by its id."""
