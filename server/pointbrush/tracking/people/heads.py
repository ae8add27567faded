"""Heads of people who touch: bodies are told apart by what lies beneath each."""

from __future__ import annotations

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.compute.graph import Paths, paths_into, root_of
from pointbrush.tracking.interface import F64, I64
from pointbrush.tracking.people.observation import Observation
from pointbrush.tracking.people.stature import top_of


def beneath_heads(
    sight: Observation, cells: I64, least: float, area: float
) -> list[tuple[I64, I64]]:
    """Of a person's ``cells`` (C,) those of one and of the other of two people, either way round;
    none where they are not two people's of ``least`` cells or more, each seen to end above;
    ``area`` showed of them at most."""
    options = sight.options.body
    some = np.zeros(len(sight.owner), np.bool_)
    some[cells] = True
    links = paths_into(sight.cells.touching, np.ones(len(sight.cells.touching)), some)
    height = sight.cells.middle @ sight.up
    order = cells[np.argsort(-height[cells], kind="stable")]
    head = _peaks(order, links, height, sight.ground, options.head_m)[cells]
    heads, count = np.unique(head, return_counts=True)
    largest = np.argsort(-count, kind="stable")[:2]
    if len(largest) < 2 or count[largest[1]] < least:
        return []
    one, two = (cells[head == heads[n]] for n in largest)
    top, other = (top_of(sight, each, area) for each in (one, two))
    if top is None or other is None or abs(top - other) > options.head_lower_m:
        return []
    gap = np.median(sight.ground[one], axis=0) - np.median(sight.ground[two], axis=0)
    return [(one, two), (two, one)] if np.linalg.norm(gap) > options.heads_apart_m else []


@compiled
def _peaks(order: I64, links: Paths, height: F64, ground: F64, least: float) -> I64:
    """(N,) the peak that each of the cells ``order`` (C,), highest first, is beneath, -1 for the
    others; a peak that stands out by less than ``least`` metres is a part of the one it meets."""
    peak, root = np.full(len(height), -1), np.arange(len(height))
    for i in order:
        highest = -1
        for n in range(links.start[i], links.start[i + 1]):
            if peak[links.end[n]] >= 0:
                top = root_of(root, peak[links.end[n]])
                if highest < 0 or height[top] > height[highest]:
                    highest = top
        if highest < 0:
            peak[i] = i
            continue
        nearest, away = highest, np.sum((ground[i] - ground[highest]) ** 2)
        for n in range(links.start[i], links.start[i + 1]):
            if peak[links.end[n]] >= 0:
                top = root_of(root, peak[links.end[n]])
                if top != highest and height[top] - height[i] < least:
                    root[top] = highest
                elif top != highest:
                    gap = np.sum((ground[i] - ground[top]) ** 2)
                    if gap < away:
                        nearest, away = top, gap
        peak[i] = nearest
    for i in order:
        peak[i] = root_of(root, peak[i])
    return peak
