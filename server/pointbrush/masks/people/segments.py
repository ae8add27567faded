"""Surfaces of a depth picture that hang together, at several tolerances."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

Floats = NDArray[np.float32]
Numbers = NDArray[np.int32]


def connected_surfaces(xyz: Floats, kept: NDArray[np.bool_], gap: Floats) -> Numbers:
    """Return the surface (h, w) of each kept pixel, from 0; -1 for others.

    Neighbours are of one surface if they are at most ``gap`` (h, w) metres apart.
    """
    height, width = kept.shape
    number = np.arange(height * width, dtype=np.int32).reshape(height, width)
    ends = [_joined(xyz, kept, gap, number, axis) for axis in (0, 1)]
    one, other = (np.concatenate([pair[k] for pair in ends]) for k in (0, 1))
    links = coo_array((np.ones(len(one), np.int8), (one, other)), (kept.size, kept.size))
    _, found = connected_components(links, directed=False)
    surface = np.full(kept.size, -1, np.int32)
    inside = np.flatnonzero(kept.ravel())
    surface[inside] = np.unique(found[inside], return_inverse=True)[1]
    return surface.reshape(height, width)


def _joined(
    xyz: Floats, kept: NDArray[np.bool_], gap: Floats, number: Numbers, axis: int
) -> tuple[Numbers, Numbers]:
    before = (slice(None, -1), slice(None)) if axis == 0 else (slice(None), slice(None, -1))
    after = (slice(1, None), slice(None)) if axis == 0 else (slice(None), slice(1, None))
    apart = np.linalg.norm(xyz[after] - xyz[before], axis=2)
    joined = kept[before] & kept[after] & (apart <= np.minimum(gap[before], gap[after]))
    return number[before][joined], number[after][joined]
