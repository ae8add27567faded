"""Tracking runs to start, and decisions about their labels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pointbrush.values.base import Body, Meanings, Value
from pointbrush.values.kinds import FrameIndex, PaintIds, Uuid

Overwrite = Annotated[
    Literal["never", "tracked", "all"],
    Meanings(
        {
            "never": "unlabeled points only",
            "tracked": "also tracked and predicted points",
            "all": "also painted points",
        }
    ),
]


@dataclass(frozen=True)
class TrackingOptions(Value):
    """Options of a tracking run; fields of ``TrackOptions`` are passed to the method."""

    method: str = "auto"
    """Method: ``auto``, ``icp``, ``color-icp`` or the name of a plug-in."""
    overwrite: Overwrite = "tracked"
    """Labelled points that the run may replace."""
    continue_lost: bool = False
    """Search for a lost label in later frames instead of ending it."""
    until_painted: bool = False
    """End a label at the next frame in which it is painted."""
    stop_unsure: bool = False
    """End the run at a frame with a doubtful label."""


@dataclass(frozen=True, kw_only=True)
class TrackingRequest(TrackingOptions, Body):
    """A tracking run, which is one edit."""

    start: FrameIndex
    """First frame, which has the labels."""
    stop: FrameIndex
    """Last frame; below ``start``: the run goes backward."""
    labels: PaintIds | None = None
    """Ids of the labels; null: all labels with points in the first frame."""
    id: Uuid | None = None
    """UUID of the job and of its edit: a repeated call does not begin another run."""


@dataclass(frozen=True, slots=True)
class Acceptance(Body):
    """Labels of a frame that a person accepts."""

    labels: PaintIds
    """Ids of the labels."""
    id: Uuid | None = None
    """UUID of the edit, which is applied once."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretch(Acceptance):
    """Labels in a range of frames."""

    start: FrameIndex
    """One end of the range."""
    stop: FrameIndex
    """Other end of the range, included."""

    @property
    def frames(self) -> range:
        """The frames, ascending."""
        return range(min(self.start, self.stop), max(self.start, self.stop) + 1)


@dataclass(frozen=True, slots=True)
class Copying(Body):
    """Labels to copy from another frame."""

    labels: PaintIds
    """Ids of the labels."""
    source: FrameIndex
    """Number of the frame that has the labels."""
    id: Uuid | None = None
    """UUID of the edit, which is applied once."""


@dataclass(frozen=True, slots=True)
class Clearing(Body):
    """Labels to remove from their points."""

    labels: PaintIds
    """Ids of the labels."""
    stop: FrameIndex | None = None
    """Last frame of the range, included; null: only this frame."""
    id: Uuid | None = None
    """UUID of the edit, which is applied once."""
