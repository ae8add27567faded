"""Rigid registration: the best motion between paired points, and the ICP loop around it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pointbrush.tracking.interface import F64, I64

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


def transform(T: F64, xyz: F64) -> F64:
    """Move (N, 3) points by a (4, 4) rigid motion."""
    return np.asarray(xyz @ T[:3, :3].T + T[:3, 3])


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
