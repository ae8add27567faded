"""Depth images: found where the points prove a pixel lattice, and only there."""

from __future__ import annotations

import numpy as np
import scenes

from pointbrush.tracking.view import View, find_lens


def camera_frame(rng: np.random.Generator, turned: bool = False) -> scenes.Frame:
    v, u = np.mgrid[0:120, 0:160]
    depth = rng.uniform(1.0, 3.0, u.shape)
    xyz = np.stack([(u - 80) / 110 * depth, (v - 60) / 110 * depth, depth], -1).reshape(-1, 3)
    if turned:
        xyz = xyz @ scenes.Rotation.from_euler("xyz", [0.3, 0.5, 0.2]).as_matrix().T
    return scenes.Frame(rng.permutation(xyz).astype(np.float32))


def test_a_pixel_lattice_is_found_without_a_viewpoint() -> None:
    frame = camera_frame(np.random.default_rng(0))
    lens = find_lens(frame)
    assert lens is not None
    assert np.allclose(lens.pitch, 1 / 110, rtol=1e-3)
    view = View(0, frame, lens)
    assert np.isfinite(view.depth).sum() == len(frame.xyz)
    cell, depth = view.cells
    assert np.array_equal(view.depth[cell], depth)


def test_no_image_where_nothing_proves_the_viewpoint() -> None:
    rng = np.random.default_rng(0)
    assert find_lens(camera_frame(rng, turned=True)) is None
    assert find_lens(scenes.Frame(rng.normal(size=(3000, 3)).astype(np.float32))) is None
    assert find_lens(scenes.Frame(np.zeros((3000, 3), np.float32))) is None


def test_crops_are_the_same_with_a_pose() -> None:
    frame = camera_frame(np.random.default_rng(0))
    T = np.eye(4)
    T[:3, 3] = [5.0, 0.0, 1.0]
    here = View(0, frame, None).box(np.array([-0.2, -0.2, 1.0]), np.array([0.2, 0.2, 2.0]))
    there = View(0, frame, None, T).box(np.array([4.8, -0.2, 2.0]), np.array([5.2, 0.2, 3.0]))
    assert len(here) > 10
    assert np.array_equal(here, there)
