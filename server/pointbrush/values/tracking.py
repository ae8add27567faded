"""Tracks, results of tracking runs, and events."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pointbrush.values.base import Meanings, Value
from pointbrush.values.edits import Edit, PastEdit
from pointbrush.values.jobs import Job
from pointbrush.values.kinds import FrameIndex, LabelId
from pointbrush.values.matrices import Pose

TrackState = Annotated[
    Literal["tracked", "occluded", "lost", "painted"],
    Meanings(
        {
            "tracked": "found in the frame",
            "occluded": "hidden by something nearer",
            "lost": "not found",
            "painted": "labelled by a person",
        }
    ),
]


@dataclass(frozen=True, slots=True, eq=False)
class Track(Value):
    """A label's track in one frame."""

    label: LabelId
    """Id of the label."""
    frame: FrameIndex
    """Number of the frame."""
    pose: Pose
    """Transform (4, 4) from the start frame to this frame, source coordinates."""
    rmse: float | None
    """Root mean square distance of the inliers, metres; null: not registered."""
    inliers: float
    """Share of the model's points with a point near them, 0 to 1."""
    confidence: float
    """Confidence in the pose, 0 to 1; below 0.5 a person should look."""
    points: int
    """Number of points that got the label."""
    state: TrackState
    """Outcome in this frame."""


@dataclass(frozen=True, slots=True)
class Run(Edit):
    """Result of a tracking run."""

    frames: int
    """Number of frames with new labels."""


@dataclass(frozen=True, slots=True)
class Events(Value):
    """Edits and tracking doubts after a revision, and jobs."""

    revision: int
    """Revision of the last edit: the next call's ``after``."""
    jobs_seen: str
    """Digest of the jobs: the next call's ``jobs_seen``."""
    edits: tuple[PastEdit, ...]
    """Edits after the revision, the oldest first."""
    doubts: tuple[Track, ...]
    """Doubtful tracks in frames that these edits changed."""
    jobs: tuple[Job, ...]
    """Jobs of the recording, the newest first; empty if none has changed."""
