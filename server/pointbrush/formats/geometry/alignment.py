"""Comparison of consecutive frames with and without their given poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pointbrush.frame import PointFrame

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class AlignmentOptions:
    """Parameters of the comparison of two frames."""

    most_points: int = 20_000
    """Points of a frame that make its surface; more are thinned."""
    probes: int = 4_000
    """Points of the next frame that are compared with this surface."""
    neighbours: int = 10
    """Points from which a normal is computed."""
    flat: float = 0.04
    """Greatest share of the least eigenvalue of a neighbourhood that counts as a surface."""
    broad: float = 0.1
    """Least share of the middle eigenvalue: scan lines alone are no surface."""
    far: float = 1.0
    """Metres at which distances are cut off."""
    least_motion: float = 0.05
    """Least motion of the points by the poses, metres, for a comparison."""
    worse: float = 1.25
    """Ratio of the distances with and without poses above which poses count as worse."""


def agree_better_without(frames: Sequence[PointFrame]) -> bool | None:
    """Return whether frames agree better without their poses than with them, one to the next.

    The measure is the mean distance, cut off, from points to the tangent planes of the previous
    frame.  None if the poses hardly move the points, or if there are too few points.
    """
    options = AlignmentOptions()
    with_poses, without = [], []
    for before, after in pairwise(frames):
        if before.pose is None or after.pose is None or min(len(before), len(after)) < 100:
            continue
        motion = np.linalg.inv(before.pose) @ after.pose
        probes = _thinned(after.xyz, options.probes)
        moved = probes @ motion[:3, :3].T + motion[:3, 3]
        if float(np.median(np.linalg.norm(moved - probes, axis=1))) < options.least_motion:
            continue
        surface = _Surface(_thinned(before.xyz, options.most_points), options)
        both = np.stack([surface.distances(moved), surface.distances(probes)])
        known = np.isfinite(both).all(axis=0)
        if known.sum() >= 100:
            with_poses.append(float(both[0, known].mean()))
            without.append(float(both[1, known].mean()))
    if not with_poses:
        return None
    return float(np.mean(with_poses)) > options.worse * float(np.mean(without))


def _thinned(xyz: NDArray[np.floating], most: int) -> Points:
    step = -(-len(xyz) // most)
    return np.asarray(xyz[::step], np.float64)


class _Surface:
    """Points, with tangent planes of points on a surface."""

    def __init__(self, xyz: Points, options: AlignmentOptions) -> None:
        from scipy.spatial import cKDTree

        self._options = options
        self._xyz = xyz
        self._tree = cKDTree(xyz)
        _, near = self._tree.query(xyz, k=min(options.neighbours, len(xyz)))
        local = xyz[near] - xyz[near].mean(axis=1, keepdims=True)
        values, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", local, local))
        share = values / np.maximum(values.sum(axis=1, keepdims=True), 1e-30)
        self._flat = (share[:, 0] < options.flat) & (share[:, 1] > options.broad)
        self._normals = vectors[:, :, 0]

    def distances(self, probes: Points) -> Points:
        """Return the distance (n,) of each probe to its nearest point's plane, NaN without one."""
        far = self._options.far
        distances, nearest = self._tree.query(probes, distance_upper_bound=far)
        found = np.isfinite(distances)
        nearest = np.where(found, nearest, 0)
        offsets = probes - self._xyz[nearest]
        planar = np.abs(np.einsum("ij,ij->i", offsets, self._normals[nearest]))
        return np.where(found, np.where(self._flat[nearest], planar, np.nan), far)
