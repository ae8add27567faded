"""How far a fit is trusted that looks good."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
import scenes
from runs import follow

from pointbrush.tracking import tracker as auto
from pointbrush.tracking.model.confidence import Evidence, likelihood
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.steps.settle import Outcome, settle

OPTIONS = TrackerOptions()

GOOD = Evidence(
    inliers=1.0,
    sure=0.75,
    gap=0.5,
    cost=1.0,
    fit=0.1,
    size=0.95,
    change=1.0,
    grown=0.0,
    isolated=False,
    share=0.4,
    appearance=0.0,
    usual=1.2,
    points=300,
)


def test_what_shows_few_points_is_trusted_less() -> None:
    """Small things are taken for each other; a lidar's hardly ever show more."""
    assert likelihood(replace(GOOD, points=1000), options=OPTIONS.confidence) > 0.9
    assert (
        likelihood(replace(GOOD, points=40), options=OPTIONS.confidence)
        < likelihood(replace(GOOD, points=150), options=OPTIONS.confidence)
        < 0.9
    )
    few = replace(GOOD, points=40, pixels=False)
    assert likelihood(few, options=OPTIONS.confidence) == likelihood(
        replace(few, points=1000), options=OPTIONS.confidence
    )


def test_what_bends_and_shrinks_is_not_trusted() -> None:
    half = replace(GOOD, size=0.5)
    assert (
        likelihood(replace(half, soft=True), options=OPTIONS.confidence)
        < 0.5
        < likelihood(half, options=OPTIONS.confidence)
    )


def test_unclaimed_surface_that_touches_an_object_speaks_against_it() -> None:
    alone = replace(GOOD, points=1000)
    by_a_hand, half = (replace(alone, beside=ratio) for ratio in (0.1, 0.3))
    options = OPTIONS.confidence
    assert likelihood(by_a_hand, options=options) == likelihood(alone, options=options) > 0.9
    assert likelihood(half, options=options) < 0.5


def test_what_a_lidar_left_beside_a_thing_speaks_against_it() -> None:
    """Half a car, and a car whose neighbour was taken for it, leave points unclaimed beside it."""
    alone = replace(GOOD, pixels=False, scans=True, left=0.01, others=0.1)
    assert likelihood(alone, options=OPTIONS.confidence) > 0.9
    assert likelihood(replace(alone, left=1.0), options=OPTIONS.confidence) < 0.5
    assert likelihood(replace(alone, left=0.1, bend=0.2), options=OPTIONS.confidence) < likelihood(
        alone, options=OPTIONS.confidence
    )
    crowded = replace(alone, others=1.0)
    assert (
        likelihood(replace(alone, left=1.0), options=OPTIONS.confidence)
        < likelihood(crowded, options=OPTIONS.confidence)
        < likelihood(alone, options=OPTIONS.confidence)
    )


def test_what_is_not_as_tall_before_a_lidar_as_it_was_is_trusted_less() -> None:
    """Half of somebody in a group leaves only the others beside him."""
    group = replace(GOOD, pixels=False, scans=True, left=0.2, others=1.0)
    assert (
        likelihood(replace(group, tall=0.5), options=OPTIONS.confidence)
        < 0.5
        < likelihood(group, options=OPTIONS.confidence)
    )


def test_what_suddenly_changes_before_a_lidar_is_trusted_less() -> None:
    """Who takes another's place shows more or less of himself, and what the model does not know."""
    before = replace(GOOD, pixels=False, scans=True, left=0.2, others=0.2)
    assert (
        likelihood(replace(before, change=0.4), options=OPTIONS.confidence)
        < likelihood(before, options=OPTIONS.confidence) - 0.1
    )
    assert (
        likelihood(replace(before, change=2.5), options=OPTIONS.confidence)
        < likelihood(before, options=OPTIONS.confidence) - 0.1
    )
    assert (
        likelihood(replace(before, grown=0.6), options=OPTIONS.confidence)
        < likelihood(before, options=OPTIONS.confidence) - 0.1
    )


def test_what_is_all_in_one_place_is_not_trusted() -> None:
    """Points that are the same are told from nothing else that is there."""
    for seen in (GOOD, replace(GOOD, pixels=False, scans=True)):
        assert likelihood(replace(seen, coarse=1.0), options=OPTIONS.confidence) == 0.0


def test_colours_that_always_differ_so_much_are_not_held_against_a_thing() -> None:
    dear = replace(GOOD, cost=2.4)
    assert (
        likelihood(dear, options=OPTIONS.confidence)
        < 0.9
        < likelihood(replace(dear, usual=2.4), options=OPTIONS.confidence)
    )
    assert likelihood(replace(dear, cost=4.8, usual=2.4), options=OPTIONS.confidence) == likelihood(
        dear, options=OPTIONS.confidence
    )
    assert likelihood(replace(GOOD, usual=0.5), options=OPTIONS.confidence) == likelihood(
        GOOD, options=OPTIONS.confidence
    )


def test_what_colours_usually_differ_is_learnt_where_a_thing_is_alone_in_the_air(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    learnt = []

    def noted(track: Track, *rest: Any) -> Outcome:
        before = track.usual_cost
        found = settle(track, *rest)
        given = rest[2]
        learnt.append((given is not None and given.isolated, track.usual_cost != before))
        return found

    monkeypatch.setattr(auto, "settle", noted)
    follow(scenes.juggling(5, 8))
    assert any(changed for _, changed in learnt)
    assert all(isolated for isolated, changed in learnt if changed)
