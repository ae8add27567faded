"""Rigid registration: the best motion between paired points, and the ICP loop around it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.near import FEW, Plain, within

Pair = Callable[[F64], tuple[F64, I64]]
"""Moved source points (M, 3) → (M,) distances in metres and (M,) indices of their targets."""


@dataclass(frozen=True, slots=True, eq=False)
class Registration:
    """A rigid motion and how good it is.

    ``T_target_source`` (4, 4); ``rmse`` metres; ``iterations``; ``converged`` False where the
    limit of iterations ended the loop.
    """

    T_target_source: F64
    rmse: float
    iterations: int
    converged: bool


def transform(T: NDArray[np.floating], xyz: NDArray[np.floating]) -> F64:
    """Move (N, 3) points by a (4, 4) rigid motion."""
    return np.asarray(xyz @ T[:3, :3].T + T[:3, 3], np.float64)


def transform_each(T: F64, xyz: F64) -> F64:
    """(K, N, 3): the points (N, 3) moved by each of K motions (K, 4, 4)."""
    return np.asarray(xyz @ T[:, :3, :3].transpose(0, 2, 1) + T[:, None, :3, 3])


def best_rigid_motion(source: F64, target: F64, weight: F64 | None = None) -> F64:
    """The (4, 4) motion that brings ``source`` (M, 3) nearest to ``target`` in least squares.

    ``weight`` (M,) non-negative.  Identity rotation where fewer than three pairs carry weight.
    """
    w = np.full(len(source), 1.0) if weight is None else weight
    return np.asarray(best_rigid_motions(source[None], target[None], w[None])[0])


def best_rigid_motions(source: F64, target: F64, weight: F64, fewest: int = 3) -> F64:
    """K such motions (K, 4, 4) at once, of (K, M, 3) onto (K, M, 3) by (K, M) weights.

    Identity rotation where fewer than ``fewest`` pairs carry weight, identity where none does.
    Source: Arun, Huang and Blostein 1987, with Umeyama's guard against reflections.
    """
    total = weight.sum(axis=1)
    share = weight[:, None] / np.where(total > 0.0, total, 1.0)[:, None, None]
    centre_s, centre_t = share @ source, share @ target
    H = (source - centre_s).transpose(0, 2, 1) @ (weight[:, :, None] * (target - centre_t))
    U, _, Vt = np.linalg.svd(H)
    mirrored = np.linalg.det(U @ Vt) < 0.0
    Vt[mirrored, 2] *= -1.0
    R = (U @ Vt).transpose(0, 2, 1)
    R[np.count_nonzero(weight, axis=1) < fewest] = np.eye(3)
    T = np.zeros((len(weight), 4, 4))
    T[:, 3, 3] = 1.0
    T[:, :3, :3] = R
    T[:, :3, 3] = (centre_t - centre_s @ R.transpose(0, 2, 1))[:, 0]
    return T


def icp(
    source: F64, target: F64, pair: Pair, *, iterations: int = 50, tolerance: float = 1e-6
) -> Registration:
    """Besl and McKay 1992: repeat {pair each point, best motion} until the error stands still.

    ``source`` (M, 3) and ``target`` (N, 3) metres, neither empty; ``tolerance`` is the change of
    the mean square error, in square metres, under which the loop has converged.
    """
    T = np.eye(4)
    before = np.inf
    error = 0.0
    for iteration in range(1, iterations + 1):
        # 1. Pair each moved source point with a target point.
        distance, index = pair(transform(T, source))
        # 2. The rigid motion that brings the pairs together.
        T = best_rigid_motion(source, target[index])
        # 3. Stop when the mean square error no longer falls.
        error = float(np.mean(distance**2))
        if before - error < tolerance:
            return Registration(T, float(np.sqrt(error)), iteration, converged=True)
        before = error
    return Registration(T, float(np.sqrt(error)), iterations, converged=False)


@dataclass(eq=False)
class Target:
    """Points to register to, in place and colour.

    ``xyz`` (N, 3) metres; ``colour`` (N, 3) any unit; ``weight`` metres per unit of colour.
    """

    xyz: F64
    colour: F32
    weight: float

    @cached_property
    def tree(self) -> cKDTree:
        """Over place and, where it counts, weighted colour: (N, 3) or (N, 6)."""
        return cKDTree(self._placed(self.xyz, self.colour), balanced_tree=False)

    @cached_property
    def _plain(self) -> Plain:
        return Plain(self._placed(self.xyz, self.colour))

    def nearest(self, xyz: F64, colour: F32, most: float) -> tuple[F64, I64]:
        """Distances (M,), at most ``most``, and indices, of any point where nothing is nearer."""
        placed = self._placed(xyz, colour)
        if len(self.xyz) <= FEW:
            distance, index = self._plain.nearest(placed)
        else:
            found, which = self.tree.query(placed, distance_upper_bound=most)
            distance, index = np.asarray(found, np.float64), np.asarray(which, np.int64)
            index[index == len(self.xyz)] = 0
        return np.minimum(distance, most), index

    def _placed(self, xyz: F64, colour: F32) -> F64:
        if self.weight == 0.0:
            return xyz
        both = np.empty((len(xyz), 6))
        both[:, :3] = xyz
        np.multiply(colour, self.weight, out=both[:, 3:])
        return both


@dataclass(frozen=True, slots=True, eq=False)
class Fits:
    """Robust registrations: motions ``T`` (K, 4, 4); ``cost`` (K,) 0..1, the mean of each point's
    squared distance, capped."""

    T: F64
    cost: F64


def robust_fits(
    source: F64, colour: F32, seen: Mask, target: Target, T: F64, scales: Sequence[float]
) -> Fits:
    """ICP in place and colour from each of ``T`` (K, 4, 4), an iteration for each of ``scales``.

    ``source`` (M, 3) model points, those ``seen`` (K, M) moved onto the target by each motion;
    ``scales`` in metres.  Each pair weighs less the farther it is apart in units of the scale,
    which shrinks (Geman and McClure 1985).
    """
    distance, index = np.zeros(seen.shape), np.zeros(seen.shape, np.int64)
    colours = np.broadcast_to(colour, (*seen.shape, 3))[seen]
    count = np.maximum(np.count_nonzero(seen, axis=1), 1)
    cost = np.ones(len(T))
    for scale in scales:
        moved = transform_each(T, source)
        distance[seen], index[seen] = target.nearest(moved[seen], colours, 3.0 * scale)
        weight = 1.0 / (1.0 + (distance / scale) ** 2) ** 2
        weight[(distance >= 3.0 * scale) | ~seen] = 0.0
        cost = ((distance / (3.0 * scale)) ** 2).sum(axis=1) / count
        T = best_rigid_motions(moved, target.xyz[index], weight, fewest=6) @ T
    return Fits(T, cost)


def excess(moved: F64, target: Target, unit: float) -> float:
    """How much of the target lies just beside the ``moved`` source, 0..0.3.

    An object placed inside a larger surface fits it well, but the surface goes on around it.
    """
    lo, hi = moved.min(axis=0) - 6 * unit, moved.max(axis=0) + 6 * unit
    around = target.xyz[within(target.xyz, lo, hi)]
    gap, _ = Plain(moved).nearest(around)
    on = int(np.count_nonzero(gap < 3 * unit))
    beside = int(np.count_nonzero(gap < 6 * unit)) - on
    return 0.3 * min(1.0, float(beside) / float(max(on, 1)))
