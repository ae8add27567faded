"""What is painted may move by itself: of the sensor only the rest tells."""

from __future__ import annotations

import numpy as np
import pytest
import scenes

from pointbrush.tracking.interface import KnownSensor
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.scene.scene import Scene
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.scan_odometry import find_trajectory

OPTIONS = TrackerOptions()

HEIGHT, WIDTH, FOCAL = 120, 160, 150.0
DEVIATION = 0.004


def picture(seed: int, aside: int, near: float) -> scenes.Frame:
    """A plain wall behind somebody with stripes, who fills most of the picture."""
    rng = np.random.default_rng(seed)
    row, column = np.mgrid[:HEIGHT, :WIDTH]
    depth = 3.0 + 0.01 * column
    rgb = np.full((HEIGHT, WIDTH, 3), 150.0)
    body = (column > 30 + aside) & (column < 130 + aside) & (row > 8)
    depth[body] = near + 0.1 * np.sin((row + 3 * column - 3 * aside) / 9)[body]
    rgb[body] = 120 + 90 * np.sin((column - aside) / 3)[body, None] * np.cos(row / 4)[body, None]
    depth += rng.normal(0, DEVIATION, depth.shape)
    x, y = (column - WIDTH / 2) / FOCAL * depth, (row - HEIGHT / 2) / FOCAL * depth
    xyz = np.stack([x, y, depth], axis=-1).reshape(-1, 3).astype(np.float32)
    colour = np.clip(rgb.reshape(-1, 3), 0, 255).astype(np.uint8)
    return scenes.Frame(xyz, colour, body.ravel())


@pytest.fixture(scope="module")
def frames() -> list[scenes.Frame]:
    return [picture(0, 0, 1.6), picture(1, 3, 1.6)]


def test_who_fills_the_picture_does_not_make_the_sensor_move(
    frames: list[scenes.Frame],
) -> None:
    assert find_lens(frames[0], moves=True, options=OPTIONS) is not None
    painted = np.flatnonzero(frames[0].truth)
    assert find_trajectory(frames.__getitem__, [0, 1], options=OPTIONS) is not None
    assert find_trajectory(frames.__getitem__, [0, 1], painted, options=OPTIONS) is None


def test_noise_is_measured_beside_what_is_painted(frames: list[scenes.Frame]) -> None:
    painted = np.flatnonzero(frames[0].truth)
    scene = Scene(
        frames.__getitem__,
        [0, 1],
        lambda xyz: np.zeros(len(xyz)),
        painted,
        ahead=False,
        known=KnownSensor(),
        options=OPTIONS,
    )
    assert scene.noise(scene.first, painted) < 2 * DEVIATION
