"""Cells of the foreground: their size, their neighbours, and the person that each belongs to."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
import scenes
from staged_people import (
    OPTIONS,
    RED,
    UP,
    body,
    staged,
    staged_person,
)
from views import shot

from pointbrush.tracking.compute.graph import Paths, agreed, paths_into
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.people.foreground import Foreground
from pointbrush.tracking.people.group import cell_size, outcome
from pointbrush.tracking.people.observation import PersonObservation
from pointbrush.tracking.people.person import Person
from pointbrush.tracking.people.stature import across, upright
from pointbrush.tracking.scene.depth import ImageBackground
from pointbrush.tracking.sensors.view import View


def test_what_touches_agrees_unless_it_costs_too_much() -> None:
    # Five cells in a row: the first is surely one's, the last the other's, the rest undecided.
    cost = np.array([[0.0, 9.0], [1.0, 1.0], [1.0, 1.0], [1.2, 1.0], [9.0, 0.0]])
    start = np.array([0, 1, 3, 5, 7, 8])
    end = np.array([1, 0, 2, 1, 3, 2, 4, 3])
    apart = np.array([1.0, 1.0, 1.0, 1.0, 0.01, 0.01, 1.0, 1.0])
    assert agreed(
        cost,
        Paths(start, end, apart),
        OPTIONS.mean_field.sweeps,
        OPTIONS.mean_field.settled_change,
        OPTIONS.mean_field.same_change,
        OPTIONS.mean_field.neighbour_weight,
        OPTIONS.mean_field.full_neighbours,
    ).argmax(axis=1).tolist() == [0, 0, 0, 1, 1]


def test_cells_whose_neighbours_settled_are_asked_no_more_and_share_out_the_same() -> None:
    rng = np.random.default_rng(4)
    count, many = 400, 3
    cost = rng.uniform(0.0, 4.0, (count, many))
    start = np.concatenate([[0], np.cumsum(np.r_[1, np.full(count - 2, 2), 1])])
    end = np.array([j for i in range(count) for j in (i - 1, i + 1) if 0 <= j < count])
    links = Paths(start, end, np.full(len(end), 1.0))
    found, share = (
        agreed(
            cost,
            links,
            OPTIONS.mean_field.sweeps,
            OPTIONS.mean_field.settled_change,
            OPTIONS.mean_field.same_change,
            OPTIONS.mean_field.neighbour_weight,
            OPTIONS.mean_field.full_neighbours,
        ),
        np.exp(-cost),
    )
    share /= share.sum(axis=1, keepdims=True)
    for sweep in range(30):
        for i in range(count) if sweep % 2 == 0 else reversed(range(count)):
            beside = end[start[i] : start[i + 1]]
            odds = np.exp(8.0 * min(1.0, len(beside) / 3) * share[beside].mean(axis=0) - cost[i])
            share[i] = odds / odds.sum()
    assert np.mean(found.argmax(axis=1) == share.argmax(axis=1)) > 0.98


def test_ways_lead_into_what_is_sought_alone() -> None:
    links, length = np.array([[0, 1], [1, 2], [0, 3]]), np.array([1.0, 2.0, 3.0])
    ways = paths_into(links, length, np.array([True, True, False, False]))
    assert ways.start.tolist() == [0, 1, 2, 3, 4]
    assert ways.end.tolist() == [1, 0, 1, 0]
    assert ways.length.tolist() == [1.0, 1.0, 2.0, 3.0]


@pytest.mark.parametrize(("noise", "size"), [(0.002, 0.04), (0.01, 0.045), (0.05, 0.09)])
def test_cells_are_as_large_as_noise_asks_but_no_larger_than_limbs(
    noise: float, size: float
) -> None:
    view = SimpleNamespace(options=OPTIONS, cells=(None, np.full(5, 3.0)), labels={1: np.arange(5)})
    track = SimpleNamespace(options=OPTIONS, label=1, unit=0.01, span=0.9)
    background = SimpleNamespace(noise=lambda depth: np.full(len(depth), noise))
    found = cell_size(cast(View, view), cast(Track, track), cast(ImageBackground, background))
    assert found == pytest.approx(size, rel=0.02)


def test_cells_that_touch_anothers_are_counted() -> None:
    observation = staged(body(0.0, RED), body(0.3, RED))
    observation.owner[:] = np.repeat([1, 2], 30)
    assert observation.touching_others(observation.cells_of(1), 1) == pytest.approx(1 / 3)
    observation.owner[30:] = 0
    assert observation.touching_others(observation.cells_of(1), 1) == 0.0


def test_who_has_two_bodies_is_spread_wider_than_one() -> None:
    observation = staged(body(0.0, RED), body(0.9, RED))
    assert (
        observation.spread(np.arange(30))
        < OPTIONS.body.spread_m
        < observation.spread(np.arange(60))
    )


def test_who_is_seen_in_two_pieces_far_apart_keeps_a_surface() -> None:
    left, right = np.zeros((5, 3)), np.tile([1.6, 0.0, 3.0], (5, 1))
    middle = np.vstack([left, right])
    cells = SimpleNamespace(solid=np.ones(10, np.bool_), middle=middle, colour=middle, size=0.05)
    flat = np.eye(3)[:, [0, 2]]
    owner = np.ones(10, np.int64)
    observation = SimpleNamespace(
        options=OPTIONS, owner=owner, cells=cells, ground=middle @ flat, flat=flat
    )
    observation.cells_of, observation.area = lambda _: np.arange(10), len
    observation.at_side = lambda _: False
    person = Person.first_seen(OPTIONS, 1, middle, middle.astype(np.float32), 0)
    person.frames_unseen = 1
    person.follow(cast(PersonObservation, observation), np.zeros(3), 1)
    assert len(person.xyz) == 5


def test_what_shows_of_who_is_all_but_hidden_is_his() -> None:
    person = staged_person(1, 0.0, RED, last_clear=9)
    observation = staged(body(0.0, RED))
    observation.owner[:2] = 1
    person.follow(observation, np.zeros(3), 10)
    assert person.frames_unseen == 1
    found = outcome(observation, person, None)
    track, points = found.state, found.points
    assert track.state == "occluded"
    assert np.all(observation.owner[observation.cells.cell[points]] == 1)
    assert len(points) > 0


@pytest.mark.parametrize(("right", "cut"), [(-1.1, True), (0.0, False), (1.1, True)])
def test_who_touches_a_side_of_what_was_measured_may_leave_there(right: float, cut: bool) -> None:
    at, size = np.array([right, 1.2, 1.6]), np.array([0.4, 0.5, 0.1])
    view = shot(scenes.Part(1, (40, 90, 200), at, size, rot=np.eye(3)))
    cells = Foreground.of(view, np.flatnonzero(view.frame.truth == 1), 0.1)
    observation = PersonObservation(view, cells, np.eye(3)[:, [0, 2]], UP, np.empty(0, np.int64))
    assert observation.at_side(np.arange(len(cells.count))) == cut


def test_the_floor_tells_the_way_up() -> None:
    rng = np.random.default_rng(1)
    right, ahead = rng.uniform(-2, 2, 3000), rng.uniform(2, 5, 3000)
    floor = np.stack([right, 1.2 + rng.normal(0, 0.01, 3000), ahead], axis=1)
    wall = np.stack([right, rng.uniform(-1.0, 1.2, 3000), np.full(3000, 5.0)], axis=1)
    xyz = np.vstack([floor, wall]).astype(np.float32)
    none = np.zeros(len(xyz), np.bool_)
    view = SimpleNamespace(
        options=OPTIONS, lens=1, T_picture_world=np.eye(4), xyz=xyz, labelled=lambda: none
    )
    # The edge of the picture cuts off the feet of who leans.
    leaning = np.stack([np.linspace(0.0, 0.1, 50), np.linspace(0.5, -0.5, 50), np.full(50, 3)], 1)
    up = upright(cast(View, view), across(cast(View, view), [leaning]))
    np.testing.assert_allclose(up, UP, atol=0.01)
