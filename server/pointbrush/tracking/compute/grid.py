"""Cells of points: numbering, means and search, and windows of images."""

from __future__ import annotations

from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.tracking.compute.columns import NONE, any_near_each, columns
from pointbrush.tracking.interface import F32, F64, I64, Mask

MOST_ACROSS = 2**20
"""Maximum number of cells along an axis; points beyond are in the last cell."""
SPARE = 0.8
"""Share of these cells for the rest of a cloud with a far outlier."""
MOST_NEAR = 200_000
"""Approximate maximum number of cells of the grid for the search of near points."""


def cells_of(xyz: F64, size: float) -> I64:
    """Return (N,) the number of each point's cell, ``size`` metres wide; occupied ones from 0."""
    lo, hi = bounds(xyz)
    if float((hi - lo).max()) > MOST_ACROSS * size:
        # An outlier must not make the numbers of cells overflow.
        middle, half = np.median(xyz, axis=0), SPARE / 2 * MOST_ACROSS * size
        xyz = np.clip(xyz, middle - half, middle + half)
        lo, hi = bounds(xyz)
    return numbered(_keys(xyz, lo, (np.floor((hi - lo) / size) + 1).astype(np.int64), size))


@compiled
def _keys(xyz: F64, low: F64, extent: I64, size: float) -> I64:
    """Return the cell number of each point (N, 3) in a box of ``extent`` (3,) cells."""
    key = np.empty(len(xyz), np.int64)
    for i in range(len(xyz)):
        x = int((xyz[i, 0] - low[0]) / size)
        y = int((xyz[i, 1] - low[1]) / size)
        key[i] = (x * extent[1] + y) * extent[2] + int((xyz[i, 2] - low[2]) / size)
    return key


@compiled
def numbered(key: I64) -> I64:
    """Return (N,) the rank of each key among the distinct keys, from 0."""
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
    """Return (K, D) the mean of the values (N, D) of each cell; ``cell`` (N,): see ``cells_of``."""
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
    """Mark all points (N, 3) within ``reach`` metres of ``some`` (M, 3), and possibly others."""
    lo, hi = bounds(some)
    # Coarse enough for a dense grid, with a margin for single precision.
    size = max(1.001 * reach + 1e-6, float(np.cbrt(np.prod(hi - lo + 2 * reach) / MOST_NEAR)))
    # Two cells more on every side: rounding must not mark points outside.
    return _in_marked(xyz, some, size, lo - 2 * size, ((hi - lo) / size).astype(np.int64) + 5)


@compiled
def _in_marked(xyz: F32, some: F32, size: float, low: F64, extent: I64) -> Mask:
    """Mark the points (N, 3) in cells of ``size`` metres at or beside cells with some (M, 3)."""
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


RUN = 64
"""Number of points of a run: consecutively measured points are close to each other."""


@compiled
def bounds(xyz: NDArray[np.number]) -> tuple[F64, F64]:
    """Return the minimum and maximum corner (3,) of a box around points (N, 3)."""
    lo, hi = np.full(3, np.inf), np.full(3, -np.inf)
    for i in range(len(xyz)):
        for a in range(3):
            lo[a], hi[a] = min(lo[a], xyz[i, a]), max(hi[a], xyz[i, a])
    return lo, hi


def middle(points: NDArray[np.floating]) -> F64:
    """Return the mean (D,) of points (N, D).

    NumPy's mean is slow over short rows, and a product depends on the number of BLAS threads.
    """
    return np.asarray(np.einsum("ij->j", points, dtype=np.float64) / len(points))


def close_to(wanted: NDArray[np.floating], points: NDArray[np.floating], most: float) -> Mask:
    """Mark the points ``wanted`` (M, 3) closer than ``most`` metres to one of ``points`` (N, 3).

    Arrays (M, 6) and (N, 6) have weighted colours.
    """
    if not len(points) or not len(wanted):
        return np.zeros(len(wanted), np.bool_)
    places, tints, weight = _places(points), _tints(points), float(points.shape[1] > 3)
    return _near(places, tints, weight, _places(wanted), _tints(wanted), most)


@compiled
def _near(xyz: F64, tint: F32, weight: float, wanted: F64, colour: F32, most: float) -> Mask:
    """See ``any_near_each``, for unsorted points (N, 3)."""
    return any_near_each(columns(xyz, tint, weight), wanted, colour, most)


def _places(points: NDArray[np.floating]) -> F64:
    return np.ascontiguousarray(points[:, :3], np.float64)


def _tints(points: NDArray[np.floating]) -> F32:
    return np.ascontiguousarray(points[:, 3:], np.float32) if points.shape[1] > 3 else NONE


@compiled
def within(xyz: NDArray[np.floating], lo: F64, hi: F64) -> Mask:
    """Mark the points (N, 3) inside the box from ``lo`` to ``hi`` (3,)."""
    inside = np.empty(len(xyz), np.bool_)
    for i in range(len(xyz)):
        aside = (lo[0] <= xyz[i, 0]) & (xyz[i, 0] <= hi[0])
        beside = (lo[1] <= xyz[i, 1]) & (xyz[i, 1] <= hi[1])
        inside[i] = aside & beside & (lo[2] <= xyz[i, 2]) & (xyz[i, 2] <= hi[2])
    return inside


class Runs(NamedTuple):
    """Points (N, 3) of a frame in stored order, and the bounding boxes of runs of ``RUN`` points.

    Consecutively measured points are close to each other, so that few runs intersect a small box.
    """

    xyz: F32
    low: F32
    high: F32


@compiled
def runs_of(xyz: F32) -> Runs:
    """Return the points (N, 3) with the boxes of their runs."""
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
    """Return sorted indices of the points in a box."""
    meeting, meetings = np.empty(len(runs.low), np.int64), 0
    for run in range(len(runs.low)):
        meets = True
        for a in range(3):
            meets &= (runs.low[run, a] <= hi[a]) & (runs.high[run, a] >= lo[a])
        meeting[meetings] = run
        meetings += meets
    # Only as long as needed: most boxes are small, and frames are large.
    found, count = np.empty(meetings * RUN, np.int64), 0
    for run in meeting[:meetings]:
        for i in range(run * RUN, min(run * RUN + RUN, len(runs.xyz))):
            found[count] = i
            inside = True
            for a in range(3):
                inside &= (lo[a] <= runs.xyz[i, a]) & (runs.xyz[i, a] <= hi[a])
            count += inside
    return found[:count].copy()


A = TypeVar("A", bound=NDArray[np.generic])


def least_around(image: A) -> A:
    """Return (H, W) the minimum of each pixel and its eight neighbours."""
    result = image.copy()
    for axis in (0, 1):
        of, to = result.swapaxes(0, axis).copy(), result.swapaxes(0, axis)
        np.minimum(to[1:], of[:-1], out=to[1:])
        np.minimum(to[:-1], of[1:], out=to[:-1])
    return result


def widened(image: Mask, steps: int) -> Mask:
    """Return a mask (H, W) dilated by ``steps`` pixels with four neighbours."""
    result = image.copy()
    for _ in range(steps):
        before = result.copy()
        result[1:] |= before[:-1]
        result[:-1] |= before[1:]
        result[:, 1:] |= before[:, :-1]
        result[:, :-1] |= before[:, 1:]
    return result


def blocks(image: F32, shape: tuple[int, int], size: int) -> F32:
    """Return (B, size ** 2) the values of blocks of an image (H * W,), NaN beyond its border."""
    height, width = shape
    rows, columns = -(-height // size), -(-width // size)
    padded = np.full((rows * size, columns * size), np.nan, np.float32)
    padded[:height, :width] = image.reshape(shape)
    return padded.reshape(rows, size, columns, size).transpose(0, 2, 1, 3).reshape(-1, size**2)
