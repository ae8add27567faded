"""The merge tree: neighbouring pieces joined pair by pair, the most likely first.

The merge model uses features of two pieces: the smaller a, the larger b.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost
from pointbrush.selection.objects import sums
from pointbrush.selection.objects.sums import PAIR_WIDTH, WIDTH, Pieces
from pointbrush.selection.objects.weights import Forest, answer

Floats = NDArray[np.float64]
# Features of a pair: of the smaller piece a, the larger b, their boundary and their union.
SIZE_A, SIZE_B, BORDER_A, BORDER_B, BORDER_WIDTH, BORDER_TURN, BORDER_LENGTH = 0, 1, 2, 3, 4, 5, 9
LIGHTNESS, TINT, SPREAD_A, SPREAD_B, COLOUR = range(10, 15)
ALIGNED_A, ALIGNED_B, NORMALS, AHEAD_A, AHEAD_B, AHEAD, APART = range(15, 22)
THIN_A, LONG_A, THIN_B, THIN_UNION, LONGER, APART_OVER_LONG = range(22, 28)
ROUGH_A, ROUGH_B, STEEP_A, STEEP_B, HIGHER, LOW_A, LOW_B, LOWER, TALLER = range(28, 37)
UNION_BOX, WIDER, TALLER_BOX, HIGH_A, SIZES = 37, 40, 41, 42, 43
FEATURES = 44
"""Number of features of a pair."""
TINY = 1e-6
Ints = NDArray[np.int64]
GROWN = 1.1
"""Growth factor of a piece after which its kept pairs are scored again."""


@innermost
def pair_features(
    a: Floats, b: Floats, pair: Floats, area: float, work: Floats, out: Floats
) -> None:
    """Write the 44 features of a pair to ``out``.

    ``a``, ``b``: sums of the smaller and the larger piece; ``pair``: sums of their boundary;
    ``area``: of a cell, square metres; ``work`` (3, WIDTH): buffer.
    """
    na, nb, m = a[sums.COUNT], b[sums.COUNT], pair[sums.EDGES]
    out[SIZE_A], out[SIZE_B] = np.log(na * area), np.log(nb * area)
    out[BORDER_A] = m / max(a[sums.PERIMETER], 1.0)
    out[BORDER_B] = m / max(b[sums.PERIMETER], 1.0)
    out[BORDER_WIDTH] = m / np.sqrt(na)
    for k in range(4):
        out[BORDER_TURN + k] = pair[sums.TURN + k] / m
    out[BORDER_LENGTH] = pair[sums.LENGTH] / m / np.sqrt(area)
    _colours(a, b, out)
    _normals(a, b, out)
    _extents(a, b, work, out)
    out[ROUGH_A], out[ROUGH_B] = a[sums.ROUGH] / na, b[sums.ROUGH] / nb
    out[STEEP_A], out[STEEP_B] = a[sums.STEEP] / na, b[sums.STEEP] / nb
    z = sums.XYZ + 2
    out[HIGHER] = b[z] / nb - a[z] / na
    low, high = sums.LOW + 2, sums.HIGH + 2
    out[LOW_A], out[LOW_B] = a[low], b[low]
    out[LOWER], out[TALLER] = b[low] - a[low], b[high] - a[high]
    sums.box(work[0], work[1])
    for k in range(3):
        out[UNION_BOX + k] = work[1][k]
    sums.box(b, work[1])
    out[WIDER] = out[UNION_BOX] - work[1][0]
    out[TALLER_BOX] = out[UNION_BOX + 1] - work[1][1]
    out[HIGH_A], out[SIZES] = a[high], np.log(na / nb)


@innermost
def _colours(a: Floats, b: Floats, out: Floats) -> None:
    na, nb, apart = a[sums.COUNT], b[sums.COUNT], 0.0
    for k in range(3):
        step = abs(a[sums.LAB + k] / na - b[sums.LAB + k] / nb)
        if k == 0:
            out[LIGHTNESS] = step
        else:
            apart += step * step
    out[TINT] = np.sqrt(apart)
    out[SPREAD_A], out[SPREAD_B] = sums.colour_spread(a), sums.colour_spread(b)
    step = np.sqrt(out[LIGHTNESS] * out[LIGHTNESS] + apart)
    out[COLOUR] = step / (1.0 + out[SPREAD_A] + out[SPREAD_B])


@innermost
def _normals(a: Floats, b: Floats, out: Floats) -> None:
    na, nb = a[sums.COUNT], b[sums.COUNT]
    way = dot = one = other = 0.0
    for k in range(3):
        step = b[sums.XYZ + k] / nb - a[sums.XYZ + k] / na
        p, q = a[sums.NORMAL + k] / na, b[sums.NORMAL + k] / nb
        way += step * step
        dot += p * q
        one += p * step
        other += q * step
    way = np.sqrt(way)
    out[ALIGNED_A], out[ALIGNED_B] = sums.normal_length(a), sums.normal_length(b)
    out[NORMALS] = dot / max(out[ALIGNED_A] * out[ALIGNED_B], TINY)
    out[AHEAD_A], out[AHEAD_B] = one / max(way, TINY), other / max(way, TINY)
    out[AHEAD] = out[AHEAD_A] - out[AHEAD_B]
    out[APART] = way


@innermost
def _extents(a: Floats, b: Floats, work: Floats, out: Floats) -> None:
    """Write the extents of a, b and both; ``work[0]`` gets the union's sums."""
    sums.extents(a, work[1])
    out[THIN_A], out[LONG_A] = work[1][0], work[1][2]
    sums.extents(b, work[1])
    out[THIN_B] = work[1][0]
    sums.add(a, b, work[0])
    sums.extents(work[0], work[2])
    out[THIN_UNION], out[LONGER] = work[2][0], work[2][2] - work[1][2]
    out[APART_OVER_LONG] = out[APART] / max(out[LONG_A] + work[1][2], TINY)


@dataclass(frozen=True, slots=True, eq=False)
class MergeTree:
    """P pieces, numbers 0..P-1, and M merged nodes in the order of merging.

    ``parent`` (P + M,): int64, -1 for a root; ``score`` (P + M,): log odds of a node's merge, inf
    for pieces; ``sums`` (P + M, WIDTH); ``first`` (B,): log odds of the first pairs.
    """

    parent: Ints
    score: Floats
    sums: Floats
    first: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Scored:
    """All scored pairs: ``rows`` (S, FEATURES), ``nodes`` (S, 2) smaller and larger."""

    rows: Floats
    nodes: Ints


def grow_tree(pieces: Pieces, area: float, model: Forest) -> MergeTree:
    """Return the tree of pieces under a merge model; ``area`` of a cell, square metres."""
    return record_tree(pieces, area, model, 0)[0]


def record_tree(pieces: Pieces, area: float, model: Forest, most: int) -> tuple[MergeTree, Scored]:
    """Return the tree, and at most ``most`` scored pairs."""
    parent, score, totals, first, rows, nodes = _merge(
        pieces.sums, pieces.pairs, pieces.between, area, model, most
    )
    return MergeTree(parent, score, totals, first), Scored(rows, nodes)


class _Borders(NamedTuple):
    """B borders between nodes during merging.

    ``ends`` (B, 2): nodes; ``between`` (B, PAIR_WIDTH): sums; ``version`` (B,): of the newest
    score, -1 for removed borders; ``sized`` (B,): cells of both nodes when scored, -1 to be scored
    again; ``fresh`` (B,): starts with the latter.  A node's borders are a linked list from ``head``
    (M,) through ``following`` (2 B,), with slots 2 b and 2 b + 1 for the ends of border b.  ``at``
    (M,): border of a neighbour with the newest node, if that is in ``seen`` (M,).
    """

    ends: Ints
    between: Floats
    version: Ints
    sized: Floats
    fresh: Ints
    head: Ints
    following: Ints
    seen: Ints
    at: Ints


@compiled
def _borders_of(pairs: Ints, between: Floats, nodes: int) -> _Borders:
    """Return the borders of the first ``pairs`` (B, 2), all fresh, with space for ``nodes``."""
    count = len(pairs)
    head, following = np.full(nodes, -1, np.int64), np.full(2 * count, -1, np.int64)
    for b in range(count):
        for side in range(2):
            following[2 * b + side] = head[pairs[b, side]]
            head[pairs[b, side]] = 2 * b + side
    return _Borders(
        pairs.copy(),
        between.copy(),
        np.zeros(count, np.int64),
        np.zeros(count),
        np.arange(count),
        head,
        following,
        np.full(nodes, -1, np.int64),
        np.full(nodes, -1, np.int64),
    )


@innermost
def _pass_on_borders(borders: _Borders, total: Floats, node: int, joined: tuple[int, int]) -> int:
    """Move the borders of the ``joined`` nodes to a new node; return the number of fresh ones."""
    count = 0
    for old in joined:
        slot = borders.head[old]
        while slot >= 0:
            after = borders.following[slot]
            if borders.version[slot // 2] >= 0:
                count = _pass_on(borders, total, node, slot, count)
            slot = after
    return count


@innermost
def _pass_on(borders: _Borders, total: Floats, node: int, slot: int, count: int) -> int:
    """Move the border of a slot to a new node; return the new ``count`` of fresh ones."""
    b, side = slot // 2, slot % 2
    far = borders.ends[b, 1 - side]
    borders.ends[b, side] = node
    if borders.seen[far] == node:
        # Both had this neighbour: their borders are merged.
        kept, changed = borders.at[far], True
        for k in range(PAIR_WIDTH):
            borders.between[kept, k] += borders.between[b, k]
        borders.version[b] = -1
    else:
        borders.seen[far], borders.at[far] = node, b
        borders.following[slot], borders.head[node] = borders.head[node], slot
        grown = total[node, sums.COUNT] + total[far, sums.COUNT]
        kept, changed = b, grown > GROWN * borders.sized[b]
    if changed and borders.sized[kept] >= 0:
        borders.sized[kept] = -1.0
        borders.fresh[count] = kept
        count += 1
    return count


@innermost
def _smaller_first(total: Floats, ends: Ints, border: int) -> tuple[int, int]:
    """Return both nodes of a border, the one with fewer cells first."""
    one, other = ends[border, 0], ends[border, 1]
    return (other, one) if total[one, sums.COUNT] > total[other, sums.COUNT] else (one, other)


@compiled
def _best_border(waiting: list[tuple[float, int, int]], version: Ints) -> tuple[int, float]:
    """Remove and return the most likely border of the heap and its log odds; -1: none.

    Outdated entries are skipped.
    """
    while len(waiting) > 0:
        minus, b, stamp = heapq.heappop(waiting)
        if version[b] == stamp:
            return b, -minus
    return -1, 0.0


@innermost
def _copy(values: Floats, out: Floats) -> None:
    """Write ``values`` to ``out``; an assignment takes 2 s longer to compile, for its error."""
    for k in range(len(values)):
        out[k] = values[k]


@compiled
def _merge(
    leaves: Floats,
    first_pairs: Ints,
    first_between: Floats,
    area: float,
    model: Forest,
    most: int,
) -> tuple[Ints, Floats, Floats, Floats, Floats, Ints]:
    count = len(leaves)
    nodes = max(2 * count - 1, 0)
    parent, made = np.full(nodes, -1, np.int64), np.full(nodes, np.inf)
    total = np.empty((nodes, WIDTH))
    for leaf in range(count):
        _copy(leaves[leaf], total[leaf])
    borders = _borders_of(first_pairs, first_between, nodes)
    ends, version, fresh = borders.ends, borders.version, borders.fresh
    rows, scored = np.empty((most, FEATURES)), np.empty((most, 2), np.int64)
    noted = 0
    work, row = np.empty((3, WIDTH)), np.empty(FEATURES)
    first = np.empty(len(ends))
    waiting = [(0.0, 0, 0)][:0]
    fresh_count, node, has_child = len(ends), count, False
    while True:
        for f in range(fresh_count):
            b = fresh[f]
            one, other = _smaller_first(total, ends, b)
            pair_features(total[one], total[other], borders.between[b], area, work, row)
            odds = answer(model, row)
            if noted < most:
                _copy(row, rows[noted])
                scored[noted, 0], scored[noted, 1] = one, other
                noted += 1
            if not has_child:
                first[b] = odds
            version[b] += 1
            borders.sized[b] = total[one, sums.COUNT] + total[other, sums.COUNT]
            heapq.heappush(waiting, (-odds, b, version[b]))
        has_child = True
        found, odds = _best_border(waiting, version)
        if found < 0:
            break
        one, other = ends[found, 0], ends[found, 1]
        version[found] = -1
        parent[one] = parent[other] = node
        made[node] = odds
        sums.add(total[one], total[other], total[node])
        total[node, sums.PERIMETER] -= 2 * borders.between[found, sums.EDGES]
        fresh_count = _pass_on_borders(borders, total, node, (one, other))
        node += 1
    return parent[:node], made[:node], total[:node], first, rows[:noted], scored[:noted]
