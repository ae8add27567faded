"""What rests is found again where it was when what hid it has gone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scenes

from pointbrush.tracking import METHODS, Seed, TrackOptions
from pointbrush.tracking.model.track import OtherMovers, begin
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.settle import is_clearly_visible
from pointbrush.tracking.steps.verdict import Verdict

OPTIONS = TrackerOptions()

BEGINS, COVERS, LEAVES, ENDS = 8, 12, 18, 24


def passing(seed: int) -> list[scenes.Frame]:
    """A small box on a table; an arm comes over it, holds still there and goes."""
    rng = np.random.default_rng(seed)
    upright = np.eye(3)
    table = scenes.Part(
        0, (150, 110, 70), np.array([0, 0.86, 1.6]), np.array([0.8, 0.02, 0.4]), rot=upright
    )
    camera = scenes.Camera(scenes.Sensor(256, 212), [*scenes.room(), table])
    frames = []
    for number in range(ENDS):
        done = np.interp(number, [BEGINS, COVERS, LEAVES, ENDS - 3], [0, 1, 1, 0])
        box = scenes.Part(
            1, (40, 90, 200), np.array([0, 0.91, 1.6]), np.array([0.1, 0.03, 0.05]), rot=upright
        )
        arm = scenes.Part(
            0,
            (70, 80, 110),
            np.array([0.62 - 0.57 * done, 0.91, 1.45]),
            np.array([0.25, 0.15, 0.03]),
            rot=upright,
        )
        frames.append(camera.shoot([box, arm], rng))
    return frames


def test_what_rests_is_found_where_it_was_when_what_hid_it_has_gone() -> None:
    frames = passing(2)
    truth = frames[-1].truth == 1
    assert truth.sum() > 100
    seeds = [Seed(1, np.flatnonzero(frames[0].truth == 1))]
    *_, result = METHODS["auto"]().track(
        frames.__getitem__, range(ENDS), seeds, lambda _: None, TrackOptions(continue_lost=True)
    )
    found = np.zeros(len(truth), bool)
    found[result.assignments.get(1, [])] = True
    assert (found & truth).sum() / (found | truth).sum() > 0.9


def test_what_moves_in_sight_rests_no_longer_though_it_shows_fewer_points() -> None:
    frame = passing(2)[0]
    none = OtherMovers.none()
    mine, hidden = np.flatnonzero(frame.truth == 1), np.empty(0, np.bool_)
    track = begin(
        View(0, frame, find_lens(frame, options=OPTIONS), options=OPTIONS), 1, mine, 0.004, none
    )
    few, clear = int(0.3 * track.size), Verdict(True, 0.9, 0.9, hidden, hidden, 0.9)
    for _ in range(4):
        track.motion = track.motion.add(np.eye(4))
    assert not is_clearly_visible(track, clear, few)
    for step in range(1, 4):
        pose = np.eye(4)
        pose[0, 3] = 0.1 * step
        track.motion = track.motion.add(pose)
    assert is_clearly_visible(track, clear, few)
    assert not is_clearly_visible(track, replace(clear, visible=0.2), few)
