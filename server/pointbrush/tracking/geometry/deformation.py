"""People and other things that bend: a graph of nodes that move together but not alike."""

from __future__ import annotations

import numpy as np

from pointbrush.tracking.geometry.columns import Columns, nearest_one, spans, toned
from pointbrush.tracking.geometry.compiled import compiled
from pointbrush.tracking.geometry.grid import cells_of, means_of
from pointbrush.tracking.geometry.registration import Target
from pointbrush.tracking.interface import F32, F64, I64

LINKS = 4
ROUNDS = 3
LEAN = 0.5
"""Weight with which a node stays where the round before left it."""


def nodes_of(xyz: F64, apart: float) -> F64:
    """(K, 3) means of the points (M, 3) of each cell of ``apart`` metres."""
    return means_of(xyz, cells_of(xyz, apart))


def warp(place: F64, colour: F32, target: Target, apart: float, scale: float) -> F64:
    """Bend ``place`` (M, 3) onto the target: displacements (M, 3), smooth over the node graph.

    Nodes lie ``apart`` metres from each other; ``scale`` metres is the distance at which a pair
    counts half.  Each round pairs the points in place and colour, averages the displacements at
    the nodes, and smooths them over each node's neighbours.
    """
    nodes = nodes_of(place, apart)
    link, square = _nearest_nodes(place, nodes, min(LINKS, len(nodes)))
    share = np.exp(-square / apart**2) + 1e-9
    share /= share.sum(axis=1, keepdims=True)
    around, _ = _nearest_nodes(nodes, nodes, min(6, len(nodes)))
    grid, weight = target.columns, target.weight
    return _pulled(place, colour, grid, weight, link, share, around, scale)


@compiled
def _nearest_nodes(place: F64, nodes: F64, count: int) -> tuple[I64, F64]:
    """(M, count) numbers of the nearest nodes of each place (M, 3), nearest first, and squares of
    their distances: nodes are few, so that all are asked."""
    link, square = np.zeros((len(place), count), np.int64), np.full((len(place), count), np.inf)
    for i in range(len(place)):
        for node in range(len(nodes)):
            away = 0.0
            for a in range(3):
                away += (nodes[node, a] - place[i, a]) ** 2
            if away >= square[i, count - 1]:
                continue
            at = count - 1
            while at > 0 and away < square[i, at - 1]:
                square[i, at], link[i, at] = square[i, at - 1], link[i, at - 1]
                at -= 1
            square[i, at], link[i, at] = away, node
    return link, square


@compiled
def _pulled(
    place: F64,
    colour: F32,
    grid: Columns,
    weight: float,
    link: I64,
    share: F64,
    around: I64,
    scale: float,
) -> F64:
    """Displacements (M, 3) of points that are ``link``ed (M, LINKS) to nodes by a ``share``."""
    moved, offset = np.zeros((len(around), 3)), np.zeros_like(place)
    pulls, total = np.empty_like(moved), np.empty(len(around))
    tint, room, coloured = (0.0, 0.0, 0.0), spans(grid), len(grid.tint) > 0
    last = np.full(len(place), -1)
    for turn in range(ROUNDS):
        s = scale / (1 + 0.5 * turn)
        pulls[:], total[:] = LEAN * moved, LEAN
        for i in range(len(place)):
            if coloured:
                tint = toned(colour, i, weight)
            x, y, z = place[i, 0], place[i, 1], place[i, 2]
            at = (x + offset[i, 0], y + offset[i, 1], z + offset[i, 2])
            square, near = nearest_one(grid, at, tint, 3.0 * s, room, last[i])
            last[i] = near
            if near < 0:
                continue
            w = 1.0 / (1.0 + square / (s * s)) ** 2
            for k in range(link.shape[1]):
                node = link[i, k]
                part = w * share[i, k]
                total[node] += part
                for a in range(3):
                    pulls[node, a] += part * (grid.xyz[near, a] - place[i, a])
        for node in range(len(moved)):
            for a in range(3):
                pulls[node, a] /= total[node]
        for node in range(len(moved)):
            for a in range(3):
                mean = 0.0
                for other in around[node]:
                    mean += pulls[other, a]
                moved[node, a] = 0.5 * pulls[node, a] + 0.5 * mean / around.shape[1]
        for i in range(len(place)):
            for a in range(3):
                offset[i, a] = 0.0
                for k in range(link.shape[1]):
                    offset[i, a] += share[i, k] * moved[link[i, k], a]
    return offset
