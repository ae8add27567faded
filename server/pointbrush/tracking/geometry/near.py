"""How near points are to each other, and which lie in a box."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.tracking.geometry.columns import NONE, any_near_each, columns
from pointbrush.tracking.interface import F32, F64, I64, Mask

RUN = 64
"""Points of a run: as many as lie near each other in the order in which they were measured."""


@compiled
def bounds(xyz: NDArray[np.number]) -> tuple[F64, F64]:
    """The least and the greatest corner (3,) of a box around points (N, 3); see ``within``."""
    lo, hi = np.full(3, np.inf), np.full(3, -np.inf)
    for i in range(len(xyz)):
        for a in range(3):
            lo[a], hi[a] = min(lo[a], xyz[i, a]), max(hi[a], xyz[i, a])
    return lo, hi


def middle(points: NDArray[np.floating]) -> F64:
    """(D,) mean of points (N, D): NumPy's own is slow over short rows, a product not the same with
    any number of BLAS's threads."""
    return np.asarray(np.einsum("ij->j", points, dtype=np.float64) / len(points))


def close_to(wanted: NDArray[np.floating], points: NDArray[np.floating], most: float) -> Mask:
    """Which of ``wanted`` (M, 3) are less than ``most`` metres from one of ``points`` (N, 3).

    Or (M, 6) and (N, 6), with weighted colours.
    """
    if not len(points) or not len(wanted):
        return np.zeros(len(wanted), np.bool_)
    grid = columns(_places(points), _tints(points), float(points.shape[1] > 3))
    return any_near_each(grid, _places(wanted), _tints(wanted), most)


def _places(points: NDArray[np.floating]) -> F64:
    return np.ascontiguousarray(points[:, :3], np.float64)


def _tints(points: NDArray[np.floating]) -> F32:
    return np.ascontiguousarray(points[:, 3:], np.float32) if points.shape[1] > 3 else NONE


@compiled
def within(xyz: NDArray[np.floating], lo: F64, hi: F64) -> Mask:
    """Which points (N, 3) lie in a box."""
    inside = np.empty(len(xyz), np.bool_)
    for i in range(len(xyz)):
        aside = (lo[0] <= xyz[i, 0]) & (xyz[i, 0] <= hi[0])
        beside = (lo[1] <= xyz[i, 1]) & (xyz[i, 1] <= hi[1])
        inside[i] = aside & beside & (lo[2] <= xyz[i, 2]) & (xyz[i, 2] <= hi[2])
    return inside


class Runs(NamedTuple):
    """Points (N, 3) of a frame as they were stored, and the boxes of every ``RUN`` of them.

    What was measured one after the other lies together, so that few runs meet a small box.
    """

    xyz: F32
    low: F32
    high: F32


@compiled
def runs_of(xyz: F32) -> Runs:
    """The points (N, 3) with the boxes of their runs."""
    count = (len(xyz) + RUN - 1) // RUN
    low = np.full((count, 3), np.inf, np.float32)
    high = np.full((count, 3), -np.inf, np.float32)
    for i in range(len(xyz)):
        for a in range(3):
            low[i // RUN, a] = min(low[i // RUN, a], xyz[i, a])
            high[i // RUN, a] = max(high[i // RUN, a], xyz[i, a])
    return Runs(xyz, low, high)


@compiled
def in_box(runs: Runs, lo: F64, hi: F64) -> I64:
    """Sorted indices of the points that lie in a box."""
    meeting, meetings = np.empty(len(runs.low), np.int64), 0
    for run in range(len(runs.low)):
        meets = True
        for a in range(3):
            meets &= (runs.low[run, a] <= hi[a]) & (runs.high[run, a] >= lo[a])
        meeting[meetings] = run
        meetings += meets
    # No longer than needed: most boxes are small, and a frame is long.
    found, count = np.empty(meetings * RUN, np.int64), 0
    for run in meeting[:meetings]:
        for i in range(run * RUN, min(run * RUN + RUN, len(runs.xyz))):
            found[count] = i
            inside = True
            for a in range(3):
                inside &= (lo[a] <= runs.xyz[i, a]) & (runs.xyz[i, a] <= hi[a])
            count += inside
    return found[:count].copy()
