"""One frame of points in memory: what readers yield and writers take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.values.kinds import MOST_SENSORS, SensorType

FAR = 1024.0
"""Metres; coordinates beyond this need float64: float32 is coarser than 0.1 mm there."""
_ROWS = 1 << 15
"""Points worked on at once, so that temporary arrays stay in the processor's cache."""


@dataclass(frozen=True, slots=True, eq=False)
class DepthCamera:
    """Pinhole intrinsics of an organised frame, in pixels; row-major pixel order."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float


@dataclass(frozen=True, slots=True)
class Sensor:
    """One of several sensors of a recording, with the name that its files or its user gave it."""

    name: str
    type: SensorType = "unknown"


@dataclass(frozen=True, slots=True, eq=False)
class FramePart:
    """The points of one sensor in a frame.

    ``sensor``          number of the sensor in the recording's list, from 0.
    ``T_frame_sensor``  (4, 4) float64, the sensor's mount when the frame was recorded.
    ``timestamp``       seconds, or None.
    ``camera``          intrinsics when the points are the valid pixels of a depth image.
    """

    sensor: int
    T_frame_sensor: NDArray[np.float64]
    timestamp: float | None = None
    camera: DepthCamera | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Scaling:
    """Coordinates as whole numbers: ``whole × scale + offset`` (3,), computed in this order."""

    scale: NDArray[np.float64]
    offset: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PointFrame:
    """N points in the source file's order.

    ``xyz``        (N, 3) float32 or float64, metres, the source's coordinate frame, finite.
    ``rgb``        (N, 3) uint8 or None.
    ``intensity``  (N,) float32 in the source's unit, or None.
    ``label``      (N,) uint16 annotation that came with the source, 0 = unlabeled, or None.
    ``instance``   (N,) uint16 instance number that came with the source, or None.
    ``pose``       (4, 4) float64 ``T_world_frame`` (ego motion), or None.
    ``viewpoint``  (3,) float64 sensor position in the frame's coordinates, or None if unknown.
    ``timestamp``  seconds, or None.
    ``dropped``    number of invalid points (missing pixels) the reader left out.
    ``camera``     intrinsics when the points are the valid pixels of a depth image, with
    ``pixel``      (N,) uint32 row-major pixel index of each point; both or neither.
    ``sensors``    the recording's sensors when it has several, the same in all frames, else ();
    ``parts``      in the order of ``sensor``: those of them with points in this frame, and
    ``sensor``     (N,) uint8 number of each point's sensor, not decreasing.  ``xyz`` are then the
    points in the frame's coordinates, ``camera`` is None and ``pixel`` counts in the part's image.
    ``sensor_xyz`` (N, 3) the points in their sensor's coordinates, bit for bit as in the source.
    ``other``      further fields of the source (N,), in its order and types, for exports.
    ``header``     the source's header as its format keeps it for exports, or None.
    ``rows``       (N,) which row of the source each point was, where some were left out; or None.
    ``scaling``    of the whole numbers that the source has for coordinates, or None.

    Raises BadInputError when shapes, types or values are not as stated.
    """

    xyz: NDArray[np.float32] | NDArray[np.float64]
    rgb: NDArray[np.uint8] | None = None
    intensity: NDArray[np.float32] | None = None
    label: NDArray[np.uint16] | None = None
    instance: NDArray[np.uint16] | None = None
    pose: NDArray[np.float64] | None = None
    viewpoint: NDArray[np.float64] | None = None
    timestamp: float | None = None
    dropped: int = 0
    camera: DepthCamera | None = None
    pixel: NDArray[np.uint32] | None = None
    other: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    header: bytes | None = None
    rows: NDArray[np.int64] | None = None
    scaling: Scaling | None = None
    sensors: tuple[Sensor, ...] = ()
    parts: tuple[FramePart, ...] = ()
    sensor: NDArray[np.uint8] | None = None
    sensor_xyz: NDArray[np.float32] | NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        xyz = self.xyz
        if xyz.ndim != 2 or xyz.shape[1] != 3 or xyz.dtype not in (np.float32, np.float64):
            raise BadInputError(
                f"xyz: expected (N, 3) float32 or float64, got {xyz.shape} {xyz.dtype}"
            )
        finite = np.isfinite(xyz)
        # By rows only once something is wrong: NumPy reduces along short rows slowly.
        if not finite.all():
            bad = np.flatnonzero(~finite.all(axis=1))
            raise BadInputError(
                f"xyz: expected finite coordinates, got {bad.size} of {len(xyz)} points with "
                f"NaN or infinity (first at point {bad[0]})"
            )
        n = len(xyz)
        columns: tuple[tuple[str, NDArray[np.generic] | None, tuple[int, ...], type], ...] = (
            ("rgb", self.rgb, (n, 3), np.uint8),
            ("intensity", self.intensity, (n,), np.float32),
            ("label", self.label, (n,), np.uint16),
            ("instance", self.instance, (n,), np.uint16),
            ("pixel", self.pixel, (n,), np.uint32),
            ("pose", self.pose, (4, 4), np.float64),
            ("viewpoint", self.viewpoint, (3,), np.float64),
            ("rows", self.rows, (n,), np.int64),
            ("sensor", self.sensor, (n,), np.uint8),
        )
        for name, array, shape, dtype in columns:
            if array is not None and (array.shape != shape or array.dtype != dtype):
                raise BadInputError(
                    f"{name}: expected {shape} {np.dtype(dtype)}, got {array.shape} {array.dtype}"
                )
        for name, values in self.other.items():
            if values.shape != (n,):
                raise BadInputError(f"{name}: expected ({n},) values, got {values.shape}")
        if self.sensor is not None:
            self._require_parts(self.sensor)
        elif (self.camera is None) != (self.pixel is None):
            raise BadInputError("camera and pixel: expected both or neither")

    def _require_parts(self, sensor: NDArray[np.uint8]) -> None:
        """Raise BadInputError unless sensors, parts and each point's sensor fit together."""
        numbers = [part.sensor for part in self.parts]
        if numbers != sorted(set(numbers)) or not set(numbers) <= set(range(len(self.sensors))):
            raise BadInputError(
                f"parts: expected increasing numbers below {len(self.sensors)}, got {numbers}"
            )
        if len(self.sensors) > MOST_SENSORS:
            raise BadInputError(f"expected {MOST_SENSORS} sensors at most, got {len(self.sensors)}")
        present = np.unique(sensor).tolist()
        if not set(present) <= set(numbers) or (np.diff(sensor.astype(np.int16)) < 0).any():
            raise BadInputError(f"sensor: expected {numbers}, in this order, got {present}")
        if self.sensor_xyz is None or self.sensor_xyz.shape != self.xyz.shape:
            raise BadInputError(f"sensor_xyz: expected {self.xyz.shape} coordinates")

    def __len__(self) -> int:
        return len(self.xyz)

    @property
    def in_camera_axes(self) -> bool:
        """Whether the points have the axes of a depth camera: x right, y down, z ahead."""
        if not self.parts:
            return self.pixel is not None
        return has_camera_axes(self.sensors[0], self.parts[0].T_frame_sensor)


def has_camera_axes(reference: Sensor, T_frame_sensor: NDArray[np.float64]) -> bool:
    """Return whether frames have the axes of their first sensor, and it is a depth camera."""
    return reference.type == "depth" and np.array_equal(T_frame_sensor[:3, :3], np.eye(3))


def to_frame(
    sensor_xyz: NDArray[Any], T_frame_sensor: NDArray[np.float64], dtype: np.dtype[Any]
) -> NDArray[Any]:
    """Return points (N, 3) of a sensor in the frame's coordinates, as ``dtype``.

    Each operation is a separate one of float64, so that all processors get the same bits.
    """
    T, out = T_frame_sensor, np.empty(sensor_xyz.shape, dtype)
    for start in range(0, len(sensor_xyz), _ROWS):
        x, y, z = sensor_xyz[start : start + _ROWS].T.astype(np.float64)
        for axis in range(3):
            moved = T[axis, 0] * x + T[axis, 1] * y + T[axis, 2] * z + T[axis, 3]
            out[start : start + _ROWS, axis] = moved
    return out


def join_sensors(
    sensors: tuple[Sensor, ...], given: Sequence[tuple[FramePart, PointFrame]], **facts: Any
) -> PointFrame:
    """Return one frame of the frames of several sensors, each in its sensor's coordinates.

    ``given``: in increasing order of their sensors.  ``facts``: ``pose`` and ``timestamp`` of the
    frame.  A field that only some of the frames have is 0 in the others.
    """
    frames = [frame for _, frame in given]
    parts = tuple(replace(part, camera=frame.camera) for part, frame in given)
    counts = [len(frame) for frame in frames]
    columns: dict[str, Any] = {
        name: _filled([getattr(frame, name) for frame in frames], counts)
        for name in ("rgb", "intensity", "label", "instance", "pixel")
    }
    fields = {name: None for frame in frames for name in frame.other}
    other = {name: _filled([frame.other.get(name) for frame in frames], counts) for name in fields}
    numbers = [part.sensor for part in parts]
    placed = [
        to_frame(frame.xyz, part.T_frame_sensor, np.dtype(np.float64))
        for part, frame in zip(parts, frames, strict=True)
    ]
    xyz: NDArray[Any] = np.concatenate([np.empty((0, 3)), *placed])
    near = float(np.abs(xyz).max(initial=0.0)) <= FAR
    return PointFrame(
        xyz=xyz.astype(np.float32) if near else xyz,
        **columns,
        dropped=sum(frame.dropped for frame in frames),
        other=other,
        sensors=sensors,
        parts=parts,
        sensor=np.repeat(np.array(numbers, np.uint8), counts),
        sensor_xyz=_filled([frame.xyz for frame in frames], counts),
        **facts,
    )


def _filled(columns: Sequence[NDArray[Any] | None], counts: Sequence[int]) -> Any:
    """Return the columns of frames of ``counts`` points as one, None if no frame has it."""
    known = [column for column in columns if column is not None]
    if not known:
        return None
    shape, dtype = known[0].shape[1:], np.result_type(*known)
    return np.concatenate(
        [
            np.zeros((count, *shape), dtype) if column is None else column.astype(dtype)
            for column, count in zip(columns, counts, strict=True)
        ]
    )


def frame_of_part(frame: PointFrame, part: FramePart) -> PointFrame:
    """Return the points of one sensor as a frame in the sensor's coordinates.

    It has no intensities if they are all 0, as in a part that had none.
    """
    if frame.sensor is None or frame.sensor_xyz is None:
        raise BadInputError("expected a frame of several sensors")
    first, stop = np.searchsorted(frame.sensor, [part.sensor, part.sensor + 1])
    own: dict[str, Any] = {
        name: None if (column := getattr(frame, name)) is None else column[first:stop]
        for name in ("rgb", "intensity", "label", "instance", "pixel")
    }
    if own["intensity"] is not None and not np.nan_to_num(own["intensity"]).any():
        own["intensity"] = None
    if part.camera is None:
        own["pixel"] = None
    xyz: NDArray[Any] = np.ascontiguousarray(frame.sensor_xyz[first:stop])
    return PointFrame(
        xyz=xyz,
        **own,
        viewpoint=np.zeros(3),
        timestamp=part.timestamp,
        camera=part.camera,
        other={name: values[first:stop] for name, values in frame.other.items()},
    )
