"""Progressive order: which points come first, so that every prefix is a decimated frame.

Points are sorted along a Morton curve.  Level 0 takes every ``2**k``-th position of the curve,
level 1 the positions half way between those, and so on: each level is an even subsample of the
recording, doubles the density reached so far, and is itself in Morton order.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LEVEL0_POINTS = 4096
"""Level 0 holds at most this many points, and more than half of it in a larger frame."""

_AXIS_BITS = 14
_INDEX_BITS = 22
MAX_POINTS = 1 << _INDEX_BITS
"""Most points that one call sorts; a larger frame goes through the octree."""


def _spread(bits: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Put two zero bits between the low 21 bits of each value."""
    for shift, mask in (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        bits = (bits | (bits << np.uint64(shift))) & np.uint64(mask)
    return bits


def morton(cells: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Morton codes (N,) of integer cells (N, 3), each below 2**21."""
    x, y, z = (_spread(np.ascontiguousarray(cells[:, axis])) for axis in range(3))
    codes: NDArray[np.uint64] = x | (y << np.uint64(1)) | (z << np.uint64(2))
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
    lo = xyz.min(axis=0).astype(np.float64)
    extent = float((xyz.max(axis=0) - lo).max())
    # Cubic cells: a flat room must not be cut into slivers along its height.
    scale = ((1 << _AXIS_BITS) - 1) / extent if extent > 0 else 0.0
    cells = ((xyz - lo) * scale).astype(np.uint64)
    # Code and number in one key: sorting keys is several times faster than an argsort, and stable.
    keys = (morton(cells) << np.uint64(_INDEX_BITS)) | np.arange(n, dtype=np.uint64)
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
