"""How near points are to each other, and which lie in a box."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.tracking.columns import NONE, columns, nearest
from pointbrush.tracking.interface import F32, F64, Mask


def bounds(xyz: NDArray[np.number]) -> tuple[F64, F64]:
    """The least and the greatest corner (3,) of a box around points (N, 3); see ``within``."""
    columns = [xyz[:, axis] for axis in range(3)]
    lo, hi = [float(c.min()) for c in columns], [float(c.max()) for c in columns]
    return np.array(lo), np.array(hi)


def middle(points: NDArray[np.floating]) -> F64:
    """(D,) mean of points (N, D): NumPy's own is slow over short rows, a product not the same with
    any number of BLAS's threads."""
    return np.asarray(np.einsum("ij->j", points, dtype=np.float64) / len(points))


def gaps(wanted: NDArray[np.floating], points: NDArray[np.floating], most: float) -> F64:
    """Metres (M,) from each of ``wanted`` (M, 3) to the nearest of ``points`` (N, 3).

    Or (M, 6) and (N, 6), with weighted colours.  Infinite where that is ``most`` or more, or there
    are no points.
    """
    if not len(points) or not len(wanted):
        return np.full(len(wanted), np.inf)
    grid = columns(_places(points), _tints(points), float(points.shape[1] > 3))
    distance, index = nearest(grid, _places(wanted), _tints(wanted), 1.0, most)
    distance[index < 0] = np.inf
    return distance


def _places(points: NDArray[np.floating]) -> F64:
    return np.ascontiguousarray(points[:, :3], np.float64)


def _tints(points: NDArray[np.floating]) -> F32:
    return np.ascontiguousarray(points[:, 3:], np.float32) if points.shape[1] > 3 else NONE


def within(xyz: NDArray[np.floating], lo: F64, hi: F64) -> Mask:
    """Which points (N, 3) lie in a box; by columns, since NumPy reduces short rows slowly."""
    inside: NDArray[np.bool_] = np.ones(len(xyz), np.bool_)
    for axis in range(3):
        column = xyz[:, axis]
        inside &= (column >= lo[axis]) & (column <= hi[axis])
    return inside
