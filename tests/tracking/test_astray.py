"""Things in hands: thrown, hidden and back elsewhere, or of other colours than who holds them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import scenes
from scipy.spatial.transform import Rotation

from pointbrush.tracking import METHODS, Seed, TrackOptions
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.steps import relocate as relocation
from pointbrush.tracking.steps.association import Associations
from pointbrush.tracking.steps.predict import crop
from pointbrush.tracking.steps.relocate import register_and_claim
from pointbrush.tracking.tracker import Run

OPTIONS = TrackerOptions()

SKIN, BLUE, GREEN = (210, 160, 130), (40, 90, 200), (60, 160, 70)
TURN = 0.5
"""Radians a frame."""
HAND = np.array([-0.3, 1.2, 1.4])


def shot(count: int, bat: Callable[[int], np.ndarray | None]) -> list[scenes.Frame]:
    """A hand that stirs, and a bat with its middle at ``bat(i)``, that turns from frame 6 on.

    The bat is not in the picture where that is None.
    """
    rng = np.random.default_rng(3)
    camera = scenes.Camera(scenes.Sensor(320, 264, 260.0), scenes.room())
    frames = []
    for i in range(count):
        hand = HAND + [0.012 * i, 0, 0]
        parts = [scenes.Part(0, SKIN, hand + [-0.3, -0.1, 0], hand, 0.04, 0.04)]
        at = bat(i)
        if at is not None:
            R = Rotation.from_euler("z", TURN * max(0, i - 5)).as_matrix()
            along = R @ [0.0, 0.07, 0.0]
            parts.append(scenes.Part(1, BLUE, at, at + along, 0.04, 0.03))
            parts.append(scenes.Part(1, GREEN, at - along, at, 0.02, 0.035))
        frames.append(camera.shoot(parts, rng))
    return frames


@contextmanager
def found_again(frames: list[scenes.Frame]) -> Iterator[tuple[Track, Associations]]:
    """Thing 1 of the first of two frames, and where it was found in the second."""
    seeds = [Seed(1, np.flatnonzero(frames[0].truth == 1))]
    run = Run(frames.__getitem__, [0, 1], seeds, lambda _: None, TrackOptions())
    run.start(seeds)
    view, track = run.scene.view(1), run.tracks[1]
    associations = Associations(view, run.background, np.ones(len(view.xyz), np.bool_))
    search = crop(track, view, associations.background, associations.free)
    assert search is not None
    yield track, associations.put(1, register_and_claim(track, view, search))


def ious(frames: list[scenes.Frame]) -> list[float]:
    seeds = [Seed(1, np.flatnonzero(frames[0].truth == 1))]
    run = METHODS["auto"]().track(
        frames.__getitem__,
        range(len(frames)),
        seeds,
        lambda _: None,
        TrackOptions(continue_lost=True),
    )
    result = []
    for found in run:
        truth, mine = frames[found.frame].truth == 1, np.zeros(len(frames[found.frame].xyz), bool)
        mine[found.assignments.get(1, [])] = True
        result.append(float((mine & truth).sum() / max(1, (mine | truth).sum())))
    return result[1:]


def test_what_leaves_a_hand_faster_than_it_moved_is_followed() -> None:
    def bat(i: int) -> np.ndarray:
        held = HAND + [0.06, 0.1, 0] + np.array([0.012, 0, 0]) * min(i, 5)
        return held + np.array([0.2, 0.04, 0.0]) * max(0, i - 5)

    assert min(ious(shot(9, bat))) > 0.7


def test_what_was_hidden_is_found_far_from_where_it_was() -> None:
    def bat(i: int) -> np.ndarray | None:
        if 4 <= i < 8:
            return None
        return HAND + ([0.06 + 0.012 * i, 0.1, 0] if i < 4 else [0.5 + 0.05 * i, 0.1, 0.2])

    found = ious(shot(11, bat))
    assert min(found[:3]) > 0.8
    assert max(found[3:7]) == 0.0  # a hand is no bat
    assert min(found[8:]) > 0.8


def test_hardly_anything_of_a_thing_far_from_where_it_should_be_is_not_the_thing() -> None:
    camera = scenes.Camera(scenes.Sensor(320, 264, 260.0), scenes.room())
    rng, frames = np.random.default_rng(3), []
    for i in range(2):
        at = np.array([0.05 * i, 1.2, 1.4])
        bat = [
            scenes.Part(1, BLUE, at, at + [0, 0.14, 0], 0.04, 0.03),
            scenes.Part(1, GREEN, at - [0, 0.14, 0], at, 0.02, 0.035),
        ]
        frames.append(camera.shoot(bat, rng))
    truth = frames[1].truth == 1
    with found_again(frames) as (track, associations):
        one = associations.found[1]
        claim = one.claim
        one.registration.pose[0, 3] += 0.6
        for share in (0.6, 0.2):
            some = claim.pick(np.arange(len(claim.indices)) < share * track.size)
            here = replace(one, claim=some)
            found = relocation.find_astray([track], {}, associations.put(1, here)).found[1]
            assert (found is here) == (share > 0.5)
        assert truth[found.claim.indices].mean() > 0.9
        assert len(found.claim.indices) > 0.8 * np.count_nonzero(truth)
