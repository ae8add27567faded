"""Shapes: rays meet them where their definition says, and the normals point out."""

from __future__ import annotations

import numpy as np
import pytest

from pointbrush.samples.shapes import Ball, Box, Cylinder, Lathe, RoundCone, Shape

LATHE = Lathe([0, 0.1, 0.25, 0.4, 0.5], [0.01, 0.02, 0.05, 0.08, 0.01])


def _cone(p: np.ndarray) -> np.ndarray:
    """Distance of points to a rounded cone, by sampling the balls it is the hull of."""
    shares = np.linspace(0, 1, 2001)
    balls = [
        np.linalg.norm(p - np.array([[0], [s * 0.6], [0]]), axis=0) - (0.2 + s * (0.08 - 0.2))
        for s in shares
    ]
    return np.min(balls, axis=0)


SURFACES = {
    "ball": (Ball(), lambda p: np.linalg.norm(p, axis=0) - 1),
    "box": (Box(), lambda p: np.abs(p).max(axis=0) - 1),
    "cylinder": (Cylinder(), lambda p: np.maximum(np.hypot(p[0], p[2]), np.abs(p[1])) - 1),
    "cone": (RoundCone(0.2, 0.08, 0.6), _cone),
    "lathe": (LATHE, lambda p: np.hypot(p[0], p[2]) - LATHE.radius(p[1].astype(np.float32))),
}


@pytest.mark.parametrize("name", SURFACES)
def test_rays_end_on_the_surface_and_nothing_nearer_was_missed(name: str) -> None:
    shape, distance = SURFACES[name]
    rng = np.random.default_rng(7)
    lo, hi = shape.bounds
    size = float(np.linalg.norm(hi - lo))
    o = ((lo + hi) / 2 + np.array([0.5, 0.4, -0.9]) * size).astype(np.float32)
    targets = rng.uniform(lo, hi, (400, 3)).T
    d = (targets - o[:, None]).astype(np.float32)
    t = shape.hit(o, d)
    seen = np.isfinite(t)
    assert 100 < seen.sum() <= 400
    p = o[:, None] + d[:, seen] * t[seen]
    assert np.abs(distance(p.astype(np.float64))).max() < 4e-3 * size
    for share in np.linspace(0.02, 0.98, 25):
        before = o[:, None] + d[:, seen] * t[seen] * share
        assert distance(before.astype(np.float64)).min() > -4e-3 * size


@pytest.mark.parametrize("name", SURFACES)
def test_normals_face_where_the_ray_came_from(name: str) -> None:
    shape: Shape = SURFACES[name][0]
    lo, hi = shape.bounds
    size = float(np.linalg.norm(hi - lo))
    o = ((lo + hi) / 2 + np.array([-0.6, 0.7, 0.8]) * size).astype(np.float32)
    targets = np.random.default_rng(8).uniform(lo * 0.8, hi * 0.8, (300, 3)).T
    d = (targets - o[:, None]).astype(np.float32)
    t = shape.hit(o, d)
    seen = np.isfinite(t)
    p = (o[:, None] + d[:, seen] * t[seen]).astype(np.float32)
    assert ((shape.normal(p) * d[:, seen]).sum(axis=0) < 1e-4).mean() > 0.98
