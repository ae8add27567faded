"""Graph of neighbouring cells in a frame, and its segmentation into pieces.

Cells have normals, and edges have dissimilarities.  Pieces are small smooth patches (Felzenszwalb
and Huttenlocher, IJCV 2004), connected by bridges.  Eigenvalues of symmetric 3 x 3 matrices are in
closed form (Smith, CACM 4, 1961).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pointbrush.compiled import compiled, innermost
from pointbrush.selection.objects.options import (
    BridgeOptions,
    GraphOptions,
    GroundOptions,
    PieceOptions,
)
from pointbrush.sensor_kind import SensorKind

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
SIXTH = 6
"""Index of the neighbour used for the spacing."""


@innermost
def eigenvalues(
    xx: float, xy: float, xz: float, yy: float, yz: float, zz: float
) -> tuple[float, float, float]:
    """Return the eigenvalues in ascending order."""
    q = (xx + yy + zz) / 3
    off = xy * xy + xz * xz + yz * yz
    spread = (xx - q) ** 2 + (yy - q) ** 2 + (zz - q) ** 2 + 2 * off
    if spread <= 1e-300:
        return q, q, q
    p = np.sqrt(spread / 6)
    a, b, c = (xx - q) / p, (yy - q) / p, (zz - q) / p
    d, e, f = xy / p, xz / p, yz / p
    half = (a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)) / 2
    angle = np.arccos(min(1.0, max(-1.0, half))) / 3
    high = q + 2 * p * np.cos(angle)
    low = q + 2 * p * np.cos(angle + 2 * np.pi / 3)
    return low, 3 * q - high - low, high


@innermost
def eigenvector(
    xx: float, xy: float, xz: float, yy: float, yz: float, zz: float, value: float
) -> tuple[float, float, float]:
    """Return the unit eigenvector of ``value``: the longest cross product of two rows."""
    a, b, c = xx - value, yy - value, zz - value
    x0, y0, z0 = xy * yz - xz * b, xz * xy - a * yz, a * b - xy * xy
    x1, y1, z1 = xy * c - xz * yz, xz * xz - a * c, a * yz - xy * xz
    x2, y2, z2 = b * c - yz * yz, yz * xz - xy * c, xy * yz - b * xz
    n0 = x0 * x0 + y0 * y0 + z0 * z0
    n1 = x1 * x1 + y1 * y1 + z1 * z1
    n2 = x2 * x2 + y2 * y2 + z2 * z2
    if n1 > n0:
        x0, y0, z0, n0 = x1, y1, z1, n1
    if n2 > n0:
        x0, y0, z0, n0 = x2, y2, z2, n2
    if n0 <= 1e-300:
        return 0.0, 0.0, 1.0
    n0 = np.sqrt(n0)
    return x0 / n0, y0 / n0, z0 / n0


@innermost
def find(parent: NDArray[np.int64], i: int) -> int:
    """Return the root of ``i`` and compress the path to it."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@dataclass(frozen=True, slots=True, eq=False)
class Graph:
    """Graph of cells.

    ``normal`` (C, 3): unit normals; ``rough`` (C,): roughness, 0 (flat) to 1/3; ``near`` (C, K):
    neighbours, nearest first; ``distance`` (C, K): to them; ``edges`` (E, 2): cells with i < j;
    ``across`` (E, 4): turn 1 - ni.nj, bend (concave above 0), Lab distance, length in metres.
    """

    normal: Floats
    rough: Floats
    near: Ints
    distance: Floats
    edges: Ints
    across: Floats


def make_graph(
    center: Floats,
    lab: Floats,
    viewpoint: Floats | None,
    size: float,
    sensor: SensorKind,
    options: GraphOptions,
) -> Graph:
    """Return the graph of cells (C, 3); ``viewpoint`` (3,) in the same coordinates."""
    count = len(center)
    k = min(options.neighbours + 1, count)
    tree = cKDTree(center, leafsize=12, balanced_tree=False, compact_nodes=False)
    distance, near = tree.query(center, k=max(k, 2))
    near, distance = np.asarray(near, np.int64)[:, 1:k], np.asarray(distance, np.float64)[:, 1:k]
    normal, rough = _normals(center, near)
    reach = _reaches(center, distance, viewpoint, size, sensor, options)
    linked = near.shape[1] if sensor == "lidar" else min(options.linked, near.shape[1])
    edges = _edges(near, distance, reach, linked)
    if viewpoint is not None:
        flip = np.einsum("ij,ij->i", normal, viewpoint - center) < 0
        normal[flip] *= -1
    else:
        _orient(normal, center, edges, _steepness(normal, edges))
    return Graph(normal, rough, near, distance, edges, across_edges(center, normal, lab, edges))


def _reaches(
    center: Floats,
    distance: Floats,
    viewpoint: Floats | None,
    size: float,
    sensor: SensorKind,
    options: GraphOptions,
) -> Floats:
    """Return the maximum length (C,) of each cell's edges, in metres."""
    if sensor == "lidar":
        origin = np.zeros(3) if viewpoint is None else viewpoint
        eye_distance = np.linalg.norm(center - origin, axis=1)
        return np.asarray(options.lidar_reach + options.lidar_reach_per_metre * eye_distance)
    if distance.shape[1] == 0:
        return np.zeros(len(center))
    spacing = distance[:, min(SIXTH, distance.shape[1]) - 1]
    return np.minimum(options.reach_spacings * spacing, options.reach_cells * size)


@compiled
def _normals(center: Floats, near: Ints) -> tuple[Floats, Floats]:
    """Return normals (C, 3), of arbitrary sign, and roughness (C,) by each cell's neighbours."""
    count, k = near.shape
    normal, rough = np.empty((count, 3)), np.empty(count)
    for i in range(count):
        sx = sy = sz = xx = xy = xz = yy = yz = zz = 0.0
        for s in range(k):
            j = near[i, s]
            x, y, z = (
                center[j, 0] - center[i, 0],
                center[j, 1] - center[i, 1],
                center[j, 2] - center[i, 2],
            )
            sx += x
            sy += y
            sz += z
            xx += x * x
            xy += x * y
            xz += x * z
            yy += y * y
            yz += y * z
            zz += z * z
        n = k + 1.0
        xx, xy, xz = xx / n - sx * sx / n / n, xy / n - sx * sy / n / n, xz / n - sx * sz / n / n
        yy, yz, zz = yy / n - sy * sy / n / n, yz / n - sy * sz / n / n, zz / n - sz * sz / n / n
        low, middle, high = eigenvalues(xx, xy, xz, yy, yz, zz)
        total = low + middle + high
        normal[i, 0], normal[i, 1], normal[i, 2] = eigenvector(xx, xy, xz, yy, yz, zz, low)
        rough[i] = max(low, 0.0) / total if total > 1e-18 else 0.0
    return normal, rough


@compiled
def _edges(near: Ints, distance: Floats, reach: Floats, linked: int) -> Ints:
    """Return distinct pairs (E, 2), i < j, of cells with one in reach of the other."""
    count = len(near)
    pairs = np.empty((count * linked, 2), np.int64)
    made = 0
    for i in range(count):
        for s in range(linked):
            j = near[i, s]
            if distance[i, s] > reach[i]:
                break
            twice = False
            if j < i:
                for r in range(linked):
                    if distance[j, r] > reach[j]:
                        break
                    if near[j, r] == i:
                        twice = True
                        break
            if not twice:
                pairs[made, 0], pairs[made, 1] = min(i, j), max(i, j)
                made += 1
    return pairs[:made].copy()


def _steepness(normal: Floats, edges: Ints) -> Ints:
    """Return an order (E,) of the edges by ascending angle of the normals, ignoring signs."""
    turn = 1.0 - np.abs(np.einsum("ij,ij->i", normal[edges[:, 0]], normal[edges[:, 1]]))
    return np.argsort(turn, kind="stable")


@compiled
def _orient(normal: Floats, center: Floats, edges: Ints, order: Ints) -> None:
    """Orient the normals consistently along a spanning tree, then to the scene's middle."""
    count = len(normal)
    parent, size = np.arange(count), np.ones(count, np.int64)
    # Members of a component form a ring, so that the smaller one can be flipped as a whole.
    following = np.arange(count)
    for e in order:
        i, j = edges[e, 0], edges[e, 1]
        a, b = find(parent, i), find(parent, j)
        if a == b:
            continue
        if size[a] < size[b]:
            a, b = b, a
        dot = 0.0
        for k in range(3):
            dot += normal[i, k] * normal[j, k]
        if dot < 0:
            _flip_ring(normal, following, b)
        parent[b] = a
        size[a] += size[b]
        following[a], following[b] = following[b], following[a]
    _turn_inward(normal, center, parent)


@innermost
def _flip_ring(normal: Floats, following: Ints, first: int) -> None:
    """Flip the normals (C, 3) of the ring of cells that contains ``first``."""
    member = first
    while True:
        for k in range(3):
            normal[member, k] = -normal[member, k]
        member = following[member]
        if member == first:
            break


@compiled
def _turn_inward(normal: Floats, center: Floats, parent: Ints) -> None:
    """Flip the normals (C, 3) of each component that points away from the scene's middle."""
    count = len(normal)
    middle = np.zeros(3)
    for i in range(count):
        for k in range(3):
            middle[k] += center[i, k] / count
    toward = np.zeros(count)
    for i in range(count):
        root = find(parent, i)
        for k in range(3):
            toward[root] += normal[i, k] * (middle[k] - center[i, k])
    for i in range(count):
        if toward[find(parent, i)] < 0:
            for k in range(3):
                normal[i, k] = -normal[i, k]


@compiled
def across_edges(center: Floats, normal: Floats, lab: Floats, edges: Ints) -> Floats:
    """Return turn, bend, colour distance and length (E, 4) of each edge."""
    across = np.empty((len(edges), 4))
    for e in range(len(edges)):
        i, j = edges[e, 0], edges[e, 1]
        dot = bend = colour = length = 0.0
        for k in range(3):
            way = center[j, k] - center[i, k]
            dot += normal[i, k] * normal[j, k]
            bend += (normal[i, k] - normal[j, k]) * way
            colour += (lab[i, k] - lab[j, k]) ** 2
            length += way * way
        length = np.sqrt(length)
        across[e, 0] = 1.0 - dot
        across[e, 1] = bend / max(length, 1e-12)
        across[e, 2] = np.sqrt(colour)
        across[e, 3] = length
    return across


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
    """Return the number (n,) of each element's root, from 0 in order of first occurrence."""
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
    """Return edges (B, 2) of cells between disconnected components of the graph."""
    none = np.empty((0, 2), np.int64)
    if sensor == "room" or len(graph.near) < 2:
        return none
    component = _components(graph.edges, len(graph.near))
    sizes = np.bincount(component)
    if len(sizes) < 2:
        return none
    reach = options.lidar_reach if sensor == "lidar" else options.reach
    cell, slot = np.nonzero(
        (component[graph.near] != component[:, None]) & (graph.distance <= reach)
    )
    detached = component[cell] != int(sizes.argmax())
    cell, slot = cell[detached], slot[detached]
    order = np.lexsort((cell, graph.distance[cell, slot], component[cell]))
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
