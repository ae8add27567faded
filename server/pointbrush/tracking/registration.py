"""Rigid registration: the best motion between paired points, and the ICP loop around it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pointbrush.tracking.interface import F32, F64, I64

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


def best_rigid_motion(source: F64, target: F64, weight: F64 | None = None) -> F64:
    """The (4, 4) motion that brings ``source`` (M, 3) nearest to ``target`` in least squares.

    ``weight`` (M,) non-negative.  Identity rotation where fewer than three pairs carry weight.
    Source: Arun, Huang and Blostein 1987, with Umeyama's guard against reflections.
    """
    w = np.full(len(source), 1.0) if weight is None else weight
    total = float(w.sum())
    T = np.eye(4)
    if total <= 0.0:
        return T
    centre_s = w @ source / total
    centre_t = w @ target / total
    if np.count_nonzero(w) >= 3:
        H = (source - centre_s).T @ (w[:, None] * (target - centre_t))
        U, _, Vt = np.linalg.svd(H)
        flip = np.diag([1.0, 1.0, float(np.sign(np.linalg.det(Vt.T @ U.T))) or 1.0])
        T[:3, :3] = Vt.T @ flip @ U.T
    T[:3, 3] = centre_t - T[:3, :3] @ centre_s
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
        """Over place and weighted colour, (N, 6)."""
        both = np.hstack([self.xyz, self.colour * self.weight])
        return cKDTree(both, balanced_tree=False, compact_nodes=False)

    def nearest(self, xyz: F64, colour: F32, most: float) -> tuple[F64, I64]:
        """Distances (M,), ``most`` where nothing is nearer, and indices (0 there)."""
        both = np.hstack([xyz, colour * self.weight])
        distance, index = self.tree.query(both, distance_upper_bound=most)
        found = np.asarray(index) < len(self.xyz)
        return (
            np.where(found, distance, most).astype(np.float64),
            np.where(found, index, 0).astype(np.int64),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """A robust registration: ``cost`` 0..1, the mean of each point's squared distance, capped."""

    T: F64
    cost: float


def robust_fit(source: F64, colour: F32, target: Target, T: F64, scales: Sequence[float]) -> Fit:
    """ICP in place and colour from ``T``, one iteration per entry of ``scales`` (metres).

    ``source`` (M, 3) model points, moved by ``T`` onto the target.  Each pair weighs less the
    farther it is apart in units of the scale, which shrinks (Geman and McClure 1985).
    """
    cost = 1.0
    for scale in scales:
        moved = transform(T, source)
        distance, index = target.nearest(moved, colour, 3.0 * scale)
        weight = 1.0 / (1.0 + (distance / scale) ** 2) ** 2
        weight[distance >= 3.0 * scale] = 0.0
        cost = float(np.mean(np.minimum(distance / (3.0 * scale), 1.0) ** 2))
        if np.count_nonzero(weight) >= 6:
            T = best_rigid_motion(moved, target.xyz[index], weight) @ T
        elif weight.any():
            shift = weight @ (target.xyz[index] - moved) / weight.sum()
            T = T.copy()
            T[:3, 3] += shift
    return Fit(T, cost)


def excess(moved: F64, target: Target, unit: float) -> float:
    """How much of the target lies just beside the ``moved`` source, 0..0.3.

    An object placed inside a larger surface fits it well, but the surface goes on around it.
    """
    tree = cKDTree(moved, balanced_tree=False, compact_nodes=False)
    gap, _ = tree.query(target.xyz, distance_upper_bound=6 * unit)
    on = int(np.count_nonzero(np.asarray(gap) < 3 * unit))
    beside = int(np.count_nonzero(np.isfinite(np.asarray(gap)))) - on
    return 0.3 * min(1.0, float(beside) / float(max(on, 1)))
