"""Candidate regions of clicks: unions of nodes of the merge tree."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.selection.objects import sums
from pointbrush.selection.objects.clicks import Clicks, Taken
from pointbrush.selection.objects.growing import Linked, grow_region
from pointbrush.selection.objects.options import LadderOptions
from pointbrush.selection.objects.state import ObjectState
from pointbrush.selection.objects.weights import Forest

Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]


class Origin(IntEnum):
    """Origin of a region; a number of the value model."""

    TREE = 0
    """A union of nodes of the merge tree."""
    ADDED = 1
    """The points taken so far, with a node."""
    REMOVED = 2
    """The points taken so far, without a node."""
    KEPT = 3
    """The points taken so far."""
    GROWN = 4
    """Pieces grown from the clicks one by one."""
    PLANE = 5
    """A floor, a wall or a table top."""


MOST_ODDS = 8.0
"""Maximum log odds of a merge, and value for a region without a merge."""
STEP = 1.03
"""Minimum growth factor between two different unions."""


@dataclass(frozen=True, slots=True, eq=False)
class Unions:
    """n regions: ``masks`` (n, P) of pieces; ``origin`` (n,): an ``Origin``.

    ``made`` and ``ended`` (n,): log odds of the last merge in a region and of its next merge.
    """

    masks: Mask
    made: NDArray[np.float64]
    ended: NDArray[np.float64]
    origin: Ints

    def __len__(self) -> int:
        return len(self.masks)


def find_unions(
    state: ObjectState,
    wanted: Clicks,
    unwanted: Clicks,
    taken: Taken | None,
    model: Forest,
    options: LadderOptions,
) -> Unions:
    """Return the regions with all wanted clicks and no unwanted ones.

    ``model`` is the merge model.  With ``taken``, additions to it and removals from it are
    included; the last region is then ``taken`` itself.
    """
    n, most = state.piece_count, options.times
    nothing = np.zeros(n, np.bool_)
    found = [_across_merge_times(state, wanted.piece, unwanted.piece, most, nothing, Origin.TREE)]
    if state.sensor in options.growing:
        found.append(_grown_regions(state, wanted.piece, unwanted.piece, model, options))
        found.append(_plane(state, wanted.piece, unwanted.piece))
    if taken is not None:
        if len(taken.missed):
            found.append(
                _across_merge_times(
                    state, taken.missed, unwanted.piece, most, taken.pieces, Origin.ADDED
                )
            )
        if len(taken.surplus):
            less = _across_merge_times(
                state, taken.surplus, wanted.piece, most, nothing, Origin.REMOVED
            )
            found.append(replace(less, masks=taken.pieces & ~less.masks))
    every = _without_repeats(_joined(found))
    if taken is None:
        return every
    zero = np.zeros(1)
    kept = Unions(taken.pieces[None], zero, zero, np.full(1, Origin.KEPT))
    return _joined([every, kept])


def _joined(parts: list[Unions]) -> Unions:
    return Unions(
        np.concatenate([part.masks for part in parts]),
        np.concatenate([part.made for part in parts]),
        np.concatenate([part.ended for part in parts]),
        np.concatenate([part.origin for part in parts]),
    )


def _without_repeats(unions: Unions) -> Unions:
    """Return the unions without repeated masks; the first one stays."""
    first: dict[bytes, int] = {}
    for i, packed in enumerate(np.packbits(unions.masks, axis=1)):
        first.setdefault(packed.tobytes(), i)
    kept = list(first.values())
    return Unions(unions.masks[kept], unions.made[kept], unions.ended[kept], unions.origin[kept])


def _across_merge_times(
    state: ObjectState, seeds: Ints, blocked: Ints, most: int, base: Mask, origin: Origin
) -> Unions:
    """Return unions, over merge times, of each seed's largest node without blocked pieces."""
    chains = [_chain(state.parent, int(seed), blocked) for seed in np.unique(seeds)]
    times = np.unique(np.concatenate(chains)) if chains else np.empty(0, np.int64)
    if len(times) == 0:
        nothing = np.empty(0)
        return Unions(np.empty((0, len(base)), np.bool_), nothing, nothing, np.empty(0, np.int64))
    reached = np.stack([chain[np.searchsorted(chain, times, "right") - 1] for chain in chains], 1)
    # Before the start of its chain a seed has its own piece.
    starts = np.array([chain[0] for chain in chains])
    reached = np.maximum(reached, starts)
    sizes = _sizes(reached, state.sums[:, sums.COUNT])
    kept = _spread(sizes, most)
    score = state.score.astype(np.float64)
    made = np.where(times[kept] < len(base), MOST_ODDS, np.minimum(score[times[kept]], MOST_ODDS))
    masks = _masks(state.parent, reached[kept], len(base)) | base
    return Unions(masks, made, _next_merge_odds(state, reached[kept]), np.full(len(kept), origin))


def _grown_regions(
    state: ObjectState, seeds: Ints, blocked: Ints, model: Forest, options: LadderOptions
) -> Unions:
    """Return regions grown from the seeds: per range of sizes the one least likely to grow."""
    count = state.piece_count
    barred = np.zeros(count, np.bool_)
    barred[blocked] = True
    barred[seeds] = False
    seeds = np.unique(seeds)
    leaves = state.sums[:count]
    pieces = Linked(leaves, state.pairs, state.between)
    order, odds = grow_region(pieces, seeds, barred, state.size**2, model, options.grown)[:2]
    size = leaves[seeds, sums.COUNT].sum() + np.append(0.0, np.cumsum(leaves[order, sums.COUNT]))
    made, ended = np.append(MOST_ODDS, odds), np.append(odds, -MOST_ODDS)
    kept = _stable_sizes(size, ended, options.grown_kept)
    masks = np.zeros((len(kept), count), np.bool_)
    masks[:, seeds] = True
    for row, added in zip(masks, kept.tolist(), strict=True):
        row[order[:added]] = True
    clipped = np.clip([made[kept], ended[kept]], -MOST_ODDS, MOST_ODDS)
    return Unions(masks, clipped[0], clipped[1], np.full(len(kept), Origin.GROWN))


def _plane(state: ObjectState, seeds: Ints, blocked: Ints) -> Unions:
    """Return the pieces of the planes that contain all seeds; empty if there are none."""
    first = state.plane[:, seeds[:1]]
    found = (state.plane[:, seeds] == first).all(axis=1) & (first[:, 0] >= 0)
    masks = state.plane[found] == first[found]
    masks[:, blocked] = False
    masks[:, seeds] = True
    odds = np.full(len(masks), MOST_ODDS)
    return Unions(masks, odds, -odds, np.full(len(masks), Origin.PLANE))


def _stable_sizes(size: NDArray[np.float64], ended: NDArray[np.float64], most: int) -> Ints:
    """Return ascending indices of at most ``most`` sizes, with the least ``ended`` of each step."""
    if size[-1] <= size[0]:
        return np.zeros(1, np.int64)
    step = np.minimum((most * np.log(size / size[0]) / np.log(size[-1] / size[0])), most - 1)
    order = np.lexsort((ended, step.astype(np.int64)))
    first = np.flatnonzero(np.diff(step.astype(np.int64)[order], prepend=-1))
    return np.sort(order[first])


def _next_merge_odds(state: ObjectState, reached: Ints) -> NDArray[np.float64]:
    """Return the maximum log odds (n,) of the next merges of the nodes, -8 for none."""
    parents = state.parent[reached].astype(np.int64)
    odds = np.where(parents >= 0, state.score[np.maximum(parents, 0)], -8.0)
    return np.asarray(np.clip(odds.max(axis=1), -8.0, 8.0), np.float64)


def _chain(parent: NDArray[np.int32], piece: int, blocked: Ints) -> Ints:
    """Return a piece and its ancestors without blocked pieces, ascending."""
    barred = _ancestors(parent, blocked)
    chain, node = [piece], int(parent[piece])
    while node >= 0 and not barred[node]:
        chain.append(node)
        node = int(parent[node])
    return np.array(chain, np.int64)


@compiled
def _ancestors(parent: NDArray[np.int32], pieces: Ints) -> Mask:
    """Return a mask of the nodes that contain one of the pieces."""
    held = np.zeros(len(parent), np.bool_)
    for piece in pieces:
        node = piece
        while node >= 0 and not held[node]:
            held[node] = True
            node = parent[node]
    return held


@compiled
def _sizes(reached: Ints, size: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the number of cells (n,) of unions of nodes (n, seeds), counting each node once."""
    total = np.zeros(len(reached))
    for i in range(len(reached)):
        for s in range(reached.shape[1]):
            counted = False
            for r in range(s):
                counted |= reached[i, r] == reached[i, s]
            if not counted:
                total[i] += size[reached[i, s]]
    return total


def _spread(sizes: NDArray[np.float64], most: int) -> Ints:
    """Return ascending indices of at most ``most`` sizes: the last ones before a step of growth."""
    step = STEP
    while True:
        growth = np.append(sizes[1:] / sizes[:-1], np.inf)
        kept = np.flatnonzero(growth >= step)
        if len(kept) <= most:
            return kept
        step = 1 + 1.3 * (step - 1)


@compiled
def _masks(parent: NDArray[np.int32], reached: Ints, pieces: int) -> Mask:
    """Return masks (n, P) of the pieces below the nodes (n, seeds)."""
    masks = np.zeros((len(reached), pieces), np.bool_)
    inside = np.zeros(len(parent), np.bool_)
    for i in range(len(reached)):
        inside[:] = False
        for s in range(reached.shape[1]):
            inside[reached[i, s]] = True
        for node in range(len(parent) - 1, -1, -1):
            if parent[node] >= 0 and inside[parent[node]]:
                inside[node] = True
        masks[i] = inside[:pieces]
    return masks
