"""Points in a grid of cubes: which share a cell, and which lie near some."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.tracking.geometry.near import bounds
from pointbrush.tracking.interface import F32, F64, I64, Mask

MOST_ACROSS = 2**20
"""Cells along an axis; what lies beyond shares the last."""
SPARE = 0.8
"""Share of those cells that the rest of a cloud is spread over where a point flew far off."""
MOST_NEAR = 200_000
"""Cells, about, of the grid in which points near some others are looked for."""


def cells_of(xyz: F64, size: float) -> I64:
    """(N,) number of each point's cell, ``size`` metres wide; occupied cells count from 0."""
    lo, hi = bounds(xyz)
    if float((hi - lo).max()) > MOST_ACROSS * size:
        # A point that flew off must not make the numbers of cells overflow.
        middle, half = np.median(xyz, axis=0), SPARE / 2 * MOST_ACROSS * size
        xyz = np.clip(xyz, middle - half, middle + half)
        lo, hi = bounds(xyz)
    return numbered(_keys(xyz, lo, (np.floor((hi - lo) / size) + 1).astype(np.int64), size))


@compiled
def _keys(xyz: F64, low: F64, extent: I64, size: float) -> I64:
    """Number of the cell of each point (N, 3), of all in a box of ``extent`` (3,) cells."""
    key = np.empty(len(xyz), np.int64)
    for i in range(len(xyz)):
        x = int((xyz[i, 0] - low[0]) / size)
        y = int((xyz[i, 1] - low[1]) / size)
        key[i] = (x * extent[1] + y) * extent[2] + int((xyz[i, 2] - low[2]) / size)
    return key


@compiled
def numbered(key: I64) -> I64:
    """(N,) rank of each of the keys among those that occur, from 0."""
    size = 16  # of the hash table: a power of two, at most half full
    while size < 2 * len(key):
        size *= 2
    slot, distinct, first = np.full(size, -1), np.empty(len(key), np.int64), np.empty_like(key)
    count = 0
    for i in range(len(key)):
        # Multiplicative hashing (Knuth 1973, section 6.4), and the next free slot.
        at = (key[i] * 0x1E3779B97F4A7C15 >> 20) & (size - 1)
        while slot[at] >= 0 and distinct[slot[at]] != key[i]:
            at = (at + 1) & (size - 1)
        if slot[at] < 0:
            slot[at] = count
            distinct[count] = key[i]
            count += 1
        first[i] = slot[at]
    rank = np.empty(count, np.int64)
    rank[np.argsort(distinct[:count])] = np.arange(count)
    for i in range(len(key)):
        first[i] = rank[first[i]]
    return first


@compiled
def means_of(values: NDArray[np.floating], cell: I64) -> F64:
    """(K, D) means of the values (N, D) of each cell, numbered (N,) as by ``cells_of``."""
    count = cell.max() + 1 if len(cell) else 0
    means, points = np.zeros((count, values.shape[1])), np.zeros(count)
    for i in range(len(cell)):
        points[cell[i]] += 1.0
        for a in range(values.shape[1]):
            means[cell[i], a] += values[i, a]
    for c in range(count):
        means[c] /= points[c]
    return means


def perhaps_near(xyz: F32, some: F32, reach: float) -> Mask:
    """Which points (N, 3) may lie within ``reach`` metres of ``some`` (M, 3); all that do are."""
    lo, hi = bounds(some)
    # Coarse enough for a grid that is kept whole; single precision must not decide at the border.
    size = max(1.001 * reach + 1e-6, float(np.cbrt(np.prod(hi - lo + 2 * reach) / MOST_NEAR)))
    # Two cells more on every side: rounding must not mark what lies outside.
    return _in_marked(xyz, some, size, lo - 2 * size, ((hi - lo) / size).astype(np.int64) + 5)


@compiled
def _in_marked(xyz: F32, some: F32, size: float, low: F64, extent: I64) -> Mask:
    """Which points (N, 3) lie in a cell of ``size`` metres beside one that holds some (M, 3)."""
    marked = np.zeros((extent[0], extent[1], extent[2]), np.bool_)
    for i in range(len(some)):
        x = int((some[i, 0] - low[0]) / size)
        y = int((some[i, 1] - low[1]) / size)
        z = int((some[i, 2] - low[2]) / size)
        marked[x - 1 : x + 2, y - 1 : y + 2, z - 1 : z + 2] = True
    near = np.zeros(len(xyz), np.bool_)
    for i in range(len(xyz)):
        x = (xyz[i, 0] - low[0]) / size
        y = (xyz[i, 1] - low[1]) / size
        z = (xyz[i, 2] - low[2]) / size
        if 0 <= x < extent[0] and 0 <= y < extent[1] and 0 <= z < extent[2]:
            near[i] = marked[int(x), int(y), int(z)]
    return near
