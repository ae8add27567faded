"""Points in cubes: hashed numbers of cubes, and sums over their points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

BITS = 21
"""Of a cube's place along each axis."""
MOST = (1 << BITS) - 2
_MIX = 0x9E3779B97F4A7C1


@innermost
def key_of(x: int, y: int, z: int) -> int:
    """Return one number for a cube; neighbours of the lowest ones are numbers too."""
    return ((x + 1) << (2 * BITS)) | ((y + 1) << BITS) | (z + 1)


@innermost
def find(slots: Ints, keys: Ints, key: int) -> int:
    """Return the number of a cube, or -1."""
    mask = len(slots) - 1
    at = ((key * _MIX) >> 20) & mask
    while slots[at] >= 0:
        if keys[slots[at]] == key:
            return int(slots[at])
        at = (at + 1) & mask
    return -1


@compiled
def number_cubes(xyz: Floats, low: Floats, size: float) -> tuple[NDArray[np.int32], Ints, Ints]:
    """Number the cubes that hold points (N, 3) in the order in which they are met.

    Returns the cube of each point (N,), the cubes' keys (C,), and the table that finds them.
    """
    bits = 4
    while (1 << bits) < 2 * len(xyz):
        bits += 1
    slots = np.full(1 << bits, -1, np.int64)
    of_point = np.empty(len(xyz), np.int32)
    keys = np.empty(len(xyz), np.int64)
    count, mask = 0, (1 << bits) - 1
    for i in range(len(xyz)):
        key = key_of(
            int((xyz[i, 0] - low[0]) / size),
            int((xyz[i, 1] - low[1]) / size),
            int((xyz[i, 2] - low[2]) / size),
        )
        at = ((key * _MIX) >> 20) & mask
        while slots[at] >= 0 and keys[slots[at]] != key:
            at = (at + 1) & mask
        if slots[at] < 0:
            slots[at] = count
            keys[count] = key
            count += 1
        of_point[i] = slots[at]
    return of_point, keys[:count].copy(), slots


@compiled
def means(of_point: NDArray[np.int32], values: Floats, count: int) -> Floats:
    """Return the mean (C, K) of values (N, K) in each cube."""
    out = np.zeros((count, values.shape[1]))
    held = np.zeros(count)
    for i in range(len(of_point)):
        held[of_point[i]] += 1
        for k in range(values.shape[1]):
            out[of_point[i], k] += values[i, k]
    for c in range(count):
        for k in range(values.shape[1]):
            out[c, k] /= held[c]
    return out


@compiled
def neighbours(keys: Ints, slots: Ints) -> NDArray[np.int32]:
    """Return the 26 cubes (C, 26) round each one, -1 where none holds a point."""
    out = np.full((len(keys), 26), -1, np.int32)
    for c in range(len(keys)):
        k = 0
        for dx in range(-1, 2):
            for dy in range(-1, 2):
                for dz in range(-1, 2):
                    if dx == 0 and dy == 0 and dz == 0:
                        continue
                    step = (dx << (2 * BITS)) + (dy << BITS) + dz
                    out[c, k] = find(slots, keys, keys[c] + step)
                    k += 1
    return out


@compiled
def connected(near: NDArray[np.int32]) -> NDArray[np.int64]:
    """Return the number of the connected part that each cube belongs to."""
    part = np.full(len(near), -1, np.int64)
    waiting = np.empty(len(near), np.int64)
    count = 0
    for first in range(len(near)):
        if part[first] >= 0:
            continue
        part[first], waiting[0], open_ = count, first, 1
        while open_:
            open_ -= 1
            at = waiting[open_]
            for other in near[at]:
                if other >= 0 and part[other] < 0:
                    part[other] = count
                    waiting[open_] = other
                    open_ += 1
        count += 1
    return part
