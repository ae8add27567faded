"""Overlap of boxes that are turned in any way: volume of the intersection, and 3D IoU."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))
_EDGES = np.array([(a, b) for a in range(8) for b in range(a + 1, 8) if (a ^ b).bit_count() == 1])
"""Pairs of corners (12, 2), by numbers that differ in one axis."""
SLACK = 1e-9
"""Metres by which the clipping box is enlarged: common faces stay common after rounding."""
PARALLEL = 1e-12
"""Metres along an axis below which an edge does not cross the faces across it."""


def iou_3d(size_a: Floats, T_a: Floats, size_b: Floats, T_b: Floats) -> float:
    """Compute the intersection over union of two boxes.

    ``size`` (3,) metres along the box's axes; ``T`` (4, 4) from the box's axes to coordinates that
    both have.
    """
    shared = shared_volume(size_a, T_a, size_b, T_b)
    return shared / (float(np.prod(size_a)) + float(np.prod(size_b)) - shared)


def iou_matrix(sizes_a: Floats, Ts_a: Floats, sizes_b: Floats, Ts_b: Floats) -> Floats:
    """Compute the IoU (N, M) of boxes: sizes (N, 3), (M, 3), transforms (N, 4, 4), (M, 4, 4)."""
    distance = np.linalg.norm(Ts_a[:, None, :3, 3] - Ts_b[None, :, :3, 3], axis=2)
    reach = np.linalg.norm(sizes_a, axis=1)[:, None] + np.linalg.norm(sizes_b, axis=1)[None]
    found = np.zeros(distance.shape)
    for a, b in np.argwhere(distance < reach / 2).tolist():
        found[a, b] = iou_3d(sizes_a[a], Ts_a[a], sizes_b[b], Ts_b[b])
    return found


def shared_volume(size_a: Floats, T_a: Floats, size_b: Floats, T_b: Floats) -> float:
    """Compute the volume that two boxes share, cubic metres; arguments as of ``iou_3d``.

    The corners of the shared volume are the ends of each box's edges, clipped by the other box.
    """
    from scipy.spatial import ConvexHull, QhullError

    A, B = T_a.copy(), T_b.copy()
    A[:3, 3], B[:3, 3] = 0, T_b[:3, 3] - T_a[:3, 3]  # precise far from the origin
    ends = np.concatenate([_clipped(size_a, A, size_b, B), _clipped(size_b, B, size_a, A)])
    if len(ends) < 4:
        return 0.0
    try:
        return float(ConvexHull(ends).volume)
    except QhullError:  # they touch in a face, an edge or a corner
        return 0.0


def _clipped(size: Floats, T: Floats, other_size: Floats, T_other: Floats) -> Floats:
    """Clip the edges of a box by another: their ends (n, 3) in the common coordinates."""
    corners = (_CORNERS * size) @ T[:3, :3].T + T[:3, 3]
    local = (corners - T_other[:3, 3]) @ T_other[:3, :3]
    start, along = local[_EDGES[:, 0]], local[_EDGES[:, 1]] - local[_EDGES[:, 0]]
    half = other_size / 2 + SLACK
    crosses = np.abs(along) > PARALLEL
    step = np.where(crosses, along, 1.0)
    first, last = (-half - start) / step, (half - start) / step
    within = np.abs(start) <= half
    enter = np.where(crosses, np.minimum(first, last), np.where(within, 0.0, np.inf))
    leave = np.where(crosses, np.maximum(first, last), np.where(within, 1.0, -np.inf))
    begin, end = np.maximum(enter.max(axis=1), 0.0), np.minimum(leave.min(axis=1), 1.0)
    kept = begin <= end
    ends = start[kept][:, None] + along[kept][:, None] * np.stack([begin, end], 1)[kept][..., None]
    return np.asarray(ends.reshape(-1, 3) @ T_other[:3, :3].T + T_other[:3, 3])
