"""Rigid registration: least-squares motion between pairs of points, and ICP."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost
from pointbrush.tracking.compute.columns import (
    NONE,
    Columns,
    Triple,
    any_near,
    columns,
    nearest,
    nearest_one,
    spans,
    toned,
)
from pointbrush.tracking.compute.grid import bounds
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.options.steps import RegistrationOptions

Pair = Callable[[F64], tuple[F64, I64]]
"""Function of moved source points (M, 3): distances (M,) in metres and target indices (M,)."""


@dataclass(frozen=True, slots=True, eq=False)
class IcpResult:
    """A rigid motion and its quality.

    ``T_target_source`` (4, 4); ``rmse`` metres.
    """

    T_target_source: F64
    rmse: float


def transform(T: NDArray[np.floating], xyz: NDArray[np.floating]) -> F64:
    """Move (N, 3) points by a (4, 4) rigid motion."""
    return np.asarray(xyz @ T[:3, :3].T + T[:3, 3], np.float64)


def inverse(T: F64) -> F64:
    """Return the inverse of a rigid motion (4, 4)."""
    back = np.eye(4)
    back[:3, :3] = T[:3, :3].T
    back[:3, 3] = -(T[:3, 3] @ T[:3, :3])
    return back


def transform_each(T: F64, xyz: F64) -> F64:
    """Return (K, N, 3) the points (N, 3) moved by each of K motions (K, 4, 4)."""
    return np.asarray(xyz @ T[:, :3, :3].transpose(0, 2, 1) + T[:, None, :3, 3])


def best_rigid_motion(source: F64, target: F64) -> F64:
    """Return the motion (4, 4) from ``source`` (M, 3) to ``target`` by least squares.

    It is a translation for fewer than three pairs, and the identity without pairs.
    Source: Arun, Huang and Blostein 1987, with Umeyama's guard against reflections.
    """
    return _motion(source, target, np.ones(len(source)), 3)


@dataclass(frozen=True, slots=True, eq=False)
class IcpStep:
    """An iteration of ICP.

    ``moved`` (M, 3): source points at its start; ``matched`` (M, 3): paired target points;
    ``distance`` (M,): metres between them.
    """

    iteration: int
    moved: F64
    matched: F64
    distance: F64

    @property
    def rmse(self) -> float:
        """Return the root mean square distance in metres."""
        return float(np.sqrt(np.mean(self.distance**2)))


def icp(
    source: F64,
    target: F64,
    pair: Pair,
    *,
    iterations: int = 50,
    tolerance: float = 1e-6,
    watch: Callable[[IcpStep], None] | None = None,
) -> IcpResult:
    """Return the motion of ``source`` (M, 3) to ``target`` (N, 3) by ICP (Besl and McKay 1992).

    Both are in metres and not empty.  Each iteration pairs the points and computes the best motion.
    ``tolerance``: change of the mean square error, in square metres, below which the loop has
    converged; ``watch`` gets each iteration.
    """
    T = np.eye(4)
    before = np.inf
    error = 0.0
    for iteration in range(1, iterations + 1):
        # 1. Pair each moved source point with a target point.
        moved = transform(T, source)
        distance, index = pair(moved)
        if watch is not None:
            watch(IcpStep(iteration, moved, target[index], distance))
        # 2. The rigid motion that brings the pairs together.
        T = best_rigid_motion(source, target[index])
        # 3. Stop when the mean square error no longer falls.
        error = float(np.mean(distance**2))
        if before - error < tolerance:
            break
        before = error
    return IcpResult(T, float(np.sqrt(error)))


@dataclass(eq=False)
class Target:
    """Target points of a registration, by position and optionally weighted colour.

    ``xyz`` (N, 3) metres; ``colour`` (N, 3) any unit; ``weight`` metres per unit of colour.
    """

    xyz: F64
    colour: F32
    weight: float

    @cached_property
    def columns(self) -> Columns:
        """The points, sorted for the search."""
        return columns(self.xyz, self.colour, self.weight)

    def nearest(self, xyz: F64, colour: F32, most: float) -> tuple[F64, I64]:
        """Return distances (M,), at most ``most``, and indices; -1: no nearer point."""
        return nearest(self.columns, xyz, colour, most)


class Source(NamedTuple):
    """Points to register: ``xyz`` (M, 3) metres; ``colour`` (M, 3) in the unit of the target's."""

    xyz: F64
    colour: F32


@dataclass(frozen=True, slots=True, eq=False)
class Fits:
    """Robust registrations.

    ``T`` (K, 4, 4): motions; ``cost`` (K,): mean of capped squared distances, 0 to 1.
    """

    T: F64
    cost: F64


def robust_fits(
    source: Source,
    seen: Mask,
    target: Target,
    T: F64,
    scales: Sequence[float],
    options: RegistrationOptions,
) -> Fits:
    """Return ICP fits by position and colour from each of ``T`` (K, 4, 4).

    There is one iteration for each of ``scales``, in metres.  Only points of the ``source`` marked
    in ``seen`` (K, M) are registered.  The weight of a pair decreases with its distance in units of
    the scale (Geman and McClure 1985).
    """
    return Fits(
        *_robust_fits(
            source,
            seen,
            target.columns,
            T,
            np.array(scales, np.float64),
            options.min_pairs,
            options.pair_scales,
        )
    )


@innermost
def carried(T: F64, x: float, y: float, z: float) -> Triple:
    """Return the point (x, y, z) moved by a motion (4, 4)."""
    return (
        T[0, 0] * x + T[0, 1] * y + T[0, 2] * z + T[0, 3],
        T[1, 0] * x + T[1, 1] * y + T[1, 2] * z + T[1, 3],
        T[2, 0] * x + T[2, 1] * y + T[2, 2] * z + T[2, 3],
    )


@compiled
def _robust_fits(
    source: Source,
    seen: Mask,
    grid: Columns,
    start: F64,
    scales: F64,
    min_pairs: int,
    pair_scales: float,
) -> tuple[F64, F64]:
    motions, costs = start.copy(), np.ones(len(start))
    xyz, colour = source
    count, room = len(xyz), spans(grid)
    moved, near, share = np.empty((count, 3)), np.empty((count, 3)), np.empty(count)
    last = np.empty(count, np.int64)
    for k in range(len(start)):
        T = motions[k]
        last[:] = -1
        for scale in scales:
            pairs, total, which = 0, 0.0, 0
            for i in range(count):
                if not seen[k, i]:
                    continue
                point = carried(T, xyz[i, 0], xyz[i, 1], xyz[i, 2])
                moved[pairs] = point
                tint = toned(grid, colour, i)
                # The last nearest point bounds the search.
                square, at = nearest_one(grid, point, tint, pair_scales * scale, room, last[i])
                last[i] = at
                which += 1
                if at < 0:
                    total += pair_scales * pair_scales
                    continue
                square /= scale * scale
                total += square
                share[pairs] = 1.0 / (1.0 + square) ** 2
                near[pairs] = grid.xyz[at]
                pairs += 1
            costs[k] = total / (pair_scales * pair_scales * max(which, 1))
            T = _motion(moved[:pairs], near[:pairs], share[:pairs], min_pairs) @ T
        motions[k] = T
    return motions, costs


@compiled
def _motion(source: F64, target: F64, weight: F64, fewest: int) -> F64:
    """See ``best_rigid_motion``; pairs have a ``weight`` (M,).

    It is a translation if fewer than ``fewest`` pairs have a weight other than 0.
    """
    count = len(source)
    total, used = 0.0, 0
    middle_s, middle_t = np.zeros(3), np.zeros(3)
    for i in range(count):
        total += weight[i]
        used += weight[i] != 0.0
        for a in range(3):
            middle_s[a] += weight[i] * source[i, a]
            middle_t[a] += weight[i] * target[i, a]
    if total > 0.0:
        middle_s /= total
        middle_t /= total
    R = np.eye(3)
    if used >= fewest:
        H = np.zeros((3, 3))
        for i in range(count):
            for a in range(3):
                offset = weight[i] * (source[i, a] - middle_s[a])
                for c in range(3):
                    H[a, c] += offset * (target[i, c] - middle_t[c])
        U, _, Vt = np.linalg.svd(H)
        R = np.ascontiguousarray((U @ Vt).T)
        if np.linalg.det(R) < 0.0:
            Vt[2] *= -1.0
            R = np.ascontiguousarray((U @ Vt).T)
    T = np.eye(4)
    T[:3, :3] = R
    T[:3, 3] = middle_t - R @ middle_s
    return T


def excess(moved: F64, target: Target, unit: float, options: RegistrationOptions) -> F64:
    """Return the cost (K,), 0 to ``excess_cost``, of target points beside the ``moved`` source.

    An object placed inside a larger surface fits it well, but the surface continues around it.
    ``moved`` (K, M, 3): moved source points.
    """
    beside = _beside_ratio(moved, target.xyz, options.beside_units * unit, options.on_units * unit)
    return np.asarray(options.excess_cost * np.minimum(1.0, beside))


@compiled
def _beside_ratio(moved: F64, xyz: F64, near: float, on: float) -> F64:
    """Return the ratio (K,) of points (N, 3) beside each surface (K, M, 3) to points on it.

    Points on it are closer than ``on`` metres, points beside it closer than ``near`` metres.
    """
    share, none = np.empty(len(moved)), (0.0, 0.0, 0.0)
    for k in range(len(moved)):
        surface, inside, beside = columns(moved[k], NONE, 0.0), 0, 0
        lo, hi = bounds(surface.xyz)
        for i in range(len(xyz)):
            x, y, z = xyz[i, 0], xyz[i, 1], xyz[i, 2]
            gap = max(lo[0] - x, x - hi[0], lo[1] - y, y - hi[1], lo[2] - z, z - hi[2])
            if gap >= near:
                continue
            if any_near(surface, (x, y, z), none, on):
                inside += 1
            elif any_near(surface, (x, y, z), none, near):
                beside += 1
        share[k] = beside / max(inside, 1)
    return share
