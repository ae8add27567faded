"""Cluster: points around a place connected by gaps up to a limit, without the ground.

Euclidean clustering after removal of the ground, as in Rusu, "Semantic 3D object maps" (2009); the
ground is a lower envelope of the heights, which follows slopes and kerbs.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.objects.options import GroundOptions
from pointbrush.selection.points import NOTHING, Alive, Points
from pointbrush.selection.ray import region_shape
from pointbrush.selection.sphere import swept_ball

NEIGHBOUR = 8
"""Index of the neighbour used for the density of points."""
USUAL_SHARE = 0.9
"""Share of the points with a usual distance to that neighbour."""
GAP_FACTOR = 1.5
"""Ratio of a gap to that distance from which it is not within a surface."""
SAMPLED = 4000
"""Number of sampled points."""
TOUCHING = 1.8
"""Maximum distance of touching cells, in cells: √3 at a corner."""
FEWEST = 3
"""Minimum number of points for a usual distance."""


def usual_gap(xyz: NDArray[np.floating]) -> float:
    """Return a gap (metres) that points (n, 3) do not have within one of their surfaces."""
    from scipy.spatial import cKDTree

    if len(xyz) < FEWEST:
        return 1.0
    step = max(1, len(xyz) // SAMPLED)
    distance, _ = cKDTree(xyz).query(xyz[::step], k=min(NEIGHBOUR, len(xyz)))
    return max(1e-3, GAP_FACTOR * float(np.quantile(np.asarray(distance)[:, -1], USUAL_SHARE)))


def connected_parts(xyz: NDArray[np.floating], gap: float) -> NDArray[np.int64]:
    """Return the part of each of points (n, 3): 0 is the largest, 1 the next, and so on.

    Two points are in one part if a chain of points without a step longer than ``gap`` metres
    connects them.  Steps up to 1.7 times as long may count, because the points are grouped in cells
    of half a gap, and touching cells are connected.
    """
    if len(xyz) == 0:
        return np.empty(0, np.int64)
    at = np.asarray(xyz, np.float64)
    part = touching(np.floor((at - at.min(axis=0)) / (gap / 2)).astype(np.int64))
    order = np.argsort(-np.bincount(part), kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return np.asarray(rank[part], np.int64)


def touching(at: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the connected component (n,) of each point's cell ``at`` (n, 3).

    Cells that touch, also at a corner, are connected.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    cells, cell = np.unique(at, axis=0, return_inverse=True)
    pairs = cKDTree(cells).query_pairs(TOUCHING, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), np.bool_), pairs.T), shape=(len(cells),) * 2)
    return np.asarray(connected_components(links, directed=False)[1][cell.reshape(-1)], np.int64)


@dataclass(frozen=True, slots=True)
class ClusterOptions:
    """Tunable numbers of the cluster tool."""

    reach: float = 15.0
    """Metres around the hit for the search of a cluster and its ground."""
    most: int = 1_500_000
    """Maximum points of the search; if there are more, the reach is halved."""
    least_clearance: float = 0.03
    """Metres above the ground up to which points are ground at any radius, for noise."""
    most_clearance: float = 0.2
    """Maximum of this height, in metres; between the two it is the radius."""


OPTIONS = ClusterOptions()
GROUND = GroundOptions()


def cluster(
    points: Points, hit: NDArray[np.float64], radius: float, alive: Alive | None = None
) -> Iterator[NDArray[np.int64]]:
    """Yield sorted numbers of the cluster of the point nearest to ``hit`` (3,), in local metres.

    Two points are in one cluster if a chain of points without a step longer than ``radius``
    connects them; steps up to 1.7 times as long may count.  The cluster is empty if only ground is
    within ``radius`` of the place.
    """
    from pointbrush.selection.objects.cells import height_over_ground  # brings Numba

    numbers = _surroundings(points, hit)
    if alive is not None:
        numbers = numbers[alive(numbers)]
    if len(numbers) == 0:
        return
    yield NOTHING
    xyz = points.xyz[numbers].astype(np.float64)
    height = height_over_ground(xyz @ _to_up(points.up).T, GROUND)
    clearance = np.clip(radius, OPTIONS.least_clearance, OPTIONS.most_clearance)
    standing = np.flatnonzero(height > clearance)
    numbers, xyz = numbers[standing], xyz[standing]
    if len(numbers) == 0:
        return
    yield NOTHING
    square = ((xyz - hit) ** 2).sum(axis=1)
    nearest = int(np.argmin(square))
    if square[nearest] > radius * radius:
        return
    part = connected_parts(xyz, radius)
    yield numbers[part == part[nearest]]


def _surroundings(points: Points, hit: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return numbers of the points around a place; the radius is reduced if there are too many."""
    reach, first = OPTIONS.reach, points.blocks.first
    while True:
        near = points.blocks_in_box(hit - reach, hit + reach)
        if int((first[near + 1] - first[near]).sum()) <= OPTIONS.most:
            return swept_ball(points, hit[None], reach)
        reach /= 2


def _to_up(up: tuple[float, float, float]) -> NDArray[np.float64]:
    """Return a rotation (3, 3) that turns ``up`` to z."""
    z = np.asarray(up, np.float64) / np.linalg.norm(up)
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z])


CLUSTER = region_shape(
    "cluster",
    "Points above the ground round each place met, without gaps wider than the radius.",
    cluster,
)
