"""Recordings: the list, changes, and placement on the floor."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from pointbrush.values.base import Body, Rule, Value
from pointbrush.values.kinds import Matrix4, Name, SensorType, Vector

Rate = Annotated[float, Rule(gt=0, le=1000, allow_inf_nan=False)]


@dataclass(frozen=True, slots=True)
class Bounds(Value):
    """Axis-aligned bounds over all frames, source coordinates."""

    lo: Vector
    """Corner with the smallest x, y and z, metres."""
    hi: Vector
    """Corner with the greatest x, y and z, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class Sensor(Value):
    """One of several sensors of a recording."""

    name: str
    """Its name in the files, or the one that its import gave it."""
    type: SensorType
    """Its kind."""
    mounts: tuple[Matrix4, ...]
    """Transform from its coordinates to those of a frame, corrections included: one for all frames,
    or one for each."""
    times: tuple[float | None, ...]
    """Time of its measurement in each frame, seconds; null: unknown."""
    points: tuple[int, ...]
    """Number of its points in each frame."""
    correction: Matrix4
    """Part of the mounts that corrects the files': the identity, or a small motion."""


@dataclass(frozen=True, slots=True)
class Manifest(Value):
    """Facts of a recording; a damaged one may have only its id."""

    id: str
    """Name in URLs; another recording may get it after a deletion."""
    name: str
    """Text that people see."""
    frames: int
    """Number of frames."""
    fps: float
    """Frames per second of playback."""
    points: tuple[int, ...]
    """Number of points of each frame."""
    bounds: Bounds
    """Box around the points of all frames."""
    fields: tuple[str, ...]
    """Fields of the points that at least one frame has, such as ``xyz`` and ``rgb``."""
    revision: int
    """Number of edits since the import; every edit adds one."""
    shift: Vector
    """Local coordinates = source coordinates - ``shift``, metres."""
    room: Matrix4
    """Transform from local coordinates to the floor of the page, y up, row by row."""
    position_error: float
    """Greatest error of a streamed coordinate, metres per axis."""
    dropped: tuple[int, ...]
    """Number of invalid points of each frame that the import left out."""
    large: bool
    """Frames are octrees of chunks, which a viewer loads by detail."""
    source: str
    """Name of the imported file or folder."""
    created: datetime | None = None
    """Time of the import."""
    changed: datetime | None = None
    """Time of its last edit, or else of its import."""
    labelled: int = 0
    """Number of frames with labelled points."""
    labels: int = 0
    """Number of labels."""
    labels_used: int = 0
    """Number of labels that have points in some frame."""
    damaged: str | None = None
    """Reason why it cannot be opened; null: intact."""
    labels_missing: str | None = None
    """Reason why the labels in its files were not imported; null: imported, or none."""
    project: str = "default"
    """Id of its project."""
    copy_of: str | None = None
    """Id of the recording of which this is one person's copy; only for reviewers."""
    identity: str | None = None
    """Id of this import; never given to another one."""
    deleted: datetime | None = None
    """Time of its deletion; null: not deleted."""
    until: datetime | None = None
    """End of the time in which it can be restored."""
    sensors: tuple[Sensor, ...] = ()
    """Its sensors, if it has several."""


@dataclass(frozen=True, slots=True)
class RecordingPatch(Body):
    """Changes of a recording; missing fields and null do not change it."""

    name: Name | None = None
    """New text that people see."""
    fps: Rate | None = None
    """Frames per second of playback, at most 1000."""
    room: Matrix4 | None = None
    """Transform from local coordinates to the floor of the page, y up, row by row."""
