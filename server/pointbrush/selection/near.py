"""Points near others: the same object in a frame that is laid over the one it was found in."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.points import NOTHING, Points

REACH = 2.0
"""Distances between neighbours within which a point counts as one of the same surface."""
LEAST_REACH = 0.005
"""Metres, about a depth camera's noise."""


def reach_of(xyz: NDArray[np.float64], spacings: float = REACH) -> float:
    """Return metres within which a point counts as one of the surface of points (N, 3).

    As many ``spacings``, the median distance between neighbours; at least ``LEAST_REACH``.
    """
    from scipy.spatial import cKDTree

    if len(xyz) < 2:
        return LEAST_REACH
    apart = np.asarray(cKDTree(xyz).query(xyz, k=2)[0])[:, 1]
    return max(LEAST_REACH, spacings * float(np.median(apart)))


def near(points: Points, xyz: NDArray[np.float64], reach: float) -> NDArray[np.int64]:
    """Numbers of the points within ``reach`` of one of ``xyz`` (N, 3), local metres; sorted."""
    from scipy.spatial import cKDTree

    if len(xyz) == 0:
        return NOTHING
    tree = cKDTree(xyz)
    found = [NOTHING]
    blocks = points.blocks_in_box(xyz.min(axis=0) - reach, xyz.max(axis=0) + reach)
    for group in points.groups(blocks):
        numbers = points.numbers(group)
        apart, _ = tree.query(points.xyz[numbers], distance_upper_bound=reach)
        found.append(numbers[np.isfinite(apart)])
    return np.concatenate(found)
