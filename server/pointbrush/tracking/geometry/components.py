"""What hangs together: the pieces that points lie in, and what of a label is no piece of it."""

from __future__ import annotations

import numpy as np

from pointbrush.compiled import compiled, innermost
from pointbrush.tracking.geometry.columns import pairs
from pointbrush.tracking.geometry.grid import cells_of, means_of
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.options import ComponentOptions


def pieces(xyz: F64, unit: float, options: ComponentOptions) -> I64:
    """(N,) number of the piece that each point is of; ``unit`` metres of tolerance."""
    cell = cells_of(xyz, options.cell_units * unit)
    middle = means_of(xyz, cell)
    whole = np.ones(len(middle), np.bool_)
    return np.asarray(
        parts(pairs(middle, options.touching_cells * options.cell_units * unit), whole)[cell]
    )


@compiled
def parts(links: I64, some: Mask) -> I64:
    """(N,) number of the part that each of ``some`` (N,) is of, from 0; -1 for the others.

    ``links`` (P, 2) join two of them each.  Source: union-find, Tarjan 1975.
    """
    root = np.arange(len(some))
    for k in range(len(links)):
        one, other = links[k]
        if some[one] and some[other]:
            one, other = root_of(root, one), root_of(root, other)
            root[max(one, other)] = min(one, other)
    part, count = np.full(len(some), -1), 0
    for i in range(len(some)):
        if some[i]:
            first = root_of(root, i)
            if first == i:
                part[i] = count
                count += 1
            part[i] = part[first]
    return part


@innermost
def root_of(root: I64, at: int) -> int:
    """Where the way ``root`` (N,) of unions ends from ``at``; made shorter on the way."""
    while root[at] != at:
        root[at] = root[root[at]]
        at = root[at]
    return at


def solid(xyz: F64, unit: float, options: ComponentOptions) -> Mask:
    """Which points (N, 3) of a label lie in pieces of some size; all where hardly any do.

    A person who paints a thing paints the flying pixels of its outline too, which lie anywhere
    between it and the wall, and would make a pin as large as the way there.
    """
    if not len(xyz):
        return np.ones(0, np.bool_)
    piece = pieces(xyz, options.apart_factor * unit, options=options)
    kept = np.bincount(piece)[piece] >= min(options.crumb_points, options.crumb_share * len(xyz))
    return kept if 2 * np.count_nonzero(kept) > len(xyz) else np.ones(len(xyz), np.bool_)
