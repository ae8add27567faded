"""The best rigid motion, and ICP around it."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from pointbrush.tracking.compute.rigid import (
    Source,
    Target,
    best_rigid_motion,
    icp,
    robust_fits,
    transform,
)
from pointbrush.tracking.options import TrackerOptions

OPTIONS = TrackerOptions()


def motion(angle: float, shift: float) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec([0.2 * angle, angle, -0.1 * angle]).as_matrix()
    T[:3, 3] = [shift, -shift, 0.5 * shift]
    return T


def test_best_rigid_motion_is_exact_without_noise() -> None:
    source = np.random.default_rng(1).normal(size=(30, 3))
    T = motion(0.7, 0.4)
    assert np.allclose(best_rigid_motion(source, transform(T, source)), T)


def test_best_rigid_motion_never_reflects() -> None:
    source = np.random.default_rng(1).normal(size=(30, 3))
    T = best_rigid_motion(source, source * [1, 1, -1])
    assert np.linalg.det(T[:3, :3]) > 0


def test_icp_finds_a_small_motion() -> None:
    target = np.random.default_rng(2).random((2000, 3))
    T = motion(0.05, 0.01)
    source = transform(np.linalg.inv(T), target[:500])
    fit = icp(source, target, lambda p: cKDTree(target).query(p), tolerance=1e-12)
    assert fit.rmse < 1e-6
    assert np.allclose(fit.T_target_source, T, atol=1e-6)


def test_robust_fit_leaves_what_is_not_the_object_alone() -> None:
    rng = np.random.default_rng(3)
    track = rng.random((400, 3)) * [0.3, 0.1, 0.1]
    T = motion(0.1, 0.02)
    clutter = rng.random((400, 3)) + [0.5, 0.0, 0.0]
    colour = rng.random((400, 3)).astype(np.float32)
    both = np.vstack([colour, rng.random((400, 3))]).astype(np.float32)
    target = Target(np.vstack([transform(T, track), clutter]), both, 0.5)
    seen = np.ones((1, 400), bool)
    scales = [0.05, 0.05, 0.03, 0.02, 0.02]
    fits = robust_fits(
        Source(track, colour), seen, target, np.eye(4)[None], scales, options=OPTIONS.register
    )
    off = np.linalg.norm(transform(fits.T[0], track) - transform(T, track), axis=1)
    assert off.mean() < 0.01
    assert fits.cost[0] < 0.5
