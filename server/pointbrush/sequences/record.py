"""Records of stored frames, and the manifest made of them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.frame import FramePart, PointFrame, Sensor, frame_of_part, has_camera_axes
from pointbrush.sequences.columns import POINT_FIELDS
from pointbrush.sequences.depth.lattice import DEPTH_FORMAT, GRID_CELLS, GRID_ROUNDING
from pointbrush.sequences.octree.coordinates import Coordinates
from pointbrush.sequences.octree.order import bounds
from pointbrush.sequences.room import RoomFinder
from pointbrush.sequences.storage.manifest import Manifest, now
from pointbrush.sequences.storage.sensors import IDENTITY, StoredSensor, require_rigid
from pointbrush.sequences.wire.chunk import SENSOR_CHUNK, Grid

_PREFIX = 4096


class FrameOrigin(Protocol):
    """The file that a frame came from, and its place among the frames of that file."""

    @property
    def file(self) -> str: ...  # noqa: D102
    @property
    def place(self) -> int: ...  # noqa: D102


@dataclass(frozen=True, slots=True, eq=False)
class PartRecord:
    """Record of the points of one of several sensors; ``lo`` and ``hi`` in its coordinates."""

    part: FramePart
    count: int
    lo: NDArray[np.float64]
    hi: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """Record of one stored frame for the manifest."""

    count: int
    fields: tuple[str, ...]
    lo: NDArray[np.float64]
    hi: NDArray[np.float64]
    error: float
    side_error: float
    color_error: float
    prefix: NDArray[np.float32]
    pose: list[float] | None
    viewpoint: list[float] | None
    timestamp: float | None
    dropped: int
    large: bool
    checksums: dict[str, str]
    sensors: tuple[Sensor, ...]
    parts: tuple[PartRecord, ...]


def record(
    frame: PointFrame,
    arrays: Mapping[str, NDArray[Any]],
    xyz: NDArray[np.float32] | Coordinates,
    error: float,
    checksums: dict[str, str],
    *,
    dropped: int,
    large: bool,
) -> Record:
    """Describe stored ``arrays``; ``frame``, or its first part, gives pose, sensor and time.

    ``xyz`` are the points' local coordinates.  The first of several sensors gives the viewpoint of
    a frame without one.
    """
    viewpoint = frame.viewpoint
    if viewpoint is None and frame.parts:
        viewpoint = frame.parts[0].T_frame_sensor[:3, 3]
    chunks = arrays["chunks"]
    count, none = len(arrays["source_index"]), np.full(3, np.nan)
    return Record(
        count=count,
        fields=("xyz", *(name for name in POINT_FIELDS if _says_something(name, arrays))),
        lo=chunks["lo"].min(axis=0).astype(np.float64) if count else none,
        hi=chunks["hi"].max(axis=0).astype(np.float64) if count else none,
        error=error,
        side_error=0.0,
        color_error=0.0,
        prefix=xyz[: _prefix(chunks)].copy(),
        pose=None if frame.pose is None else frame.pose.ravel().tolist(),
        viewpoint=None if viewpoint is None else viewpoint.tolist(),
        timestamp=None if frame.timestamp is None else float(frame.timestamp),
        dropped=dropped,
        large=large,
        checksums=checksums,
        sensors=frame.sensors,
        parts=tuple(_part_record(frame, part) for part in frame.parts),
    )


def _part_record(frame: PointFrame, part: FramePart) -> PartRecord:
    own = frame_of_part(frame, part).xyz
    none = np.full(3, np.nan)
    lo, hi = bounds(own) if len(own) else (none, none)  # type: ignore[arg-type]  # or float64
    return PartRecord(part, len(own), lo.astype(np.float64), hi.astype(np.float64))


def _position_error(records: list[Record], grid: Grid, extent: float) -> float:
    """Return the greatest error of all frames; the page rounds points of depth images again.

    It rounds all points of several sensors, after it has turned them, which mixes the axes.
    """
    error = max((record.error for record in records), default=0.0)
    side_error = max((record.side_error for record in records), default=0.0)
    rounded = GRID_ROUNDING * extent / GRID_CELLS
    if records[0].sensors:
        return math.sqrt(3) * max(error, side_error) + rounded
    return error if grid.lattice is None else max(error, side_error + rounded)


def _prefix(chunks: NDArray[Any]) -> int:
    """Count the first points that are an even subsample: few points of whole chunks."""
    stops = chunks["first"] + chunks["count"]
    if chunks.dtype == SENSOR_CHUNK:
        return int(stops[chunks["level"] == 0].max(initial=0))
    few = stops[stops <= _PREFIX]
    return int(few.max(initial=0)) or _PREFIX


def _says_something(name: str, arrays: Mapping[str, NDArray[Any]]) -> bool:
    """Return whether a frame has a field; labels that are all 0 count as no field."""
    return name in arrays and (name != "label" or bool(arrays[name].any()))


@dataclass(frozen=True, slots=True, eq=False)
class RecordingInfo:
    """Data of a new recording beside its frames, for its manifest.

    Raises BadInputError for a rate that is not positive.
    """

    id: str
    name: str
    fps: float = 1.0
    source: str = ""
    up: str | None = None
    """Axis ("x", "-x", … "-z") that points up, if it is known."""
    classes: Sequence[str] = ()
    """Names of the labels 1, 2, …"""
    origins: Sequence[FrameOrigin] = ()
    """Files of the frames; they may be added while the frames are read."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.fps) and self.fps > 0):
            raise BadInputError(f"fps: expected a positive number, got {self.fps}")


def make_manifest(records: list[Record], grid: Grid, info: RecordingInfo) -> Manifest:
    """Return the manifest of a sequence of these frames, in their order."""
    filled = [record for record in records if record.count]
    lo = np.min([record.lo for record in filled], axis=0) if filled else np.zeros(3)
    hi = np.max([record.hi for record in filled], axis=0) if filled else np.zeros(3)
    present = {field for record in records for field in record.fields}
    finder = RoomFinder(grid.shift, info.up)
    for record in records:
        viewpoint = None if record.viewpoint is None else np.array(record.viewpoint)
        finder.add(record.prefix, viewpoint)
    room = finder.room(camera=_in_camera_axes(records, present)).ravel().tolist()
    return Manifest(
        id=info.id,
        name=info.name,
        frames=len(records),
        fps=float(info.fps),
        points=[record.count for record in records],
        fields=[field for field in ("xyz", *POINT_FIELDS) if field in present],
        shift=grid.shift.tolist(),
        lo=lo.tolist(),
        hi=hi.tolist(),
        room=room,
        found_room=room,
        position_error=_position_error(records, grid, float((hi - lo).max())),
        color_error=max((record.color_error for record in records), default=0.0),
        lattice=grid.lattice,
        depth_format=DEPTH_FORMAT,
        intensity_range=None if grid.intensity_range is None else list(grid.intensity_range),
        dropped=[record.dropped for record in records],
        poses=[record.pose for record in records],
        timestamps=[record.timestamp for record in records],
        viewpoints=[record.viewpoint for record in records],
        source=info.source,
        large=any(record.large for record in records),
        created=now(),
        imported_as=info.id,
        classes=list(info.classes),
        files=[origin.file for origin in info.origins],
        places=[origin.place for origin in info.origins],
        dataset="",
        palette=[],
        scale=1.0,
        project="",
        sensors=[_sensor(number, records, grid) for number in range(len(records[0].sensors))],
    )


def _in_camera_axes(records: list[Record], present: set[str]) -> bool:
    """Return whether frames have the axes of a depth camera, see ``frame.has_camera_axes``."""
    if not records[0].sensors:
        return "pixel" in present
    first = next((record.parts[0].part for record in records if record.parts), None)
    return first is not None and has_camera_axes(records[0].sensors[0], first.T_frame_sensor)


def _sensor(number: int, records: list[Record], grid: Grid) -> StoredSensor:
    """Return one of several sensors for the manifest.

    Frames without points of it have the mount of the frame before them.
    """
    if any(record.sensors != records[0].sensors for record in records):
        raise BadInputError("sensors: expected the same in all frames")
    parts = [
        next((part for part in record.parts if part.part.sensor == number), None)
        for record in records
    ]
    known = [part for part in parts if part is not None]
    name = records[0].sensors[number].name
    last = known[0].part.T_frame_sensor if known else np.eye(4)
    mounts = []
    for part in parts:
        last = last if part is None else part.part.T_frame_sensor
        mounts.append(require_rigid(f"mount of {name}", last))
    seen = [part for part in known if part.count]
    return StoredSensor(
        name=name,
        type=records[0].sensors[number].type,
        lattice=grid.lattices[number] if grid.lattices else None,
        mounts=mounts if any(mount != mounts[0] for mount in mounts) else mounts[:1],
        times=[None if part is None else part.part.timestamp for part in parts],
        points=[0 if part is None else part.count for part in parts],
        lo=np.min([part.lo for part in seen], axis=0).tolist() if seen else [0.0] * 3,
        hi=np.max([part.hi for part in seen], axis=0).tolist() if seen else [0.0] * 3,
        correction=IDENTITY,
    )
