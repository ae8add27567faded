"""A thing hardly thicker than the depth noise, put down elsewhere on the table."""

from __future__ import annotations

import numpy as np
import scenes
from scipy.spatial.transform import Rotation

from pointbrush.tracking import METHODS, Seed, TrackOptions

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


def test_a_thin_thing_has_what_hardly_stands_out_against_the_table() -> None:
    frames = pushed_aside()
    seeds = [Seed(1, np.flatnonzero(frames[0].truth == 1))]
    order, options = range(len(frames)), TrackOptions(continue_lost=True)
    *_, result = METHODS["auto"]().track(frames.__getitem__, order, seeds, lambda _: None, options)
    found, last = np.zeros(len(frames[-1].truth), bool), frames[-1].truth == 1
    found[result.assignments[1]] = True
    assert (found & last).sum() / (found | last).sum() > 0.9
