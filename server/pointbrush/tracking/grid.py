"""Points in a grid of cubes: which share a cell, and which lie near some."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.near import bounds

MOST = 4_000_000
"""Cells of a grid that is kept whole; a larger one is sorted instead."""
MOST_NEAR = 100_000
"""Cells, about, of the grid in which points near some others are looked for."""


def cells_of(xyz: F64, size: float) -> I64:
    """(N,) number of each point's cell, ``size`` metres wide; occupied cells count from 0."""
    lo, hi = bounds(xyz)
    key = np.floor((xyz - lo) / size).astype(np.int64)
    extent = np.floor((hi - lo) / size).astype(np.int64) + 1
    flat = (key[:, 0] * extent[1] + key[:, 1]) * extent[2] + key[:, 2]
    if float(np.prod(extent, dtype=np.float64)) > MOST:
        return np.asarray(np.unique(flat, return_inverse=True)[1], np.int64)
    occupied = np.zeros(int(np.prod(extent)), np.int64)
    occupied[flat] = 1
    return np.asarray((np.cumsum(occupied) - 1)[flat], np.int64)


def means_of(values: NDArray[np.floating], cell: I64) -> F64:
    """(K, D) means of the values (N, D) of each cell, numbered (N,) as by ``cells_of``."""
    sums = [np.bincount(cell, weights=column) for column in values.T]
    return np.stack(sums, axis=1) / np.bincount(cell)[:, None]


def perhaps_near(xyz: NDArray[np.floating], some: NDArray[np.floating], reach: float) -> Mask:
    """Which points (N, 3) may lie within ``reach`` metres of ``some`` (M, 3); all that do are."""
    least, most = bounds(some)
    # A cell is twice the reach wide, so that each of the few meets eight at most.
    reach = 1.001 * reach + 1e-6
    volume = float(np.prod(most - least + 4 * reach))
    size = max(2 * reach, float(np.cbrt(volume / MOST_NEAR)))
    lo = least - reach - size
    extent = ((most + reach - lo) / size).astype(np.int64) + 2
    steps = np.array([extent[1] * extent[2], extent[2], 1])
    taken = np.zeros(int(np.prod(extent)), np.bool_)
    ends = [((some + way - lo) / size).astype(np.int64) * steps for way in (-reach, reach)]
    for x, y, z in product(ends, ends, ends):
        taken[x[:, 0] + y[:, 1] + z[:, 2]] = True
    flat = np.zeros(len(xyz), np.int64)
    for axis in range(3):
        key = ((xyz[:, axis] - lo[axis]) / size).clip(0, extent[axis] - 1)
        flat += key.astype(np.int64) * steps[axis]
    return np.asarray(taken[flat])
