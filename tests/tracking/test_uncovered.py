"""What an object in front uncovers of another when it is taken away."""

from __future__ import annotations

import numpy as np
import scenes

from pointbrush.tracking import METHODS, Seed, TrackOptions
from pointbrush.tracking.options import TrackerOptions

OPTIONS = TrackerOptions()

STILL, AWAY = 5, 9


def uncovering() -> list[scenes.Frame]:
    """A box on a table, a board hides all but an edge; it is drawn aside from frame STILL."""
    rng = np.random.default_rng(4)
    upright = np.eye(3)
    table = scenes.Part(
        0, (150, 110, 70), np.array([0, 0.86, 1.6]), np.array([0.8, 0.02, 0.4]), rot=upright
    )
    camera = scenes.Camera(scenes.Sensor(256, 212), [*scenes.room(), table])
    frames = []
    for number in range(STILL + AWAY):
        aside = 0.05 * max(0, number - STILL + 1)
        box = scenes.Part(
            1, (40, 90, 200), np.array([0, 1.0, 1.6]), np.array([0.15, 0.12, 0.1]), rot=upright
        )
        board = scenes.Part(
            2,
            (200, 60, 40),
            np.array([0.06 + aside, 1.0, 1.3]),
            np.array([0.17, 0.15, 0.01]),
            rot=upright,
        )
        frames.append(camera.shoot([box, board], rng))
    return frames


def test_what_is_uncovered_of_an_object_becomes_its_own() -> None:
    frames = uncovering()
    first, last = frames[0].truth, frames[-1].truth
    assert (last == 1).sum() > 3 * (first == 1).sum()
    seeds = [Seed(n, np.flatnonzero(first == n)) for n in (1, 2)]
    order = range(len(frames))
    *_, result = METHODS["auto"]().track(
        frames.__getitem__, order, seeds, lambda _: None, TrackOptions()
    )
    found = np.zeros(len(last), bool)
    found[result.assignments[1]] = True
    assert (found & (last == 1)).sum() / (found | (last == 1)).sum() > 0.9
