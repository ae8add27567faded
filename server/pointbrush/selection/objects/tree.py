"""The merge tree: neighbouring pieces joined one pair after the other, likeliest first."""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.selection.objects import sums
from pointbrush.selection.objects.features import FEATURES, pair_features
from pointbrush.selection.objects.forest import Forest, answer
from pointbrush.selection.objects.sums import PAIR_WIDTH, WIDTH, Pieces

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
GROWN = 1.1
"""Times its size by which a piece must grow before pairs that it keeps are scored anew."""


@dataclass(frozen=True, slots=True, eq=False)
class MergeTree:
    """P pieces, numbers 0..P-1, and the M nodes that joined two, in the order of merging.

    ``parent`` (P + M,) int64, -1 for a root; ``score`` (P + M,) log odds of the merge that made
    a node, inf for pieces; ``sums`` (P + M, WIDTH); ``first`` (B,) log odds of the first pairs.
    """

    parent: Ints
    score: Floats
    sums: Floats
    first: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Scored:
    """Every pair that was scored: ``rows`` (S, FEATURES), ``nodes`` (S, 2) smaller and larger."""

    rows: Floats
    nodes: Ints


def grow_tree(pieces: Pieces, area: float, model: Forest) -> MergeTree:
    """Return the tree of pieces under a merge model; ``area`` of a cell, square metres."""
    return record_tree(pieces, area, model, 0)[0]


def record_tree(pieces: Pieces, area: float, model: Forest, most: int) -> tuple[MergeTree, Scored]:
    """Return the tree, and the pairs that were scored on the way, ``most`` at most."""
    parent, score, totals, first, rows, nodes = _merge(
        pieces.sums, pieces.pairs, pieces.between, area, *model, most
    )
    return MergeTree(parent, score, totals, first), Scored(rows, nodes)


@compiled
def _merge(
    leaves: Floats,
    first_pairs: Ints,
    first_between: Floats,
    area: float,
    feature: NDArray[np.int16],
    threshold: NDArray[np.float32],
    left: NDArray[np.int32],
    right: NDArray[np.int32],
    roots: NDArray[np.int32],
    most: int,
) -> tuple[Ints, Floats, Floats, Floats, Floats, Ints]:
    count, borders = len(leaves), len(first_pairs)
    nodes = max(2 * count - 1, 0)
    parent, made = np.full(nodes, -1, np.int64), np.full(nodes, np.inf)
    total = np.empty((nodes, WIDTH))
    total[:count] = leaves
    ends, between = first_pairs.copy(), first_between.copy()
    rows, scored = np.empty((most, FEATURES)), np.empty((most, 2), np.int64)
    noted = 0
    work, row = np.empty((3, WIDTH)), np.empty(FEATURES)
    # A node's borders: a list through slots 2 b and 2 b + 1 of border b, one for each end.
    head, following = np.full(nodes, -1, np.int64), np.full(2 * borders, -1, np.int64)
    version, sized = np.zeros(borders, np.int64), np.zeros(borders)
    first = np.empty(borders)
    waiting = [(0.0, 0, 0)][:0]
    fresh = np.empty(borders, np.int64)
    for b in range(borders):
        fresh[b] = b
        for side in range(2):
            following[2 * b + side] = head[ends[b, side]]
            head[ends[b, side]] = 2 * b + side
    seen, at = np.full(nodes, -1, np.int64), np.full(nodes, -1, np.int64)
    fresh_count, node, begun = borders, count, False
    while True:
        for f in range(fresh_count):
            b = fresh[f]
            one, other = ends[b, 0], ends[b, 1]
            if total[one, sums.COUNT] > total[other, sums.COUNT]:
                one, other = other, one
            pair_features(total[one], total[other], between[b], area, work, row)
            odds = answer(feature, threshold, left, right, roots, row)
            if noted < most:
                rows[noted] = row
                scored[noted, 0], scored[noted, 1] = one, other
                noted += 1
            if not begun:
                first[b] = odds
            version[b] += 1
            sized[b] = total[one, sums.COUNT] + total[other, sums.COUNT]
            heapq.heappush(waiting, (-odds, b, version[b]))
        begun, fresh_count = True, 0
        found, odds = -1, 0.0
        while len(waiting) > 0:
            minus, b, stamp = heapq.heappop(waiting)
            if version[b] == stamp:
                found, odds = b, -minus
                break
        if found < 0:
            break
        one, other = ends[found, 0], ends[found, 1]
        version[found] = -1
        parent[one] = parent[other] = node
        made[node] = odds
        sums.add(total[one], total[other], total[node])
        total[node, sums.PERIMETER] -= 2 * between[found, sums.EDGES]
        grown = total[node, sums.COUNT]
        for old in (one, other):
            slot = head[old]
            while slot >= 0:
                after, b, side = following[slot], slot // 2, slot % 2
                if version[b] >= 0:
                    far = ends[b, 1 - side]
                    ends[b, side] = node
                    if seen[far] == node:
                        # Both had this neighbour: their borders become one.
                        kept = at[far]
                        for k in range(PAIR_WIDTH):
                            between[kept, k] += between[b, k]
                        version[b] = -1
                        if sized[kept] >= 0:
                            sized[kept] = -1.0
                            fresh[fresh_count] = kept
                            fresh_count += 1
                    else:
                        seen[far], at[far] = node, b
                        following[slot], head[node] = head[node], slot
                        if sized[b] >= 0 and (grown + total[far, sums.COUNT] > GROWN * sized[b]):
                            sized[b] = -1.0
                            fresh[fresh_count] = b
                            fresh_count += 1
                slot = after
        node += 1
    return parent[:node], made[:node], total[:node], first, rows[:noted], scored[:noted]
