"""What hangs together: the pieces that points lie in, and what of a label is no piece of it."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from pointbrush.tracking.columns import pairs
from pointbrush.tracking.grid import cells_of, means_of
from pointbrush.tracking.interface import F64, I64, Mask

CELL, TOUCH = 1.5, 1.75
"""Units of a cell, and cells between the middles of two that touch."""
CRUMB, CRUMBS, APART = 0.04, 10, 3.0
"""Share of a label, and number of points, under which what lies apart from it is no part of it; and
how many times as far as that is for pieces, since depth comes in steps."""


def pieces(xyz: F64, unit: float) -> I64:
    """(N,) number of the piece that each point is of; ``unit`` metres of tolerance."""
    cell = cells_of(xyz, CELL * unit)
    middle = means_of(xyz, cell)
    touching = pairs(middle, TOUCH * CELL * unit)
    links = coo_matrix((np.ones(len(touching)), tuple(touching.T)), shape=(len(middle),) * 2)
    return np.asarray(connected_components(links, directed=False)[1][cell], np.int64)


def solid(xyz: F64, unit: float) -> Mask:
    """Which points (N, 3) of a label lie in pieces of some size; all where hardly any do.

    A person who paints a thing paints the flying pixels of its outline too, which lie anywhere
    between it and the wall, and would make a pin as large as the way there.
    """
    if not len(xyz):
        return np.ones(0, np.bool_)
    piece = pieces(xyz, APART * unit)
    kept = np.bincount(piece)[piece] >= min(CRUMBS, CRUMB * len(xyz))
    return kept if 2 * np.count_nonzero(kept) > len(xyz) else np.ones(len(xyz), np.bool_)
