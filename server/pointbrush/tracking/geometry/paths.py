"""Shortest ways over cells that touch, from the nearest of some of them."""

from __future__ import annotations

from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.interface import F64, I64, Mask


class Paths(NamedTuple):
    """From cell n ways of ``length`` lead to the cells ``end``, each from ``start[n]`` up to the
    next cell's."""

    start: I64
    end: I64
    length: F64


@compiled
def paths_into(links: I64, length: F64, sought: Mask) -> Paths:
    """Both ways along ``links`` (P, 2), each ``length`` (P,), into the cells that are ``sought``
    (N,)."""
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
            here, there = links[k, side], links[k, 1 - side]
            if sought[there]:
                end[free[here]], far[free[here]] = there, length[k]
                free[here] += 1
    return Paths(start, end, far)


@compiled
def paths_over(links: I64, length: F64, leads: Mask) -> Paths:
    """Both ways along ``links`` (P, 2), each ``length`` (P,), out of the cells that ``leads`` (N,)
    anywhere."""
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
            here = links[k, side]
            if leads[here]:
                end[free[here]], far[free[here]] = links[k, 1 - side], length[k]
                free[here] += 1
    return Paths(start, end, far)


@compiled
def reach(ways: Paths, source: I64, allowed: Mask) -> tuple[F64, I64]:
    """Length (N,) of the way from the nearest source, inf for none, and that source.

    Over cells ``allowed`` (N,) and the sources alone.  Source: Dijkstra 1959, with a heap.
    """
    count = len(allowed)
    way, origin, open_ = np.full(count, np.inf), np.zeros(count, np.int64), allowed.copy()
    heap = [(0.0, 0) for _ in range(0)]
    for cell in source:
        way[cell], origin[cell], open_[cell] = 0.0, cell, True
        heap.append((0.0, cell))
    while heap:
        length, here = heappop(heap)
        if length > way[here]:
            continue
        for k in range(ways.start[here], ways.start[here + 1]):
            there, far = ways.end[k], length + ways.length[k]
            if open_[there] and far < way[there]:
                way[there], origin[there] = far, origin[here]
                heappush(heap, (far, there))
    return way, origin
