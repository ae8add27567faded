"""Regions grown from the clicks, piece by piece: the most likely neighbour is added next.

The merge tree joins all regions at once, so that a leg joined to the floor is lost to its chair.
Growth from a click considers only neighbours of the region.
"""

from __future__ import annotations

import heapq
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost
from pointbrush.selection.objects import sums
from pointbrush.selection.objects.sums import PAIR_WIDTH, WIDTH
from pointbrush.selection.objects.tree import FEATURES, pair_features
from pointbrush.selection.objects.weights import Forest, answer

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]
OUTGROWN = 1.5
"""Growth factor of a region after which scores of its neighbours are outdated."""


class _Around(NamedTuple):
    """Neighbours of the pieces, and the state of pieces around the region.

    ``starts`` (P + 1,): start of a piece's neighbours in ``far`` and ``border``; ``between``
    (B, PAIR_WIDTH): sums of borders; ``shared`` (P, PAIR_WIDTH): sums of a piece's border with the
    region; ``inside`` (P,): pieces that are never added; ``queued`` (P,): pieces in ``frontier``;
    ``version`` and ``era`` (P,): of their scores; ``frontier`` (P,): neighbours to be scored.
    """

    starts: Ints
    far: Ints
    border: Ints
    between: NDArray[np.float32]
    shared: Floats
    inside: Mask
    queued: Mask
    version: Ints
    era: Ints
    frontier: Ints


class Linked(NamedTuple):
    """Sums of pieces (P, WIDTH), neighbouring ``pairs`` (B, 2), sums (B, PAIR_WIDTH) of borders."""

    sums: Floats
    pairs: NDArray[np.int32]
    between: NDArray[np.float32]


class _Scorer(NamedTuple):
    """The model with the ``area`` of a cell; ``row``: features of the last pair that was scored."""

    model: Forest
    area: float
    work: Floats
    row: Floats


def grow_region(
    pieces: Linked, seeds: Ints, blocked: Mask, area: float, model: Forest, most: int,
    noted: int = 0,
) -> tuple[Ints, Floats, Floats, Ints]:  # fmt: skip
    """Return at most ``most`` pieces added to ``seeds``, in order, and their log odds.

    ``blocked`` (P,): pieces that are never added.  The last results are at most ``noted`` scored
    pairs: rows (S, FEATURES), and (S, 2) the number of pieces added before with the scored piece.
    """
    count = len(pieces.sums)
    around = _Around(
        *neighbours(count, pieces.pairs),
        pieces.between,
        np.zeros((count, PAIR_WIDTH)),
        blocked.copy(),
        np.zeros(count, np.bool_),
        np.zeros(count, np.int64),
        np.zeros(count, np.int64),
        np.empty(count, np.int64),
    )
    scorer = _Scorer(model, area, np.empty((3, WIDTH)), np.empty(FEATURES))
    return _grow(pieces.sums, around, seeds, scorer, most, noted)


@compiled
def neighbours(count: int, pairs: NDArray[np.int32]) -> tuple[Ints, Ints, Ints]:
    """Return the neighbours of each piece: starts (P + 1,), pieces, and borders to them."""
    starts = np.zeros(count + 1, np.int64)
    for b in range(len(pairs)):
        starts[pairs[b, 0] + 1] += 1
        starts[pairs[b, 1] + 1] += 1
    starts = np.cumsum(starts)
    at = starts[:-1].copy()
    far, border = np.empty(2 * len(pairs), np.int64), np.empty(2 * len(pairs), np.int64)
    for b in range(len(pairs)):
        for side in range(2):
            own = pairs[b, side]
            far[at[own]], border[at[own]] = pairs[b, 1 - side], b
            at[own] += 1
    return starts, far, border


@innermost
def _take_in(piece: int, leaves: Floats, region: Floats, around: _Around, reached: int) -> int:
    """Add a piece to the region; return the number of neighbours to be scored."""
    around.inside[piece] = True
    sums.add(region, leaves[piece], region)
    region[sums.PERIMETER] -= 2 * around.shared[piece, sums.EDGES]
    for k in range(around.starts[piece], around.starts[piece + 1]):
        p, b = around.far[k], around.border[k]
        for w in range(PAIR_WIDTH):
            around.shared[p, w] += around.between[b, w]
        if not around.queued[p] and not around.inside[p]:
            around.queued[p] = True
            around.frontier[reached] = p
            reached += 1
    return reached


@innermost
def _odds(piece: int, leaves: Floats, region: Floats, around: _Around, scorer: _Scorer) -> float:
    """Return log odds that a piece and the region are one object."""
    border, area, work, row = around.shared[piece], scorer.area, scorer.work, scorer.row
    if leaves[piece, sums.COUNT] < region[sums.COUNT]:
        pair_features(leaves[piece], region, border, area, work, row)
    else:
        pair_features(region, leaves[piece], border, area, work, row)
    return answer(scorer.model, row)


@compiled
def _likeliest(waiting: list[tuple[float, int, int]], around: _Around) -> tuple[int, float]:
    """Remove and return the most likely neighbour and its log odds; -1: none.

    Outdated entries are skipped.
    """
    while len(waiting) > 0:
        minus, p, stamp = heapq.heappop(waiting)
        if around.version[p] == stamp and not around.inside[p]:
            return p, -minus
    return -1, 0.0


@compiled
def _grow(
    leaves: Floats, around: _Around, seeds: Ints, scorer: _Scorer, most: int, noted: int
) -> tuple[Ints, Floats, Floats, Ints]:
    region = np.zeros(WIDTH)
    region[sums.LOW : sums.HIGH], region[sums.HIGH :] = np.inf, -np.inf
    rows, asks = np.empty((noted, FEATURES)), np.empty((noted, 2), np.int64)
    order, odds = np.empty(most, np.int64), np.empty(most)
    waiting = [(0.0, 0, 0)][:0]
    found = scored = reached = 0
    for seed in seeds:
        if not around.inside[seed]:
            reached = _take_in(seed, leaves, region, around, reached)
    sized, era = region[sums.COUNT], 0
    while found < most:
        for f in range(reached):
            p = around.frontier[f]
            around.queued[p] = False
            chance = _odds(p, leaves, region, around, scorer)
            if scored < noted:
                rows[scored] = scorer.row
                asks[scored, 0], asks[scored, 1] = found, p
                scored += 1
            around.version[p] += 1
            around.era[p] = era
            heapq.heappush(waiting, (-chance, p, around.version[p]))
        added, chance = _likeliest(waiting, around)
        if added < 0:
            break
        reached = 0
        if around.era[added] < era:  # the region has outgrown this answer
            around.frontier[0], reached = added, 1
            continue
        order[found], odds[found] = added, chance
        found += 1
        reached = _take_in(added, leaves, region, around, reached)
        if region[sums.COUNT] > OUTGROWN * sized:
            sized = region[sums.COUNT]
            era += 1
    return order[:found], odds[:found], rows[:scored], asks[:scored]
