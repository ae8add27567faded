"""Progressive order of points, in which every prefix is a decimated frame.

Points are sorted along a Morton curve.  Level 0 takes every ``2**k``-th position of the curve,
level 1 the positions half way between them, and so on: each level is an even subsample of the
recording, doubles the density reached so far, and is itself in Morton order.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LEVEL0_POINTS = 4096
"""Level 0 holds at most this many points, and more than half of it in a larger frame."""

AXIS_BITS = 14
"""Bits of each coordinate in a Morton code."""

_INDEX_BITS = 22
MAX_POINTS = 1 << _INDEX_BITS
"""Most points that one call sorts; a larger frame goes through the octree."""


def _spread_table() -> NDArray[np.int64]:
    """Every value of 14 bits with two zero bits between its bits."""
    values = np.arange(1 << AXIS_BITS, dtype=np.int64)
    spread = np.zeros_like(values)
    for bit in range(AXIS_BITS):
        spread |= ((values >> bit) & 1) << (3 * bit)
    return spread


_SPREAD = _spread_table()


def bounds(xyz: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Least and greatest coordinates (3,) of points (N, 3), N > 0."""
    # Axis by axis: numpy reduces rows of three several times slower.
    columns = [xyz[:, axis] for axis in range(3)]
    lo = np.array([column.min() for column in columns], np.float32)
    return lo, np.array([column.max() for column in columns], np.float32)


def morton_codes(
    xyz: NDArray[np.float32], corner: NDArray[np.float64], size: float
) -> NDArray[np.int64]:
    """Morton codes (N,) of 42 bits of points (N, 3) in the cube at ``corner``, x lowest.

    Points beyond the cube count as on its edge.
    """
    top = (1 << AXIS_BITS) - 1
    codes = np.zeros(len(xyz), np.int64)
    for axis in range(3):
        cell = (xyz[:, axis] - corner[axis]) * ((top + 1) / size if size > 0 else 0.0)
        codes |= _SPREAD.take(np.clip(cell, 0, top, out=cell).astype(np.intp)) << axis
    return codes


def morton_order(xyz: NDArray[np.float32]) -> NDArray[np.int64]:
    """Indices (N,) that sort points (N, 3) along the Morton curve of their own bounding cube.

    Points in one cell keep their order, so the result depends on the input only.
    """
    n = len(xyz)
    if n > MAX_POINTS:
        raise ValueError(f"expected at most {MAX_POINTS} points, got {n}")
    if n == 0:
        return np.empty(0, np.int64)
    lo, hi = (bound.astype(np.float64) for bound in bounds(xyz))
    # Cubic cells, so that a flat room is not cut into thin slices along its height.
    codes = morton_codes(xyz, lo, float((hi - lo).max()))
    # Code and number in one key: sorting keys is faster than an argsort, and stable.
    keys = (codes.view(np.uint64) << np.uint64(_INDEX_BITS)) | np.arange(n, dtype=np.uint64)
    keys.sort()
    return (keys & np.uint64(MAX_POINTS - 1)).astype(np.int64)


def progressive(
    curve: NDArray[np.int64], level0: int = LEVEL0_POINTS
) -> tuple[NDArray[np.int64], list[int]]:
    """Reorder ``curve`` (N,), indices in Morton order, into additive levels.

    Returns the stored order (N,) and the level boundaries: level ``l`` is
    ``order[first[l]:first[l + 1]]``.
    """
    n = len(curve)
    stride = 1
    while n > level0 * stride:
        stride *= 2
    levels = [curve[::stride]]
    while stride > 1:
        levels.append(curve[stride // 2 :: stride])
        stride //= 2
    first = [0, *np.cumsum([len(level) for level in levels]).tolist()]
    return np.concatenate(levels), first
