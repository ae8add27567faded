"""Toys that bend are followed whole; what is stiff is not taken to bend."""

from __future__ import annotations

import numpy as np
import scenes
from conftest import follow
from scipy.spatial.transform import Rotation


def snake(frames: int, bend: float, every: int = 1) -> list[scenes.Frame]:
    """A chain of capsules on the floor, waving by ``bend`` radians a joint; some of its frames."""
    rng = np.random.default_rng(6)
    sensor = scenes.Sensor(origin=np.array([0.0, 0.6, 0.6]))
    sensor.look = Rotation.from_euler("x", 22, degrees=True).as_matrix()
    camera = scenes.Camera(sensor, scenes.room())
    result = []
    for number in range(0, frames, every):
        at, angle, parts = np.array([-0.3, 0.03, 1.5]), 0.2 * np.sin(0.05 * number), []
        for joint in range(8):
            angle += bend * np.sin(0.06 * number + joint)
            to = at + 0.07 * np.array([np.cos(angle), 0.0, np.sin(angle)])
            tint = (200, 160, 40) if joint % 2 else (60, 140, 80)
            parts.append(scenes.Part(1, tint, at, to, 0.03, 0.03))
            at = to
        result.append(camera.shoot(parts, rng))
    return result


def test_a_snake_that_waves_is_followed_to_its_ends() -> None:
    frames = snake(24, bend=0.3)
    last = follow(frames)[-1]
    truth = frames[-1].truth == 1
    found = last.assignments[1]
    both = np.count_nonzero(truth[found])
    assert both > 0.9 * (np.count_nonzero(truth) + len(found) - both)


def test_a_snake_that_no_rigid_fit_explains_is_bent_all_the_same() -> None:
    frames = snake(48, bend=1.0, every=3)
    last = follow(frames)[-1]
    truth = frames[-1].truth == 1
    found = last.assignments[1]
    both = np.count_nonzero(truth[found])
    assert both > 0.7 * (np.count_nonzero(truth) + len(found) - both)
