"""Rigid registration: the best motion between paired points, and the ICP loop around it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.near import Plain, bounds, within

MOSTLY = 0.8
"""Share of a target from which it does not pay to cut it."""
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


def inverse(T: F64) -> F64:
    """The rigid motion (4, 4) back."""
    back = np.eye(4)
    back[:3, :3] = T[:3, :3].T
    back[:3, 3] = -(T[:3, 3] @ T[:3, :3])
    return back


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
    total = np.add.reduce(weight, axis=1)
    share = weight[:, None] / np.where(total > 0.0, total, 1.0)[:, None, None]
    centre_s, centre_t = share @ source, share @ target
    # What one side is away from its centre is enough for both: the other side's centre drops out.
    H = (weight[:, :, None] * (source - centre_s)).transpose(0, 2, 1) @ target
    U, _, Vt = np.linalg.svd(H)
    R = U @ Vt
    mirrored = np.linalg.det(R) < 0.0
    if mirrored.any():
        Vt[mirrored, 2] *= -1.0
        R = U @ Vt
    few = np.add.reduce(weight != 0.0, axis=1) < fewest
    if few.any():
        R[few] = np.eye(3)
    T = np.zeros((len(weight), 4, 4))
    T[:, 3, 3] = 1.0
    T[:, :3, :3] = R.transpose(0, 2, 1)
    T[:, :3, 3] = (centre_t - centre_s @ R)[:, 0]
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
    """A few points to register to, in place and, where it counts, weighted colour.

    ``xyz`` (N, 3) metres; ``colour`` (N, 3) any unit; ``weight`` metres per unit of colour.
    """

    xyz: F64
    colour: F32
    weight: float

    def around(self, xyz: F64, margin: float) -> Target:
        """What of it lies in a box around ``xyz`` (M, 3) and ``margin`` metres beside; all of it
        where that is most."""
        lo, hi = bounds(xyz)
        part = np.flatnonzero(within(self.xyz, lo - margin, hi + margin))
        if len(part) > MOSTLY * len(self.xyz) or not len(part):
            return self
        return Target(self.xyz[part], self.colour[part], self.weight)

    @cached_property
    def _plain(self) -> Plain:
        if self.weight == 0.0:
            return Plain(self.xyz)
        return Plain(np.hstack([self.xyz, self.colour * np.float32(self.weight)]))

    def nearest(self, xyz: F64, colour: F32, most: float) -> tuple[F64, I64]:
        """Distances (M,), at most ``most``, and indices, of any point where nothing is nearer."""
        if self.weight == 0.0:
            distance, index = self._plain.nearest(xyz)
        else:
            distance, index = self._plain.nearest(xyz, colour * np.float32(self.weight))
        return np.minimum(distance, most, out=distance), index


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
    pose, point = np.nonzero(seen)
    colours = colour[point]
    near, weight = np.zeros((*seen.shape, 3)), np.zeros(seen.shape)
    count = np.maximum(np.bincount(pose, minlength=len(T)), 1)
    cost = np.ones(len(T))
    for scale in scales:
        moved = transform_each(T, source)
        distance, index = target.nearest(moved[seen], colours, 3.0 * scale)
        near[seen] = target.xyz.take(index, axis=0)
        square = (distance / scale) ** 2
        weight[seen] = np.where(square < 9.0, 1.0 / (1.0 + square) ** 2, 0.0)
        cost = np.bincount(pose, weights=square, minlength=len(T)) / (9.0 * count)
        T = best_rigid_motions(moved, near, weight, fewest=6) @ T
    return Fits(T, cost)


def excess(moved: F64, target: Target, unit: float) -> float:
    """How much of the target lies just beside the ``moved`` source, 0..0.3.

    An object placed inside a larger surface fits it well, but the surface goes on around it.
    """
    lo, hi = bounds(moved)
    around = target.xyz[within(target.xyz, lo - 6 * unit, hi + 6 * unit)]
    gap, _ = Plain(moved).nearest(around)
    on = int(np.count_nonzero(gap < 3 * unit))
    beside = int(np.count_nonzero(gap < 6 * unit)) - on
    return 0.3 * min(1.0, float(beside) / float(max(on, 1)))
