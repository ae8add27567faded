"""Pieces: small smooth patches (Felzenszwalb and Huttenlocher, IJCV 2004), and bridges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.selection.objects.graph import Graph
from pointbrush.selection.objects.options import (
    BridgeOptions,
    GroundOptions,
    PieceOptions,
    SensorKind,
)
from pointbrush.selection.objects.union import find

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def make_pieces(
    graph: Graph, height: Floats, sensor: SensorKind, options: PieceOptions, ground: GroundOptions
) -> Ints:
    """Return the piece (C,) of each cell, numbered from 0 in the order of their first cells."""
    turn, bend, colour, _ = graph.across.T
    weight = np.where(bend < 0, turn * turn, turn) + options.colour * colour
    scale, fewest = options.scale, options.fewest
    if sensor == "lidar":
        scale, fewest = options.lidar_scale, options.lidar_fewest
        low = height < ground.clearance
        weight = weight + options.ground_step * (low[graph.edges[:, 0]] != low[graph.edges[:, 1]])
    order = np.argsort(weight, kind="stable")
    return _grown(graph.edges, weight, order, len(height), scale, fewest)


@compiled
def _grown(edges: Ints, weight: Floats, order: Ints, count: int, scale: float, fewest: int) -> Ints:
    parent, size = np.arange(count), np.ones(count, np.int64)
    most = np.full(count, scale)
    for e in order:
        a, b = find(parent, edges[e, 0]), find(parent, edges[e, 1])
        if a != b and weight[e] <= min(most[a], most[b]):
            parent[b] = a
            size[a] += size[b]
            most[a] = weight[e] + scale / size[a]
    for e in order:
        a, b = find(parent, edges[e, 0]), find(parent, edges[e, 1])
        if a != b and min(size[a], size[b]) < fewest:
            parent[b] = a
            size[a] += size[b]
    return _numbered(parent)


@compiled
def _numbered(parent: Ints) -> Ints:
    """Number (n,) of each thing's root, from 0, in the order in which they come."""
    number, result = np.full(len(parent), -1, np.int64), np.empty(len(parent), np.int64)
    found = 0
    for i in range(len(parent)):
        root = find(parent, i)
        if number[root] < 0:
            number[root] = found
            found += 1
        result[i] = number[root]
    return result


def bridges(graph: Graph, sensor: SensorKind, options: BridgeOptions) -> Ints:
    """Return edges (B, 2) of cells between components that the graph leaves apart."""
    none = np.empty((0, 2), np.int64)
    if sensor == "room" or len(graph.near) < 2:
        return none
    component = _components(graph.edges, len(graph.near))
    sizes = np.bincount(component)
    if len(sizes) < 2:
        return none
    reach = options.lidar_reach if sensor == "lidar" else options.reach
    cell, slot = np.nonzero((component[graph.near] != component[:, None]) & (graph.away <= reach))
    detached = component[cell] != int(sizes.argmax())
    cell, slot = cell[detached], slot[detached]
    order = np.lexsort((cell, graph.away[cell, slot], component[cell]))
    cell, slot = cell[order], slot[order]
    own = component[cell]
    first = np.searchsorted(own, own)
    kept = np.arange(len(own)) - first < options.links
    pairs = np.stack([cell[kept], graph.near[cell[kept], slot[kept]]], axis=1)
    return np.unique(np.sort(pairs, axis=1), axis=0) if len(pairs) else none


@compiled
def _components(edges: Ints, count: int) -> Ints:
    parent = np.arange(count)
    for e in range(len(edges)):
        a, b = find(parent, edges[e, 0]), find(parent, edges[e, 1])
        if a != b:
            parent[max(a, b)] = min(a, b)
    return _numbered(parent)
