"""Positions as 16-bit integers on a power-of-two grid, per chunk of points.

A grid step that is a power of two makes ``origin + q * scale`` exact in float32 for ordinary
recordings, in the shader as in numpy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

ROOM_STEP = 2.0**-10
"""Grid of a recording of a metre or more: 0.98 mm, under the noise of a depth camera."""
SITE_STEP = 2.0**-8
"""Grid of a recording of more than 256 m: 3.9 mm, under the noise of a lidar."""

LIDAR_STEP = 2.0**-6
"""Coarsest grid of a sparse recording of 64 m or more: 16 mm, an error of at most 7.8 mm where a
lidar's noise is one to two centimetres."""
AERIAL_STEP = 2.0**-4
"""The same from 1 km on, as seen from the air: at most 31 mm under five centimetres and more."""

_STEPS = 65535
_OBJECT_BITS = 13
_SITE_BITS = 17
_MIN_EXPONENT = -40


def base_step(extent: float) -> float:
    """Finest grid step for a recording of this extent (metres, its longest side)."""
    if extent <= 0.0:
        return ROOM_STEP
    bits = math.ceil(math.log2(extent))
    if extent < 1.0:
        return math.ldexp(1.0, max(bits - _OBJECT_BITS, _MIN_EXPONENT))
    return min(max(ROOM_STEP, math.ldexp(1.0, bits - _SITE_BITS)), SITE_STEP)


def coarsest_step(extent: float) -> float:
    """Return the coarsest grid step that saving bytes may choose for this extent (metres).

    It is at most 1/4096 of the extent, so that a room stays at a millimetre.
    """
    finest = base_step(extent)
    if extent >= 1024.0:
        return AERIAL_STEP
    if extent < 1.0:
        return finest
    return min(max(finest, 2.0 ** math.floor(math.log2(extent / 4096.0))), LIDAR_STEP)


@dataclass(frozen=True, slots=True, eq=False)
class Quantised:
    """``q`` (N, 3) uint16; position = ``origin + q * scale`` within ``error`` per axis."""

    q: NDArray[np.uint16]
    origin: NDArray[np.float64]
    scale: NDArray[np.float64]
    lo: NDArray[np.float32]
    hi: NDArray[np.float32]
    error: float


def _axis_grid(lo: float, hi: float, step: float) -> tuple[float, float]:
    """Origin, a float32 value not above ``lo``, and a step with which 16 bits reach ``hi``."""
    while True:
        origin = np.float32(math.floor(lo / step) * step)
        if float(origin) > lo:
            origin = np.nextafter(origin, np.float32(-np.inf))
        if hi - float(origin) <= step * _STEPS:
            return float(origin), step
        step *= 2.0


def quantise(xyz: NDArray[np.float32], step: float) -> Quantised:
    """Quantise points (N, 3) in local metres to a grid of ``step`` or the least that fits."""
    if len(xyz) == 0:
        zero = np.zeros(3)
        empty = np.zeros(3, np.float32)
        return Quantised(np.empty((0, 3), np.uint16), zero, np.full(3, step), empty, empty, 0.0)
    from pointbrush.sequences.loops import bound_runs, round_to_grid

    (lo,), (hi,) = bound_runs(xyz, np.array([0, len(xyz)]))
    grid = [_axis_grid(float(a), float(b), step) for a, b in zip(lo, hi, strict=True)]
    origin = np.array([axis[0] for axis in grid])
    scale = np.array([axis[1] for axis in grid])
    q = round_to_grid(xyz, origin, scale)
    # Adding in float32 rounds once more, by half a unit in the last place of the greatest value.
    reach = max(float(np.abs(lo).max()), float(np.abs(hi).max())) + float(scale.max())
    rounding = float(np.spacing(np.float32(min(reach, 3e38))))
    exact = reach / float(scale.min()) < 2**24
    error = float(scale.max()) / 2 + (0.0 if exact else rounding)
    return Quantised(q, origin, scale, lo, hi, error)
