"""Exchanged labels of people are doubted, and corrected once clothes or statures differ."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from staged_people import (
    BLUE,
    OPTIONS,
    RED,
    SURE,
    UP,
    as_tall,
    body,
    staged,
    staged_person,
)

from pointbrush.tracking.people.arrivals import find_exchanged_people, restore_exchanged_people
from pointbrush.tracking.people.group import Group, astray


def test_doubts_end_when_clothes_tell() -> None:
    one, two = staged_person(1, 0.0, RED, last_clear=10), staged_person(2, 1.0, BLUE, last_clear=10)
    one.doubt(two)
    observation = staged(body(0.0, RED), body(1.0, RED))
    observation.owner[:] = np.repeat([1, 2], 30)
    group = Group(OPTIONS, [one, two], 0.1, 0.01, observation.flat, UP, 30.0, 10)
    group.doubt(observation, one, SURE)
    group.doubt(observation, two, replace(SURE, like=-2.0))
    assert (one.identity.doubts, two.identity.doubts) == (set(), {1})


@pytest.mark.parametrize(
    ("touching", "doubted", "told"), [(0.0, False, True), (0.2, False, False), (0.0, True, False)]
)
def test_what_was_hidden_where_somebody_was_painted_tells_their_clothes_once_he_is_alone(
    touching: float, doubted: bool, told: bool
) -> None:
    legs, shirt = body(0.0, BLUE), body(0.0, RED, tall=1.0)
    person = staged_person(1, 0.0, BLUE, last_clear=10)
    person.identity.colours, person.identity.shown = legs[1], 30 * 5 * 9.0
    if doubted:
        person.doubt(staged_person(2, 1.0, RED, last_clear=5))
    observation = staged(legs, shirt)
    observation.owner[:] = 1
    assert person.likeness(shirt[1]) < -OPTIONS.body.unlike_log
    group = Group(OPTIONS, [person], 0.1, 0.01, observation.flat, UP, 30.0, 10)
    group.doubt(observation, person, replace(SURE, touching=touching))
    assert (person.likeness(shirt[1]) > -0.3) == told
    assert person.likeness(legs[1]) > -0.3


def test_who_is_where_another_was_expected_is_astray() -> None:
    observation = staged(body(0.0, RED))
    here, beside = np.array([0.1, 3.0]), np.array([0.6, 3.0])
    cells = np.arange(30)
    assert astray(observation, 1, cells, {1: here, 2: beside}) < -1
    assert astray(observation, 1, cells, {1: beside, 2: here}) > 1
    assert astray(observation, 1, cells, {1: here}) < -2


@pytest.mark.parametrize(("wear", "told"), [(BLUE, True), (RED, False)])
def test_who_changed_places_are_changed_back_when_their_clothes_tell(
    wear: np.ndarray, told: bool
) -> None:
    one, two = staged_person(1, 0.0, RED, last_clear=9), staged_person(2, 1.0, wear, last_clear=9)
    one.displacement = np.array([0.5, 0.0, 0.0])
    observation = staged(body(0.0, wear), body(1.0, RED))
    observation.owner[:] = np.repeat([1, 2], 30)
    for now in range(10, 10 + OPTIONS.arrivals.exchange_frames):
        assert observation.owner[0] == 1
        assert bool(one.identity.doubts) == (told and now > 10)
        one.last_clear = two.last_clear = now - 1
        restore_exchanged_people(observation, [one, two], now)
    assert observation.owner[[0, 30]].tolist() == ([2, 1] if told else [1, 2])
    assert one.label == (2 if told else 1)
    him = two if told else one
    np.testing.assert_allclose(him.displacement, [1.5 if told else 0.5, 0.0, 0.0], atol=1e-9)


@pytest.mark.parametrize(("other", "told"), [(0.2, True), (0.01, False)])
def test_who_changed_places_are_changed_back_when_their_statures_tell(
    other: float, told: bool
) -> None:
    one, two = as_tall(1, 0.0, 0.0), as_tall(2, 1.0, other)
    observation = staged(body(0.0, RED, other), body(1.0, RED, 0.0), coloured=False)
    observation.owner[:] = np.repeat([1, 2], 30)
    restore_exchanged_people(observation, [one, two], 10)
    assert observation.owner[[0, 30]].tolist() == ([2, 1] if told else [1, 2])
    assert one.identity.stature.tops[0] == (other if told else 0.0)


@pytest.mark.parametrize("doubted", [True, False])
def test_who_is_doubted_and_as_tall_as_somebody_new_without_a_label_is_he(doubted: bool) -> None:
    one, stranger = as_tall(1, 0.0, 0.3), staged_person(-1, 1.0, RED, last_clear=9)
    one.identity.doubts = {2} if doubted else set()
    one.identity.sure, stranger.since = 4, 6
    observation = staged(body(0.0, RED, 0.0), body(1.0, RED, 0.3), coloured=False)
    observation.owner[:] = np.repeat([1, -1], 30)
    for now in range(10, 10 + OPTIONS.arrivals.exchange_frames):
        one.last_clear = stranger.last_clear = now
        restore_exchanged_people(observation, [one, stranger], now)
    assert observation.owner[[0, 30]].tolist() == ([-1, 1] if doubted else [1, -1])
    # Who was there while he was surely himself is not he.
    one.identity.sure = 8
    assert not list(find_exchanged_people(observation, [one, stranger], 10))


def test_who_is_as_tall_as_another_is_doubted_until_he_is_as_tall_as_himself() -> None:
    one, two = as_tall(1, 0.0, 0.0), as_tall(2, 1.0, 0.2)
    group = Group(OPTIONS, [one, two], 0.1, 0.01, np.eye(3)[:, [0, 2]], UP, 30.0, 10)
    for tall, doubts in ((0.2, {2}), (0.0, set())):
        observation = staged(body(0.0, RED, tall), coloured=False)
        observation.owner[:] = 1
        group.doubt(observation, one, SURE)
        assert one.identity.doubts == doubts
    # While something hides his head, the top of what shows is not his.
    observation = staged(body(0.0, RED, 0.2), coloured=False)
    observation.owner[:] = 1
    observation.view.depth[:] = 2.0
    group.doubt(observation, one, SURE)
    assert not one.identity.doubts


@pytest.mark.parametrize(
    "change",
    [
        {"fit": 3.0},
        {"disputed": 0.8},
        {"size": 0.1},
        {"change": 0.3},
        {"like": -2.0},
        {"touching": 0.3},
        {"wider": 0.1},
        {"astray": 1.0},
    ],
    ids=lambda change: next(iter(change)),
)
def test_what_fits_badly_is_trusted_less(change: dict[str, float]) -> None:
    assert SURE.likelihood(options=OPTIONS) > 0.9
    assert (
        replace(SURE, **change).likelihood(options=OPTIONS)
        < SURE.likelihood(options=OPTIONS) - 0.02
    )
