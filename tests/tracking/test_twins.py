"""Like things that meet in the air: whether their labels can be trusted afterwards."""

from __future__ import annotations

import numpy as np
import pytest
import scenes

from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import OtherMovers, Track, begin
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.identity import Swaps

OPTIONS = TrackerOptions()

BLUE, RED = (40, 90, 200), (200, 60, 40)
NONE = OtherMovers.none()
SPEED = 0.12


def pair(colour: tuple[int, int, int]) -> dict[int, Track]:
    """Two boxes, one blue and one of a ``colour``, half a metre to the left and to the right."""
    size = np.array([0.05, 0.12, 0.05])
    parts = [
        scenes.Part(1, BLUE, np.array([-0.54, 1.2, 1.9]), size, rot=np.eye(3)),
        scenes.Part(2, colour, np.array([0.54, 1.2, 1.9]), size, rot=np.eye(3)),
    ]
    camera = scenes.Camera(scenes.Sensor(256, 212), scenes.room())
    frame = camera.shoot(parts, np.random.default_rng(3))
    view = View(0, frame, find_lens(frame, options=OPTIONS), options=OPTIONS)
    return {n: begin(view, n, np.flatnonzero(frame.truth == n), 0.004, NONE) for n in (1, 2)}


def fly(colour: tuple[int, int, int], meant: float, swapped: bool) -> list[tuple[float, float]]:
    """How far both are trusted in each frame while they fly past each other.

    In the frame in which they meet they are found a share ``meant`` of the way off where they were
    going, towards each other; ``swapped``: from there on each is found where the other is.
    """
    tracks, twins, result = pair(colour), Swaps(OPTIONS.identity), []
    start = {n: track.motion.centre.copy() for n, track in tracks.items()}
    for number in range(1, 12):
        places = {}
        for label, track in tracks.items():
            way = SPEED * number if label == 1 else -SPEED * number
            at = start[label] + [way, 0.0, 0.0]
            if number >= 5 and swapped:
                at = start[3 - label] + [-way, 0.0, 0.0]
            if number == 5:
                at = at + meant * (start[1] + start[2] - 2 * at)
            pose = np.eye(4)
            pose[:3, 3] = at - track.motion.centre
            box = (at - 1.0, at + 1.0)
            none = np.empty(0, np.int64)
            places[label] = Registration(pose, track.model.xyz, box, none, none, none, 0.05)
        most = twins.meet(tracks, places)
        for label, track in tracks.items():
            track.motion = track.motion.add(places[label].pose)
        result.append((most.get(1, 1.0), most.get(2, 1.0)))
    return result


def test_what_flies_on_is_trusted() -> None:
    assert fly(BLUE, 0.0, swapped=False) == [(1.0, 1.0)] * 11


def test_what_is_found_where_the_other_was_going_is_not_trusted_from_there_on() -> None:
    trusted = fly(BLUE, 0.0, swapped=True)
    assert trusted[:4] == [(1.0, 1.0)] * 4
    assert max(max(both) for both in trusted[4:]) < 0.5


@pytest.mark.parametrize(("colour", "trusted"), [(BLUE, False), (RED, True)])
def test_even_evidence_says_nothing_until_both_have_flown_on(
    colour: tuple[int, int, int], trusted: bool
) -> None:
    """Other colours tell them apart at once."""
    most = fly(colour, 0.5, swapped=False)
    assert (max(most[4]) < 0.9) != trusted
    assert most[5 + OPTIONS.identity.compared_frames :] == [(1.0, 1.0)] * (
        6 - OPTIONS.identity.compared_frames
    )
