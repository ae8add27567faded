"""What is found elsewhere while it is in doubt may be another."""

from __future__ import annotations

import numpy as np
import pytest
import scenes
import views

from pointbrush.tracking.compute.rigid import transform
from pointbrush.tracking.interface import TrackOptions
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import OtherMovers
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.association import Association, LabelledPoints
from pointbrush.tracking.steps.claim import claim
from pointbrush.tracking.steps.settle import settle
from pointbrush.tracking.steps.update import begin

FRAMES = 6


def box(x: float, colour: bool) -> View:
    """A box in mid-air ``x`` metres aside, label 1."""
    size = np.array([0.1, 0.12, 0.06])
    view = views.shot(scenes.Part(1, views.BLUE, np.array([x, 1.2, 1.6]), size, rot=np.eye(3)))
    if not colour:
        view.frame.rgb = None
    return view


@pytest.mark.parametrize(
    ("colour", "people", "aside", "isolated", "trusted"),
    [
        (False, (), 0.2, False, False),
        (False, (), 0.2, True, True),
        (False, (), 0.01, False, True),
        (True, (), 0.2, False, True),
        (True, (2,), 0.2, False, False),  # somebody's sleeve may have its colours
        (True, (2,), 0.2, True, True),
    ],
)
def test_what_is_found_elsewhere_without_colours_or_among_people_is_doubted_until_it_is_alone(
    colour: bool, people: tuple[int, ...], aside: float, isolated: bool, trusted: bool
) -> None:
    first, now = box(0.0, colour), box(aside, colour)
    now.people = people
    track = begin(first, 1, np.flatnonzero(first.frame.truth == 1), 0.004, OtherMovers.none())
    track.confidence = 0.0
    own = np.flatnonzero(now.frame.truth == 1)
    pose = np.eye(4)
    pose[0, 3] = aside
    for _ in range(FRAMES):
        model = track.model
        world = transform(pose, model.xyz)
        found = claim(now, own, world, model.colour, track.weight, 3 * track.reach)
        place = Registration(pose, world, (world.min(0), world.max(0)), own, own, own, 0.02)
        given = LabelledPoints(found, isolated=isolated)
        outcome = settle(track, now, Association(place, found), given, TrackOptions())
    assert (outcome.state.confidence > 0.5) == trusted
