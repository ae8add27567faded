"""Named versions of a project's labels, and their differences."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Literal

from pointbrush.values.base import Body, Meanings, Value
from pointbrush.values.kinds import Name

DifferenceKind = Annotated[
    Literal["came", "went", "changed"],
    Meanings(
        {
            "came": "the label was added",
            "went": "the label was removed",
            "changed": "the label has another name, category or colour",
        }
    ),
]


@dataclass(frozen=True, slots=True)
class NewSnapshot(Body):
    """A version to create of the current labels."""

    name: Name
    """Text that people see."""


@dataclass(frozen=True, slots=True)
class Snapshot(Value):
    """A version of a project's labels."""

    id: str
    """Name in URLs."""
    name: str
    """Text that people see."""
    created: datetime
    """Time of the version."""
    author: str
    """Name of the person who created it."""
    recordings: Mapping[str, int]
    """Revision of each recording at its time, by id."""


@dataclass(frozen=True, slots=True)
class LabelDifference(Value):
    """A label that differs between two versions."""

    label: int
    """Id of the label."""
    name: str
    """Name in the later version that has it."""
    kind: DifferenceKind
    """Kind of difference."""


@dataclass(frozen=True, slots=True)
class FrameDifference(Value):
    """Points of a frame that differ between two versions."""

    frame: int
    """Number of the frame."""
    came: int
    """Number of points that got a label."""
    went: int
    """Number of points that lost their label."""
    changed: int
    """Number of points with another label."""
    objects_came: tuple[int, ...]
    """Ids of labels with points in the later version alone."""
    objects_went: tuple[int, ...]
    """Ids of labels with points in the earlier version alone."""


@dataclass(frozen=True, slots=True)
class Difference(Value):
    """Difference of a recording's labels between two versions; equal parts are left out."""

    sequence: str
    """Id of the recording."""
    labels: tuple[LabelDifference, ...]
    """Labels that differ."""
    frames: tuple[FrameDifference, ...]
    """Frames with points that differ."""
