"""Nearest points where there are few: comparing all with all beats making a tree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pointbrush.tracking.interface import F64, I64, Mask

FEW = 1500
"""Points up to which comparing with every one is faster than a tree over six dimensions."""
PAIRS = 1_000_000
"""Pairs of points up to which it is faster than making a tree over three and asking it."""
PRODUCTS = 200_000
"""Multiplications at a time: their results stay in the processor's cache, and BLAS shares larger
products among threads, which on a busy machine wait for each other ten times as long."""


class Plain:
    """Nearest of a few points (N, D), by comparing with every one of them."""

    def __init__(self, points: F64) -> None:
        self._points = points
        self._middle = points.mean(axis=0)
        near = (points - self._middle).astype(np.float32)
        # |q - p|^2 less |q|^2, which is the same for all p, as one product of matrices.
        self._rows = np.vstack([-2 * near.T, np.einsum("ij,ij->i", near, near)])

    def nearest(self, wanted: F64) -> tuple[F64, I64]:
        """Distances (M,) and indices (M,) of the nearest to each of ``wanted`` (M, D)."""
        some = np.ones((len(wanted), self._points.shape[1] + 1), np.float32)
        some[:, :-1] = wanted - self._middle
        index = np.empty(len(wanted), np.int64)
        rows = max(1, PRODUCTS // self._rows.size)
        for first in range(0, len(wanted), rows):
            square = some[first : first + rows] @ self._rows
            square.argmin(axis=1, out=index[first : first + rows])
        # The products serve to find it; so near to each other points need all digits.
        gap = wanted - self._points[index]
        return np.sqrt(np.einsum("ij,ij->i", gap, gap)), index


def gaps(wanted: NDArray[np.floating], points: NDArray[np.floating], most: float) -> F64:
    """Metres (M,) from each of ``wanted`` (M, D) to the nearest of ``points`` (N, D).

    Infinite where that is ``most`` or more, or there are no points.
    """
    if not len(points) or not len(wanted):
        return np.full(len(wanted), np.inf)
    if len(wanted) * len(points) > PAIRS:
        tree = cKDTree(points, balanced_tree=False, compact_nodes=False)
        return np.asarray(tree.query(wanted, distance_upper_bound=most)[0], np.float64)
    distance, _ = Plain(points.astype(np.float64)).nearest(wanted.astype(np.float64))
    distance[distance >= most] = np.inf
    return distance


def within(xyz: NDArray[np.floating], lo: F64, hi: F64) -> Mask:
    """Which points (N, 3) lie in a box; by columns, since NumPy reduces short rows slowly."""
    inside: NDArray[np.bool_] = np.ones(len(xyz), np.bool_)
    for axis in range(3):
        column = xyz[:, axis]
        inside &= (column >= lo[axis]) & (column <= hi[axis])
    return inside
