"""Tracking runs, tracks, and decisions about tracked labels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pointbrush.values.base import Body, Meanings, Value
from pointbrush.values.edits import Edit, PastEdit
from pointbrush.values.jobs import Job
from pointbrush.values.kinds import FrameIndex, LabelId, PaintIds, Uuid
from pointbrush.values.matrices import Pose

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


@dataclass(frozen=True, slots=True)
class TrackingRequest(Body):
    """A tracking run, which is one edit."""

    start: FrameIndex
    """First frame, which has the labels."""
    stop: FrameIndex
    """Last frame; below ``start``: the run goes backward."""
    labels: PaintIds | None = None
    """Ids of the labels; null: all labels with points in the first frame."""
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
