"""Graphs of points: links, shortest paths, connected components, mean field."""

from __future__ import annotations

from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled, innermost
from pointbrush.tracking.compute.columns import pairs
from pointbrush.tracking.compute.grid import cells_of, means_of
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.options.steps import ComponentOptions


class Paths(NamedTuple):
    """Directed links of cells in compressed rows.

    Links of cell n lead to ``end`` with ``length``, from ``start[n]`` up to the next cell's.
    """

    start: I64
    end: I64
    length: F64


@compiled
def paths_into(links: I64, length: F64, sought: Mask) -> Paths:
    """Return both directions of ``links`` (P, 2), each of ``length`` (P,), into ``sought`` (N,)."""
    start = np.zeros(len(sought) + 1, np.int64)
    for one, other in links:
        start[one + 1] += sought[other]
        start[other + 1] += sought[one]
    for n in range(len(sought)):
        start[n + 1] += start[n]
    free = start[:-1].copy()
    end, far = np.empty(start[-1], np.int64), np.empty(start[-1])
    for k in range(len(links)):
        for side in range(2):
            source, target = links[k, side], links[k, 1 - side]
            if sought[target]:
                end[free[source]], far[free[source]] = target, length[k]
                free[source] += 1
    return Paths(start, end, far)


@compiled
def paths_over(links: I64, length: F64, leads: Mask) -> Paths:
    """Return both directions of ``links`` (P, 2), of ``length`` (P,), from cells in ``leads``."""
    start = np.zeros(len(leads) + 1, np.int64)
    for one, other in links:
        start[one + 1] += leads[one]
        start[other + 1] += leads[other]
    for n in range(len(leads)):
        start[n + 1] += start[n]
    free = start[:-1].copy()
    end, far = np.empty(start[-1], np.int64), np.empty(start[-1])
    for k in range(len(links)):
        for side in range(2):
            node = links[k, side]
            if leads[node]:
                end[free[node]], far[free[node]] = links[k, 1 - side], length[k]
                free[node] += 1
    return Paths(start, end, far)


@compiled
def shortest_paths(ways: Paths, source: I64, allowed: Mask) -> tuple[F64, I64]:
    """Find the length (N,) of the shortest path from a source, inf for none, and that source (N,).

    Over cells ``allowed`` (N,) and the sources alone.  Source: Dijkstra 1959, with a heap.
    """
    count = len(allowed)
    way, origin, open_ = np.full(count, np.inf), np.zeros(count, np.int64), allowed.copy()
    heap = [(0.0, 0) for _ in range(0)]
    for cell in source:
        way[cell], origin[cell], open_[cell] = 0.0, cell, True
        heap.append((0.0, cell))
    while heap:
        length, node = heappop(heap)
        if length > way[node]:
            continue
        for k in range(ways.start[node], ways.start[node + 1]):
            neighbour, far = ways.end[k], length + ways.length[k]
            if open_[neighbour] and far < way[neighbour]:
                way[neighbour], origin[neighbour] = far, origin[node]
                heappush(heap, (far, neighbour))
    return way, origin


def pieces(xyz: F64, unit: float, options: ComponentOptions) -> I64:
    """Return (N,) the connected component of each point; ``unit``: tolerance (m)."""
    cell = cells_of(xyz, options.cell_units * unit)
    middle = means_of(xyz, cell)
    everywhere = np.ones(len(middle), np.bool_)
    return np.asarray(
        parts(pairs(middle, options.touching_cells * options.cell_units * unit), everywhere)[cell]
    )


@compiled
def parts(links: I64, some: Mask) -> I64:
    """Return (N,) the connected component of each cell in ``some`` (N,), from 0; -1: others.

    ``links`` (P, 2): linked pairs of cells.  Source: union-find, Tarjan 1975.
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
    """Return the root of the union-find tree ``root`` (N,) from ``at``, halving the path on the
    way."""
    while root[at] != at:
        root[at] = root[root[at]]
        at = root[at]
    return at


def solid(xyz: F64, unit: float, options: ComponentOptions) -> Mask:
    """Mark the points (N, 3) of a label in large connected components; all if these have too few.

    Painted objects include flying pixels at their outline, anywhere between the object and the
    wall, which would extend a pin up to the wall.
    """
    if not len(xyz):
        return np.ones(0, np.bool_)
    piece = pieces(xyz, options.apart_factor * unit, options=options)
    kept = np.bincount(piece)[piece] >= min(options.crumb_points, options.crumb_share * len(xyz))
    return kept if 2 * np.count_nonzero(kept) > len(xyz) else np.ones(len(xyz), np.bool_)


@compiled
def agreed(
    cost: F64,
    links: Paths,
    sweeps: int,
    settled_change: float,
    same_change: float,
    neighbour_weight: float,
    full_neighbours: float,
) -> F64:
    """Return (N, K) the probability of each cell to belong to each owner, by ``cost`` (N, K).

    ``links``: from each cell to its neighbours; their length is the weight of the neighbour.
    """
    count, many = cost.shape
    share, now = np.empty((count, many)), np.empty(many)
    updated, changed = np.zeros(count, np.int64), np.zeros(count, np.int64)
    for i in range(count):
        _normalised(-cost[i], share[i])
    for sweep in range(sweeps):
        change = 0.0
        for turn in range(count):
            i = turn if sweep % 2 == 0 else count - 1 - turn
            if sweep > 0 and _newest(links, i, changed) < updated[i]:
                continue
            total = _sum_neighbours(links, i, share, now)
            scale = (
                neighbour_weight * min(1.0, total / full_neighbours) / total if total > 0.0 else 0.0
            )
            for k in range(many):
                now[k] = scale * now[k] - cost[i, k]
            _normalised(now, now)
            difference = 0.0
            for k in range(many):
                difference = max(difference, abs(now[k] - share[i, k]))
                share[i, k] = now[k]
            change = max(change, difference)
            updated[i] = sweep * count + turn + 1
            if difference > same_change:
                changed[i] = updated[i]
        if change < settled_change:
            break
    return share


@compiled
def _newest(links: Paths, cell: int, moved: I64) -> int:
    """Return the last turn in which a neighbour of a cell ``moved`` (N,)."""
    newest = 0
    for n in range(links.start[cell], links.start[cell + 1]):
        newest = max(newest, moved[links.end[n]])
    return newest


@compiled
def _sum_neighbours(links: Paths, cell: int, share: F64, out: F64) -> float:
    """Write the weighted sum of shares (N, K) of a cell's neighbours to ``out`` (K,).

    Returns their total weight.
    """
    out[:] = 0.0
    total = 0.0
    for n in range(links.start[cell], links.start[cell + 1]):
        total += links.length[n]
        for k in range(len(out)):
            out[k] += links.length[n] * share[links.end[n], k]
    return total


@compiled
def _normalised(odds: F64, out: F64) -> None:
    """Write the probabilities of log ``odds`` (K,) to ``out`` (K,)."""
    most, total = odds.max(), 0.0
    for k in range(len(odds)):
        out[k] = np.exp(odds[k] - most)
        total += out[k]
    for k in range(len(odds)):
        out[k] /= total
