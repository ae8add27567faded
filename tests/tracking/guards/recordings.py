"""Recordings of a second or less, each of which needs some rules of the tracker."""

from __future__ import annotations

import numpy as np
import scenes
from scipy.spatial.transform import Rotation

MOVES, RESTS = 6, 5
THIN = 0.003
"""Half its thickness in metres: the top lies within some deviations of the noise of the table."""


def pushed_aside() -> list[scenes.Frame]:
    """A card on a table: it lies for two frames, is pushed to the right, and lies again."""
    tilt = Rotation.from_euler("x", -35, degrees=True).as_matrix()
    table = scenes.Part(
        0, (120, 118, 112), np.array([0, 1.0, 1.6]), np.array([0.8, 0.02, 0.5]), rot=tilt
    )
    camera = scenes.Camera(scenes.Sensor(256, 212), [*scenes.room(), table])
    rng, frames = np.random.default_rng(3), []
    for number in range(2 + MOVES + RESTS):
        aside = 0.05 * min(max(number - 1, 0), MOVES)
        at = table.a + tilt @ np.array([aside - 0.2, 0.02 + THIN, 0.0])
        card = scenes.Part(1, (170, 60, 50), at, np.array([0.1, THIN, 0.07]), rot=tilt)
        frames.append(camera.shoot([card], rng))
    return frames


def thrown() -> list[scenes.Frame]:
    """Three pins that one person throws, in twelve frames of few pixels."""
    return scenes.juggling(seed=1, frames=12, sensor=scenes.Sensor(256, 212, 210.0))
