"""One frame of points in memory: what readers yield and writers take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError

Float = np.float32 | np.float64


@dataclass(frozen=True, slots=True, eq=False)
class DepthCamera:
    """Pinhole intrinsics of an organised frame, in pixels; row-major pixel order."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float


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
        )
        for name, array, shape, dtype in columns:
            if array is not None and (array.shape != shape or array.dtype != dtype):
                raise BadInputError(
                    f"{name}: expected {shape} {np.dtype(dtype)}, got {array.shape} {array.dtype}"
                )
        for name, values in self.other.items():
            if values.shape != (n,):
                raise BadInputError(f"{name}: expected ({n},) values, got {values.shape}")
        if (self.camera is None) != (self.pixel is None):
            raise BadInputError("camera and pixel: expected both or neither")

    def __len__(self) -> int:
        return len(self.xyz)
