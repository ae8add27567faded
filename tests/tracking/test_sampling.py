"""Where a camera was, by how evenly its points fill an image."""

import numpy as np

from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.examination import find_camera, most_even_place, unevenness

OPTIONS = TrackerOptions()

PLACE = np.array([0.4, -0.2, 1.5])


def _room() -> np.ndarray:
    """(N, 3) a wall at 3 m with somebody 1.2 m before it, from PLACE."""
    across, down = np.meshgrid(np.linspace(-0.7, 0.7, 160), np.linspace(-0.55, 0.55, 120))
    depth = np.where((np.abs(across) < 0.15) & (down > -0.3), 1.8, 3.0)
    depth = np.where(down > 0.35, 0.35 * 3.0 / np.maximum(down, 0.1), depth)
    local = np.stack([across, down, np.ones_like(across)], axis=-1) * depth[..., None]
    return local.reshape(-1, 3) + PLACE


def test_a_place_that_is_too_far_away_comes_back() -> None:
    xyz = _room()
    behind = PLACE - [0.05, 0.3, 1.0]
    found = most_even_place(xyz, behind, 1.5, options=OPTIONS.viewpoint)
    assert np.linalg.norm(found - PLACE) < 0.06
    assert unevenness(xyz, found, options=OPTIONS.viewpoint) < 0.5 * unevenness(
        xyz, behind, options=OPTIONS.viewpoint
    )


def test_a_camera_is_looked_for_by_that_too() -> None:
    xyz = _room().astype(np.float32)
    found = find_camera(xyz, options=OPTIONS)
    assert found is not None
    assert np.linalg.norm(found - PLACE) < 1.0  # 1.4 by what is hidden alone: so little is


def test_no_image_is_all_round() -> None:
    rng = np.random.default_rng(0)
    rays = rng.normal(size=(4000, 3))
    assert unevenness(rays, np.zeros(3), options=OPTIONS.viewpoint) == np.inf
