"""Points in a grid of cubes: which share a cell, and which lie near some."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from pointbrush.tracking.interface import F64, I64, Mask

MOST = 4_000_000
"""Cells of a grid that is kept whole; a larger one is sorted instead."""


def cells_of(xyz: F64, size: float) -> I64:
    """(N,) number of each point's cell, ``size`` metres wide; occupied cells count from 0."""
    key = np.floor((xyz - xyz.min(axis=0)) / size).astype(np.int64)
    extent = key.max(axis=0) + 1
    flat = (key[:, 0] * extent[1] + key[:, 1]) * extent[2] + key[:, 2]
    if float(np.prod(extent, dtype=np.float64)) > MOST:
        return np.asarray(np.unique(flat, return_inverse=True)[1], np.int64)
    occupied = np.zeros(int(np.prod(extent)), np.int64)
    occupied[flat] = 1
    return np.asarray((np.cumsum(occupied) - 1)[flat], np.int64)


def perhaps_near(xyz: NDArray[np.floating], some: NDArray[np.floating], reach: float) -> Mask:
    """Which points (N, 3) may lie within ``reach`` metres of ``some`` (M, 3); all that do are."""
    lo = some.min(axis=0) - 2 * reach
    extent = ((some.max(axis=0) - lo) / reach).astype(np.int64) + 3
    if float(np.prod(extent, dtype=np.float64)) > MOST:
        return np.ones(len(xyz), np.bool_)
    taken = np.zeros(extent, np.bool_)
    taken[tuple(((some - lo) / reach).astype(np.int64).T)] = True
    taken = binary_dilation(taken, np.ones((3, 3, 3), np.bool_))
    key = np.clip((xyz - lo) / reach, 0, extent - 1).astype(np.int64)
    return np.asarray(taken[key[:, 0], key[:, 1], key[:, 2]])
