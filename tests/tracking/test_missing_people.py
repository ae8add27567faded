"""People who are missing or have left are found again by place, clothes and stature."""

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
    crossing,
    staged,
    staged_person,
)

from pointbrush.tracking import Seed, TrackOptions
from pointbrush.tracking.people.arrivals import confusable_people, return_missing_people
from pointbrush.tracking.people.group import Group, outcome
from pointbrush.tracking.tracker import Run


def test_who_was_not_met_where_he_was_expected_is_missing_in_the_same_frame() -> None:
    near, gone = staged_person(1, 0.0, RED, last_clear=9), staged_person(2, 1.0, RED, last_clear=2)
    observation = staged(body(0.1, RED))
    return_missing_people(observation, [near, gone], 30, now=10)
    assert np.all(observation.owner == 1)


def test_who_is_missing_is_looked_for_in_what_another_has_by_clothes() -> None:
    both, gone = staged_person(1, 0.0, RED, last_clear=9), staged_person(2, 0.3, BLUE, last_clear=5)
    observation = staged(body(0.0, RED), body(0.3, BLUE))
    observation.owner[:] = 1
    return_missing_people(observation, [both, gone], 30, now=10)
    assert np.mean(observation.owner[:30] == 1) > 0.6
    assert np.all(observation.owner[33:] == 2)


@pytest.mark.parametrize(("wear", "doubted"), [(RED, True), (BLUE, False)])
def test_who_is_found_where_another_dressed_alike_is_missing_is_doubted(
    wear: np.ndarray, doubted: bool
) -> None:
    found, gone = (
        staged_person(1, 0.0, RED, last_clear=5),
        staged_person(2, 0.2, wear, last_clear=5),
    )
    found.frames_unseen = gone.frames_unseen = 4
    observation = staged(body(0.1, RED))
    observation.owner[:] = 1
    assert (confusable_people(observation, [found, gone], found, 10) == [gone]) == doubted
    group = Group(OPTIONS, [found, gone], 0.1, 0.01, observation.flat, UP, 30.0, 10)
    group.doubt(observation, found, SURE)
    assert found.identity.doubts == ({2} if doubted else set())
    assert gone.identity.doubts == ({1} if doubted else set())
    # The other is found elsewhere: in clothes that both wear, either may still be either.
    found.frames_unseen, gone.last_clear = 0, 10
    observation.owner[15:] = 2
    group.doubt(observation, found, SURE)
    assert bool(found.identity.doubts) == doubted
    # Painted anew, or looked for no more, the other is not he.
    group.drop(2)
    assert not found.identity.doubts


def test_who_has_two_bodies_is_doubted_while_another_is_missing() -> None:
    both, gone = staged_person(1, 0.0, RED, last_clear=9), staged_person(2, 0.3, RED, last_clear=5)
    group = Group(OPTIONS, [both, gone], 0.1, 0.01, np.eye(3)[:, [0, 2]], UP, 30.0, 10)
    observation = staged(body(0.0, RED), body(0.3, RED))
    observation.owner[:30] = 1
    group.doubt(observation, both, replace(SURE, size=1.0))
    assert not both.identity.doubts
    observation.owner[:] = 1
    group.doubt(observation, both, replace(SURE, size=2.0))
    assert both.identity.doubts
    assert gone.identity.doubts


def test_who_shows_scraps_alone_in_the_second_frame_may_be_elsewhere() -> None:
    made = crossing(stranger=False, frames=2)
    first, order = made[0].truth, [0, 1]
    seeds = [Seed(n, np.flatnonzero(first == n)) for n in (1, 2)]
    run = Run(made.__getitem__, order, seeds, lambda _: None, TrackOptions())
    run.start(seeds)
    run.scene.close()
    assert run.people.group is not None
    assert len(run.people.group.people) == 2
    for person in run.people.group.people:
        scraps = staged(body(0.0, RED))
        scraps.owner[:2] = person.label
        assert person.may_be_elsewhere(scraps, 1)


def test_scraps_are_not_where_somebody_was_well_seen() -> None:
    person = staged_person(1, 0.0, RED, last_clear=4)
    observation = staged(body(2.0, RED), body(0.2, RED))
    # One point in a cell, of a few that lie elsewhere, is hardly anything of him.
    observation.cells.count[:30] = 1
    observation.owner[:10] = 1
    person.follow(observation, np.array([2.0, 0.0, 0.0]), 9)
    assert person.last_clear == 4
    return_missing_people(observation, [person], 30, now=10)
    assert np.all(observation.owner[30:] == 1)


@pytest.mark.parametrize(
    ("fps", "entered", "tops", "back"),
    [
        (5.0, 0.0, [], False),
        (15.0, 0.0, [], True),
        (15.0, 1.5, [], False),
        (15.0, 0.0, [1.8] * 3, False),
        (5.0, 1.5, [1.7] * 3, True),
        (5.0, 0.0, [1.8] * 3, False),
    ],
)
def test_a_newcomer_is_a_person_who_left_if_time_place_and_stature_tell(
    fps: float, entered: float, tops: list[float], back: bool
) -> None:
    person, newcomer = (
        staged_person(1, 0.0, RED, last_clear=1),
        staged_person(-1, 0.3, RED, last_clear=9),
    )
    person.at_side, person.frames_unseen, newcomer.since = True, 12, 5 + 6
    newcomer.displacement = np.array([0.3 - entered, 0.0, 0.0])
    person.identity.stature.tops, newcomer.identity.stature.tops = [1.7] * 3, tops
    observation = staged(body(0.3, RED))
    observation.fps = fps
    observation.owner[:] = -1
    return_missing_people(observation, [person, newcomer], 30, now=16)
    assert np.all(observation.owner == (1 if back else -1))
    if back:
        person.follow(observation, np.zeros(3), 16)
        person.identity.confidence = 1.0
        state = outcome(observation, person, SURE).state
        assert 0 < state.confidence < OPTIONS.body.doubted_confidence


def test_of_two_who_are_missing_the_one_who_is_as_tall_has_come_back() -> None:
    gone = [as_tall(1, 0.05, 0.0), as_tall(2, 0.1, 0.2)]
    for person in gone:
        person.last_clear = 5
    observation = staged(body(0.0, RED, 0.2), coloured=False)
    return_missing_people(observation, gone, 30, now=10)
    assert np.all(observation.owner == 2)


@pytest.mark.parametrize("touching", [False, True])
def test_of_two_bodies_that_one_has_each_is_whose_stature_it_has(touching: bool) -> None:
    both, gone = as_tall(1, 0.0, 0.0), as_tall(2, 0.0, 0.2)
    gone.last_clear = 5
    hands = np.stack([np.linspace(0.3, 0.5, 3), np.full(3, 0.5), np.full(3, 3.0)], axis=1)
    between = [(hands, np.tile(RED, (3, 1)))] if touching else []
    observation = staged(body(0.0, RED, 0.2), body(0.6, RED), *between, coloured=False)
    observation.owner[:] = 1
    return_missing_people(observation, [both, gone], 30, now=10)
    assert observation.owner[[0, 30]].tolist() == [2, 1]
    assert both.identity.doubts == {2}
    assert gone.identity.doubts == {1}


def test_a_raised_arm_is_nobody_elses() -> None:
    both, gone = as_tall(1, 0.0, 0.0), as_tall(2, 0.0, 0.2)
    gone.last_clear = 5
    arm = np.stack([np.linspace(0.3, 0.7, 5), np.linspace(0.3, -0.1, 5), np.full(5, 3.0)], axis=1)
    observation = staged(body(0.0, RED), (arm, np.tile(RED, (5, 1))), coloured=False)
    observation.owner[:] = 1
    return_missing_people(observation, [both, gone], 30, now=10)
    assert np.all(observation.owner == 1)


@pytest.mark.parametrize(("last_clear", "cap"), [(4, OPTIONS.body.doubted_confidence), (8, 1.0)])
def test_who_was_long_seen_in_scraps_at_a_side_may_be_another(last_clear: int, cap: float) -> None:
    person = staged_person(1, 0.0, RED, last_clear=last_clear)
    person.at_side = True
    observation = staged(body(0.0, RED))
    observation.owner[:] = 1
    person.follow(observation, np.zeros(3), 9)
    assert person.identity.cap == cap
