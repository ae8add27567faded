"""What people leave behind when they walk away, and what they carry."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from staged_people import (
    OPTIONS,
    RED,
    UP,
    body,
    staged,
    staged_person,
)

from pointbrush.tracking import TrackOptions
from pointbrush.tracking.model.motion import Motion
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.people.group import Group, JointTracking
from pointbrush.tracking.scene.depth import ImageBackground
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.settle import Outcome


def test_somebody_has_gone_where_he_is_elsewhere_along_the_ground() -> None:
    observation = staged(body(0.0, RED))
    person = staged_person(1, 0.0, RED, 0)
    observation.owner[:] = 1
    stride = 0.2 * observation.flat[:, 0]
    for now in range(3):
        person.follow(observation, observation.up, now)
    assert person.departure() is None
    for now in range(3, 6):
        person.follow(observation, stride, now)
    assert person.departure() == (3, pytest.approx(0.6))


def test_what_somebody_leaves_behind_is_made_scenery() -> None:
    observation = staged(body(0.0, RED))
    told: list[tuple[int, int, float]] = []
    background = SimpleNamespace(left_behind=lambda *what: told.append(what))
    people = [staged_person(label, 0.0, RED, 0) for label in (1, 2, -1)]
    for person, stride in zip(people, (0.3, 0.1, 0.3), strict=True):
        person.positions.extend(np.array([stride * i, 0.0]) for i in range(4))
    group = Group(OPTIONS, people, 0.1, 0.01, observation.flat, observation.up, 30.0)
    group.leave_behind(cast(ImageBackground, background))
    assert told == [(1, 2, pytest.approx(0.6))]


@pytest.mark.parametrize(("confidence", "along"), [(0.9, True), (0.1, False)])
def test_what_somebody_carries_goes_along_with_them_while_it_is_hidden(
    confidence: float, along: bool
) -> None:
    bearer = staged_person(2, 0.0, RED, last_clear=9)
    view = cast(View, SimpleNamespace(xyz=np.vstack([bearer.xyz, bearer.xyz]).astype(np.float32)))
    bag = SimpleNamespace(
        label=1, unit=0.01, confidence=confidence, has_left_start=True, carrier=None, size=9.0,
        motion=Motion(OPTIONS.search, np.median(bearer.xyz, axis=0)),
    )  # fmt: skip
    tracking = JointTracking(cast(dict[int, Track], {1: bag}), OPTIONS, TrackOptions())
    tracking.group = Group(OPTIONS, [bearer], 0.1, 0.01, np.eye(3)[:, [0, 2]], UP, 30.0)
    own, theirs = np.split(np.arange(len(view.xyz)), 2)
    seen, hidden = (
        SimpleNamespace(state=SimpleNamespace(state=state), points=points)
        for state, points in (("tracked", own), ("occluded", own[:0]))
    )
    person = SimpleNamespace(state=SimpleNamespace(state="tracked"), points=theirs)
    before = bag.motion.place
    tracking.update_carriers(view, cast(dict[int, Outcome], {1: seen, 2: person}))
    bearer.xyz = bearer.xyz + [0.4, 0.0, 0.1]
    tracking.update_carriers(view, cast(dict[int, Outcome], {1: hidden, 2: person}))
    assert np.allclose(bag.motion.place - before, np.multiply([0.4, 0.0, 0.1], along))
