"""Nearest points where there are few: comparing all with all beats making a tree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pointbrush.tracking.interface import F64, I64, Mask

PAIRS = 1_000_000
"""Pairs of points up to which it is faster than making a tree over three and asking it."""
PRODUCTS = 250_000
"""Multiplications at a time: their results stay in the processor's cache, and BLAS shares larger
products among threads, which on a busy machine wait for each other ten times as long."""


class Plain:
    """Nearest of a few points (N, D), by comparing with every one of them."""

    def __init__(self, points: NDArray[np.floating]) -> None:
        count, width = points.shape
        self._middle = middle(points)
        # Single precision counts from the middle of the points.
        self._near = np.subtract(points, self._middle, dtype=np.float32, casting="same_kind")
        # |q - p|^2 less |q|^2, which is the same for all p, as one product of matrices.
        self._rows = np.empty((width + 1, count), np.float32)
        np.multiply(self._near.T, np.float32(-2), out=self._rows[:-1])
        np.einsum("ij,ij->i", self._near, self._near, out=self._rows[-1])

    def nearest(self, *wanted: NDArray[np.floating]) -> tuple[F64, I64]:
        """Distances (M,) and indices (M,) of the nearest to each of ``wanted`` (M, D).

        ``wanted`` may come in parts, whose columns add up to D.
        """
        count, width = len(wanted[0]), len(self._middle)
        some = np.empty((count, width + 1), np.float32)
        at = 0
        for part in wanted:
            end = at + part.shape[1]
            np.subtract(part, self._middle[at:end], out=some[:, at:end], casting="same_kind")
            at = end
        some[:, -1] = 1.0
        index = np.empty(count, np.int64)
        rows = max(1, PRODUCTS // self._rows.size)
        square = np.empty((min(rows, count), self._rows.shape[1]), np.float32)
        for first in range(0, count, rows):
            part = some[first : first + rows]
            found = np.matmul(part, self._rows, out=square[: len(part)])
            found.argmin(axis=1, out=index[first : first + rows])
        # The products serve to find it; so near to each other points need all digits.
        gap = some[:, :-1] - self._near.take(index, axis=0)
        return np.sqrt(np.einsum("ij,ij->i", gap, gap), dtype=np.float64), index


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
    """Metres (M,) from each of ``wanted`` (M, D) to the nearest of ``points`` (N, D).

    Infinite where that is ``most`` or more, or there are no points.
    """
    if not len(points) or not len(wanted):
        return np.full(len(wanted), np.inf)
    if len(wanted) * len(points) > PAIRS:
        tree = cKDTree(points, balanced_tree=False, compact_nodes=False)
        return np.asarray(tree.query(wanted, distance_upper_bound=most)[0], np.float64)
    distance, _ = Plain(points).nearest(wanted)
    distance[distance >= most] = np.inf
    return distance


def within(xyz: NDArray[np.floating], lo: F64, hi: F64) -> Mask:
    """Which points (N, 3) lie in a box; by columns, since NumPy reduces short rows slowly."""
    inside: NDArray[np.bool_] = np.ones(len(xyz), np.bool_)
    for axis in range(3):
        column = xyz[:, axis]
        inside &= (column >= lo[axis]) & (column <= hi[axis])
    return inside
