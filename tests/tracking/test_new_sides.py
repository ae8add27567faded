"""Sides of an object that turn towards the camera while an arm holds it."""

from __future__ import annotations

import numpy as np
import scenes
from runs import follow
from scipy.spatial.transform import Rotation

FRAMES = 14


def turning() -> list[scenes.Frame]:
    """A box, label 1, that an arm from beside the picture turns; its sides have other colours."""
    rng = np.random.default_rng(5)
    camera = scenes.Camera(scenes.Sensor(256, 212), scenes.room())
    frames = []
    for number in range(FRAMES):
        turn = Rotation.from_euler("y", 2.5 * number + 4, degrees=True).as_matrix()
        at = np.array([0.1 - 0.004 * number, 1.2, 1.7])
        half = np.array([0.13, 0.16, 0.13])
        front, side = turn @ np.array([0, 0, -0.002]), turn @ np.array([0.002, 0, 0])
        box = [
            scenes.Part(1, (40, 90, 200), at + front, half, rot=turn),
            scenes.Part(1, (200, 170, 40), at + side, half, rot=turn),
            scenes.Part(1, (200, 170, 40), at - side, half, rot=turn),
        ]
        hold = at + turn @ np.array([0.0, 0.2, 0.0])
        arm = scenes.Part(0, (190, 140, 110), hold, hold + np.array([0.9, 0.25, 0.3]), 0.04, 0.05)
        frames.append(camera.shoot([*box, arm], rng))
    return frames


def test_a_side_that_turns_towards_the_camera_is_the_objects() -> None:
    frames = turning()
    *_, result = follow(frames)
    truth = frames[-1].truth == 1
    found = np.zeros(len(truth), np.bool_)
    found[result.assignments[1]] = True
    assert (found & truth).sum() / (found | truth).sum() > 0.9
