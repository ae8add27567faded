"""Deformation graph of people and other bending objects: nodes with smooth motions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.compute.columns import Columns, nearest_one, spans, toned
from pointbrush.tracking.compute.grid import cells_of, means_of
from pointbrush.tracking.compute.rigid import Source, Target
from pointbrush.tracking.interface import F32, F64, I64
from pointbrush.tracking.options.steps import DeformationOptions


def nodes_of(xyz: F64, apart: float) -> F64:
    """Return (K, 3) the mean of the points (M, 3) of each cell of ``apart`` metres."""
    return means_of(xyz, cells_of(xyz, apart))


class DeformationGraph(NamedTuple):
    """Nodes (K,) that carry the points (M,) around them (Sumner, Schmid and Pauly 2007).

    ``link`` (M, LINKS): nodes that move each point; ``share`` (M, LINKS): their weights, with a sum
    of 1; ``around`` (K, AROUND): nodes that smooth each node's motion.  With fewer nodes, each has
    all of them.
    """

    link: I64
    share: F64
    around: I64


def warp(
    surface: F64,
    colour: F32,
    target: Target,
    apart: float,
    scale: float,
    options: DeformationOptions,
) -> F64:
    """Bend ``surface`` (M, 3) onto the target: displacements (M, 3), smooth over the node graph.

    Nodes lie ``apart`` metres from each other; ``scale`` metres is the distance at which a pair
    weighs a quarter.  Each round pairs the points in place and colour, averages the displacements
    at the nodes, and smooths them over each node's neighbours.
    """
    return _pulled(
        Source(surface, colour),
        target.columns,
        _graph_of(surface, apart, options=options),
        scale,
        options.rounds,
        options.previous_weight,
        options.round_shrink,
        options.pair_scales,
        options.smooth_weight,
    )


def _graph_of(surface: F64, apart: float, options: DeformationOptions) -> DeformationGraph:
    """Return a graph with nodes ``apart`` metres from each other over the points (M, 3)."""
    nodes = nodes_of(surface, apart)
    link, square = _nearest_nodes(surface, nodes, min(options.nodes_per_point, len(nodes)))
    share = np.exp(-square / apart**2) + 1e-9
    share /= share.sum(axis=1, keepdims=True)
    around, _ = _nearest_nodes(nodes, nodes, min(options.nodes_around, len(nodes)))
    return DeformationGraph(link, share, around)


@compiled
def _nearest_nodes(surface: F64, nodes: F64, count: int) -> tuple[I64, F64]:
    """Return (M, count) the nearest nodes of each position (M, 3) and their squared distances.

    They are in ascending order.  All nodes are compared, as they are few.
    """
    link, square = np.zeros((len(surface), count), np.int64), np.full((len(surface), count), np.inf)
    for i in range(len(surface)):
        for node in range(len(nodes)):
            distance = 0.0
            for a in range(3):
                distance += (nodes[node, a] - surface[i, a]) ** 2
            if distance >= square[i, count - 1]:
                continue
            at = count - 1
            while at > 0 and distance < square[i, at - 1]:
                square[i, at], link[i, at] = square[i, at - 1], link[i, at - 1]
                at -= 1
            square[i, at], link[i, at] = distance, node
    return link, square


@compiled
def _pulled(
    source: Source,
    grid: Columns,
    graph: DeformationGraph,
    scale: float,
    rounds: int,
    previous_weight: float,
    round_shrink: float,
    pair_scales: float,
    smooth_weight: float,
) -> F64:
    """See ``warp``: displacements (M, 3) of the points that the graph carries."""
    surface, colour = source
    link, share, around = graph
    moved, offset = np.zeros((len(around), 3)), np.zeros_like(surface)
    pulls, total = np.empty_like(moved), np.empty(len(around))
    room, last = spans(grid), np.full(len(surface), -1)
    for turn in range(rounds):
        s = scale / (1 + round_shrink * turn)
        pulls[:], total[:] = previous_weight * moved, previous_weight
        for i in range(len(surface)):
            x, y, z = surface[i, 0], surface[i, 1], surface[i, 2]
            at = (x + offset[i, 0], y + offset[i, 1], z + offset[i, 2])
            tint = toned(grid, colour, i)
            square, near = nearest_one(grid, at, tint, pair_scales * s, room, last[i])
            last[i] = near
            if near < 0:
                continue
            w = 1.0 / (1.0 + square / (s * s)) ** 2
            for k in range(link.shape[1]):
                node = link[i, k]
                part = w * share[i, k]
                total[node] += part
                for a in range(3):
                    pulls[node, a] += part * (grid.xyz[near, a] - surface[i, a])
        _smoothed(moved, pulls, total, around, smooth_weight)
        _carry(offset, moved, link, share)
    return offset


@compiled
def _smoothed(moved: F64, pulls: F64, total: F64, around: I64, smooth_weight: float) -> None:
    """Move the nodes (K, 3) by their mean ``pulls``, smoothed over the nodes ``around`` each."""
    for node in range(len(moved)):
        for a in range(3):
            pulls[node, a] /= total[node]
    for node in range(len(moved)):
        for a in range(3):
            mean = 0.0
            for other in around[node]:
                mean += pulls[other, a]
            moved[node, a] = (1 - smooth_weight) * pulls[
                node, a
            ] + smooth_weight * mean / around.shape[1]


@compiled
def _carry(offset: F64, moved: F64, link: I64, share: F64) -> None:
    """Displace the points (M, 3) by the nodes that carry them."""
    for i in range(len(offset)):
        for a in range(3):
            offset[i, a] = 0.0
            for k in range(link.shape[1]):
                offset[i, a] += share[i, k] * moved[link[i, k], a]
