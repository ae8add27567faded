"""Depth images: found where the points prove where the sensor was, and only there."""

from __future__ import annotations

import numpy as np
import pytest
import scenes
from scipy.spatial.transform import Rotation

from pointbrush.tracking.interface import KnownSensor
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.scene.scene import Scene
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.view import View

OPTIONS = TrackerOptions()

TILTED = Rotation.from_euler("xyz", [0.3, 0.5, 0.2]).as_matrix()


def camera_points(depth: np.ndarray) -> np.ndarray:
    """What a camera at the origin measures of ``depth`` (120, 160), in no order."""
    v, u = np.mgrid[0:120, 0:160]
    xyz = np.stack([(u - 80) / 110 * depth, (v - 60) / 110 * depth, depth], -1).reshape(-1, 3)
    return np.random.default_rng(0).permutation(xyz)


def room() -> np.ndarray:
    """(120, 160) depths of a wall with a box before it."""
    depth = np.full((120, 160), 3.0) + np.linspace(0, 0.5, 160)
    depth[40:90, 60:100] = 1.4
    return depth


def frame(xyz: np.ndarray, viewpoint: np.ndarray | None = None) -> scenes.Frame:
    return scenes.Frame(xyz.astype(np.float32), viewpoint=viewpoint)


def test_a_pixel_lattice_is_found_without_a_viewpoint() -> None:
    seen = frame(camera_points(np.random.default_rng(0).uniform(1.0, 3.0, (120, 160))))
    lens = find_lens(seen, options=OPTIONS)
    assert lens is not None
    assert np.allclose(lens.pitch, 1 / 110, rtol=1e-3)
    view = View(0, seen, lens, options=OPTIONS)
    assert np.isfinite(view.depth).sum() == len(seen.xyz)
    cell, depth = view.cells
    assert np.array_equal(view.depth[cell], depth)


@pytest.mark.parametrize("how", ["turned", "noisy", "elsewhere"])
def test_one_surface_in_each_direction_is_an_image_too(how: str) -> None:
    xyz, viewpoint = camera_points(room()), None
    if how == "turned":
        xyz = xyz @ TILTED.T
    elif how == "noisy":
        xyz += np.random.default_rng(1).normal(0, 0.001, xyz.shape)
    else:
        viewpoint = np.array([4.0, -1.0, 2.0])
        xyz = xyz @ TILTED.T + viewpoint
    seen = frame(xyz, viewpoint)
    lens = find_lens(seen, options=OPTIONS)
    assert lens is not None
    cell, depth = View(0, seen, lens, options=OPTIONS).cells
    assert cell.min() >= 0
    assert depth.min() > 1.0
    # Most pixels hold two or three points, and the box shares few with the wall behind it.
    assert len(np.unique(cell)) > len(xyz) / 3
    box = np.linalg.norm(xyz - (0 if viewpoint is None else viewpoint), axis=1) < 2.0
    assert np.isin(cell[~box], cell[box]).mean() < 0.03


def test_no_image_where_nothing_proves_the_viewpoint() -> None:
    rng = np.random.default_rng(0)
    scattered = camera_points(rng.uniform(1.0, 3.0, (120, 160))) @ TILTED.T
    assert find_lens(frame(scattered), options=OPTIONS) is None
    assert (
        find_lens(frame(camera_points(room()) @ TILTED.T + [4.0, -1.0, 2.0]), options=OPTIONS)
        is None
    )
    two = np.concatenate([camera_points(room()), camera_points(room()) + [0.4, 0.2, 0.9]])
    assert find_lens(frame(two), options=OPTIONS) is None
    assert find_lens(frame(rng.normal(size=(3000, 3))), options=OPTIONS) is None
    assert find_lens(frame(np.zeros((3000, 3))), options=OPTIONS) is None
    wrong = np.array([0.0, 0.0, 1.0])
    assert find_lens(frame(camera_points(furnished()), wrong), options=OPTIONS) is None


def test_a_sensor_that_moves_has_an_image_where_its_pixels_show_or_a_room_is_all_it_sees() -> None:
    for away in (1.0, 20.0):
        lattice = camera_points(away * room())
        assert find_lens(frame(lattice), moves=True, options=OPTIONS) is not None
        lens = find_lens(frame(lattice @ TILTED.T), moves=True, options=OPTIONS)
        assert (lens is not None) == (away == 1.0)


def furnished() -> np.ndarray:
    """(120, 160) depths of a wall with things at many distances before it."""
    rng, depth = np.random.default_rng(3), np.full((120, 160), 3.0)
    for distance in np.linspace(2.6, 1.2, 12):
        top, left = rng.integers(0, 100), rng.integers(0, 140)
        depth[top : top + 20, left : left + 18] = distance
    return depth


def scene_of(xyz: np.ndarray) -> Scene:
    still = frame(xyz)
    return Scene(
        lambda _: still,
        [0, 1],
        lambda world: np.ones(len(world), np.float32),
        ahead=False,
        known=KnownSensor(),
        options=OPTIONS,
    )


def test_a_camera_is_found_from_a_rooms_coordinates() -> None:
    at = np.array([4.0, -1.0, 2.0])
    found = scene_of(camera_points(furnished()) @ TILTED.T + at).first.eye
    assert found is not None
    assert np.linalg.norm(found - at) < 0.25


def test_what_two_cameras_saw_has_no_image() -> None:
    one = camera_points(furnished()) + [4.0, -1.0, 2.0]
    other = camera_points(furnished()) @ Rotation.from_euler("y", 70, True).as_matrix().T
    assert scene_of(np.concatenate([one, other + [2.0, -1.0, 3.5]])).lens is None
    assert scene_of(np.zeros((3000, 3))).lens is None
    assert scene_of(np.empty((0, 3))).lens is None


def test_the_front_of_a_lidar_at_rest_is_no_depth_image() -> None:
    """Its rings lie metres apart on the ground: what is beside a point is another surface."""
    xyz = scenes.street(seed=3, frames=1, ego=False)[0].xyz
    ahead = np.abs(np.arctan2(xyz[:, 0], xyz[:, 2])) < np.pi / 4
    assert find_lens(frame(xyz[ahead], np.zeros(3)), options=OPTIONS) is None
