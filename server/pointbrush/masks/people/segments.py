"""Surfaces of a depth picture that hang together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

Floats = NDArray[np.float32]
Numbers = NDArray[np.int32]
Place = list[float]
"""Room coordinates (3,), metres, y up."""


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Pixels of a surface, by row and column, and its extent in the room, metres.

    ``area`` that the sensor sees, square metres; ``moved``: share of its pixels that moved between
    frames, NaN if that is unknown.
    """

    rows: NDArray[np.int64]
    columns: NDArray[np.int64]
    low: Place
    high: Place
    middle: Place
    depth: float
    area: float
    moved: float


def connected_surfaces(xyz: Floats, kept: NDArray[np.bool_], gap: Floats) -> Numbers:
    """Return the surface (h, w) of each kept pixel, from 1; 0 for others.

    Neighbours are of one surface if they are at most ``gap`` (h, w) metres apart.
    """
    beside = _joined(xyz, kept, gap, (slice(None), slice(1, None)), (slice(None), slice(None, -1)))
    below = _joined(xyz, kept, gap, (slice(1, None), slice(None)), (slice(None, -1), slice(None)))
    # Joined pixels of a row are one run: there are far fewer runs than pixels.
    starts = np.ones(kept.shape, np.bool_)
    starts[:, 1:] = ~beside
    run = (np.cumsum(starts.ravel()) - 1).reshape(kept.shape).astype(np.int32)
    upper, lower = run[:-1][below], run[1:][below]
    fresh = np.ones(len(upper), np.bool_)
    fresh[1:] = (upper[1:] != upper[:-1]) | (lower[1:] != lower[:-1])
    ends = upper[fresh], lower[fresh]
    count = int(run[-1, -1]) + 1
    links = coo_array((np.ones(len(ends[0]), np.int8), ends), (count, count))
    _, found = connected_components(links, directed=False)
    surface = np.where(kept, found[run] + 1, 0)
    used = np.bincount(surface.ravel()) > 0
    used[0] = False
    return np.asarray((np.cumsum(used) * used)[surface], np.int32)


def _joined(
    xyz: Floats, kept: NDArray[np.bool_], gap: Floats, one: tuple[slice, slice],
    other: tuple[slice, slice],
) -> NDArray[np.bool_]:  # fmt: skip
    step = xyz[one] - xyz[other]
    apart = np.einsum("ijk,ijk->ij", step, step)
    least = np.minimum(gap[one], gap[other])
    return np.asarray(kept[one] & kept[other] & (apart <= least * least))
