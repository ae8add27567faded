"""Frames: wire chunks, camera pictures, and placements of neighbouring frames."""

from __future__ import annotations

from dataclasses import dataclass

from pointbrush.values.base import Value
from pointbrush.values.kinds import Vector
from pointbrush.values.matrices import Pose, Rows


@dataclass(frozen=True, slots=True)
class Chunk(Value):
    """One row of a frame's chunk table; a point is at ``origin + q * scale``, local metres."""

    index: int
    """Number of the chunk in the frame, from 0."""
    level: int
    """Level of detail, 0 the coarsest."""
    first: int
    """Stored number of its first point."""
    count: int
    """Number of its points."""
    offset: int
    """Place of its bytes in the frame's wire file, bytes."""
    nbytes: int
    """Length of its bytes."""
    origin: Vector
    """Position of the quantised point 0, 0, 0."""
    scale: Vector
    """Metres per step of a quantised coordinate."""
    lo: Vector
    """Corner of its points with the smallest x, y and z, local metres."""
    hi: Vector
    """Corner of its points with the greatest x, y and z, local metres."""
    parent: int
    """Number of the chunk above in an octree; -1: none."""
    sensor: int | None = None
    """Number of the sensor of its points, in whose coordinates ``origin`` and ``scale`` are; null:
    the recording has one sensor."""


@dataclass(frozen=True, slots=True)
class ChunkTable(Value):
    """All chunks of a frame."""

    frame: int
    """Number of the frame."""
    points: int
    """Number of its points."""
    identity: str
    """Id of the import, which makes the URL of a chunk unique for ever."""
    chunks: tuple[Chunk, ...]
    """Its chunks in stored order."""


@dataclass(frozen=True, slots=True, eq=False)
class Camera(Value):
    """A camera with a picture; a point p in source coordinates is at ``K (T_camera_frame p)``."""

    name: str
    """Name of the camera in URLs."""
    width: int
    """Width of the picture, pixels."""
    height: int
    """Height of the picture, pixels."""
    K: Rows | None
    """Matrix (3, 3) to pixels; null: unknown."""
    distortion: tuple[float, ...]
    """Coefficients of ``model``; none: the picture is rectified."""
    model: str
    """Model of the lens, such as ``plumb_bob`` with k1, k2, p1, p2, k3."""
    T_camera_frame: Rows | None
    """Transform (4, 4) to the camera: x right, y down, z forward; null: unknown."""


@dataclass(frozen=True, slots=True, eq=False)
class Moving(Value):
    """Placement of a tracked label's points."""

    label: int
    """Id of the label."""
    T_shown_frame: Pose
    """Transform to the shown frame by the label's track, source coordinates."""


@dataclass(frozen=True, slots=True, eq=False)
class Placement(Value):
    """Placement of a frame over the shown one."""

    frame: int
    """Number of the frame."""
    T_shown_frame: Pose
    """Transform to the shown frame by the poses of the recording, source coordinates."""
    moving: tuple[Moving, ...]
    """Labels with points that their tracks place elsewhere."""
