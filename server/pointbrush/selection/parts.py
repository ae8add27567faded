"""Points that hang together: parts with a gap between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

NEIGHBOUR = 8
"""The neighbour whose distance says how dense points are."""
USUAL_SHARE = 0.9
"""Share of the points whose distance to that neighbour is usual."""
GAP_FACTOR = 1.5
"""Times that distance from which a gap is none of a surface."""
SAMPLED = 4000
"""Points of which it is asked."""
TOUCHING = 1.8
"""Cells between the middles of two that touch: those at a corner are √3 apart."""
FEWEST = 3
"""Points that have a usual distance."""


def usual_gap(xyz: NDArray[np.floating]) -> float:
    """Return a gap (metres) that points (n, 3) do not have within one of their surfaces."""
    from scipy.spatial import cKDTree

    if len(xyz) < FEWEST:
        return 1.0
    step = max(1, len(xyz) // SAMPLED)
    distance, _ = cKDTree(xyz).query(xyz[::step], k=min(NEIGHBOUR, len(xyz)))
    return max(1e-3, GAP_FACTOR * float(np.quantile(np.asarray(distance)[:, -1], USUAL_SHARE)))


def connected_parts(xyz: NDArray[np.floating], gap: float) -> NDArray[np.int64]:
    """Return the part of each of points (n, 3): 0 is the largest, 1 the next, and so on.

    Two points are of one part when a chain of points leads from one to the other without a step
    longer than ``gap`` metres.  Steps up to 1.7 times as long may count, since space is cut into
    cells of half a gap, and cells that touch hang together.
    """
    if len(xyz) == 0:
        return np.empty(0, np.int64)
    at = np.asarray(xyz, np.float64)
    part = touching(np.floor((at - at.min(axis=0)) / (gap / 2)).astype(np.int64))
    order = np.argsort(-np.bincount(part), kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return np.asarray(rank[part], np.int64)


def touching(at: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return a number (n,) for each point's cell ``at`` (n, 3): the same for cells that touch.

    In chains, corners included.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    cells, cell = np.unique(at, axis=0, return_inverse=True)
    pairs = cKDTree(cells).query_pairs(TOUCHING, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), np.bool_), pairs.T), shape=(len(cells),) * 2)
    return np.asarray(connected_components(links, directed=False)[1][cell.reshape(-1)], np.int64)
