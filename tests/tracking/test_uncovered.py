"""What an object in front uncovers of another when it is taken away."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scenes

from pointbrush.tracking import METHODS, Seed, TrackOptions
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.scene.depth import ImageBackground
from pointbrush.tracking.scene.images import DepthNoise
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.view import View

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


def part(
    label: int, at: tuple[float, float, float], size: tuple[float, float, float]
) -> scenes.Part:
    colour = np.random.default_rng(label).integers(0, 256, 3)
    return scenes.Part(label, tuple(colour), np.array(at), np.array(size), rot=np.eye(3))


def uncovered_by_a_board(places: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Truth of all that a board uncovers on its way, and the label that hid it.

    ``places`` metres along x where it is in the painted frame and after it.
    """
    rng = np.random.default_rng(1)
    camera = scenes.Camera(scenes.Sensor(256, 212), scenes.room())
    lens = find_lens(camera.shoot([], rng), options=OPTIONS)
    background = None
    truth, hiders = [], []
    for number, place in enumerate(places):
        step = place - places[0]
        board = part(1, (place, 1.1, 1.3), (0.2, 0.15, 0.01))
        rests = part(2, (-0.1, 1.2, 1.6), (0.05, 0.05, 0.05))
        # It goes with the board, out of its shadow, and leans back.
        passes = part(3, (-0.05 + step, 1.0, 1.5 + step / 1.2), (0.15, 0.05, 0.05))
        frame = camera.shoot([board, rests, passes], rng)
        view = View(number, frame, lens, options=OPTIONS)
        if background is None:
            unknown = np.full_like(view.depth, np.nan)
            noise = DepthNoise(0.004, 0.002)
            background = ImageBackground(
                OPTIONS, noise, unknown, unknown.copy(), np.ones_like(unknown)
            )
        shown, hider = background.uncovered(view)
        view.labels = {1: np.flatnonzero(frame.truth == 1)}
        background.learn(view, first=number == 0)
        truth.append(frame.truth[shown])
        hiders.append(hider)
    return np.concatenate(truth), np.concatenate(hiders)


def test_what_passes_behind_a_thing_is_not_what_it_uncovers() -> None:
    truth, hider = uncovered_by_a_board([0.0, 0.0, 0.12, 0.24])
    assert (truth == 2).sum() > 10
    assert not (truth == 3).any()
    assert (hider == 1).all()


def test_what_only_passes_before_a_thing_uncovers_nothing_of_it() -> None:
    truth, _ = uncovered_by_a_board([-0.4, -0.4, -0.1, 0.1, 0.3, 0.5])
    assert not len(truth)
