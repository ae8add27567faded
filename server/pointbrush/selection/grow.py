"""Fill: connected region of similar colour and normal around a point (region growing).

After Rabbani, van den Heuvel and Vosselman, "Segmentation of point clouds using smoothness
constraint" (ISPRS 2006), with a colour criterion; grown in waves so that it is vectorised.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.points import Alive, Points
from pointbrush.selection.ray import region_shape
from pointbrush.selection.sphere import swept_ball

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

NEIGHBOURS = 16
MAX_TURN = np.cos(np.radians(35.0))
"""Cosine of the maximum angle between the normals of neighbours on one surface."""
SURFACE = 0.15
"""Share of variance across the surface above which a normal is too uncertain to count."""
LIKE_NEIGHBOUR = 32.0
LIKE_SEED = 80.0
"""Maximum colour distances (RGB, 0..255 each) to the neighbour and to the seed."""
REACH, LEAST_REACH, MOST = 5.0, 0.05, 4_000_000
"""Metres of the search around the seed in frames without a tree, and maximum points."""


def grow(
    points: Points, seed: NDArray[np.float64], radius: float, alive: Alive | None = None
) -> Iterator[NDArray[np.int64]]:
    """Yield numbers of the region of the point nearest to ``seed`` (3,), in waves, each sorted.

    Neighbours belong together if they are closer than ``radius`` and than a few times the local
    spacing, and similar in colour (if available) and in normal.  Points that are not ``alive`` are
    not part of the region and do not connect it.
    """
    members = None
    if points.kdtree is not None:
        xyz, tree = points.xyz[:], points.kdtree()
    else:
        members = swept_ball(points, seed[None], _reach(points, seed))
        if len(members) == 0:
            return
        xyz = points.xyz[members]
        from scipy.spatial import cKDTree

        tree = cKDTree(xyz)
    rgb = points.rgb if members is None or points.rgb is None else points.rgb[members]
    barred = np.zeros(len(xyz), np.bool_)
    if alive is not None:
        barred = ~alive(np.arange(len(xyz)) if members is None else members)
    start = _nearest(tree, seed, barred)
    if len(start):
        for wave in _grow_waves(xyz, rgb, tree, start, radius, barred):
            numbers = np.sort(wave)
            yield numbers if members is None else members[numbers]


def _nearest(
    tree: cKDTree, seed: NDArray[np.float64], barred: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """Return the point (1,) nearest to the seed that is not ``barred`` (N,); (0,): none."""
    most = 1
    while True:
        near = np.atleast_1d(tree.query(seed, k=min(most, len(barred)))[1]).astype(np.int64)
        free = near[~barred[near]]
        if len(free) or most >= len(barred):
            return free[:1]
        most *= 16


def _reach(points: Points, seed: NDArray[np.float64]) -> float:
    """Return the radius of the search around the seed.

    It is reduced in dense scans, so that a tree of its points fits in memory.
    """
    reach, first = REACH, points.blocks.first
    while reach > LEAST_REACH:
        near = points.blocks_in_box(seed - reach, seed + reach)
        if int((first[near + 1] - first[near]).sum()) <= MOST:
            break
        reach /= 2
    return reach


def _grow_waves(
    xyz: NDArray[np.float32],
    rgb: NDArray[np.uint8] | None,
    tree: cKDTree,
    start: NDArray[np.int64],
    radius: float,
    seen: NDArray[np.bool_],
) -> Iterator[NDArray[np.int64]]:
    """Yield the region around ``start`` (1,) without ``seen`` points (N,), and update ``seen``."""
    yield start
    seen[start] = True
    seed_rgb = None if rgb is None else rgb[start[0]].astype(np.float32)
    frontier = start
    links, normals, certain = _surroundings(xyz, tree, start, radius)
    while len(frontier):
        # 1. New neighbours of the frontier, each with the first parent that reaches it.
        parents, slots = np.nonzero((links < len(xyz)) & ~seen[np.minimum(links, len(xyz) - 1)])
        reached, first = np.unique(links[parents, slots], return_index=True)
        parents = parents[first]
        # 2. Similar colour.
        if rgb is not None and seed_rgb is not None:
            colour = rgb[reached].astype(np.float32)
            step = np.linalg.norm(colour - rgb[frontier[parents]], axis=1)
            like = (step <= LIKE_NEIGHBOUR) & (
                np.linalg.norm(colour - seed_rgb, axis=1) <= LIKE_SEED
            )
            reached, parents = reached[like], parents[like]
        if len(reached) == 0:
            break
        # 3. Similar normal.  A point with an uncertain normal (noise, an edge) takes its parent's
        #    normal, so that the region does not turn a corner through it.
        next_links, next_normals, next_certain = _surroundings(xyz, tree, reached, radius)
        turn = np.abs(np.einsum("ij,ij->i", next_normals, normals[parents]))
        keep = (turn >= MAX_TURN) | ~next_certain | ~certain[parents]
        inherits = ~next_certain & certain[parents]
        next_normals[inherits] = normals[parents[inherits]]
        next_certain |= inherits
        frontier = reached[keep]
        links, normals, certain = next_links[keep], next_normals[keep], next_certain[keep]
        seen[frontier] = True
        yield frontier


def _surroundings(
    xyz: NDArray[np.float32], tree: cKDTree, numbers: NDArray[np.int64], radius: float
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.bool_]]:
    """Return neighbours (n, k) padded with ``len(xyz)``, normals (n, 3), certainty (n,)."""
    k = min(NEIGHBOURS, len(xyz))
    distance, neighbour = tree.query(xyz[numbers], k=k, distance_upper_bound=radius)
    distance = np.asarray(distance).reshape(-1, k)
    neighbour = np.asarray(neighbour, np.int64).reshape(-1, k)
    found = np.isfinite(distance)
    around = xyz[np.minimum(neighbour, len(xyz) - 1)].astype(np.float64)
    weight = found / found.sum(axis=1, keepdims=True)
    around -= np.einsum("nk,nki->ni", weight, around)[:, None]
    spread, axes = np.linalg.eigh(np.einsum("nk,nki,nkj->nij", weight, around, around))
    certain = (spread[:, 0] < SURFACE * spread[:, 1]) & (found.sum(axis=1) >= 6)
    # Farther than three times the usual step is across a gap, not along the surface.
    usual = distance[:, min(4, k - 1)]
    usual = np.where(np.isfinite(usual), usual, radius)
    linked = found & (distance <= 3.0 * usual[:, None])
    return np.where(linked, neighbour, len(xyz)), axes[:, :, 0], certain


GROW = region_shape(
    "grow", "The connected region of similar colour and normal round each place met.", grow
)
