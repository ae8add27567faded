"""Pixels at the outline of a thing that stays where it is: its own, or flying, by their depth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import views

from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import OtherMovers, begin
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.scene.depth import ImageBackground
from pointbrush.tracking.scene.images import DepthNoise
from pointbrush.tracking.steps.association import Association, Associations
from pointbrush.tracking.steps.claim import claim, outline
from pointbrush.tracking.steps.grow import grow

OPTIONS = TrackerOptions()

UNIT = 0.008


@pytest.mark.parametrize("behind", [0.0, 0.03, 0.12])
def test_a_pixel_of_the_outline_is_the_things_where_it_is_as_deep(behind: float) -> None:
    view = views.shot(views.box())
    own = np.flatnonzero(view.frame.truth == 1)
    top = views.top_of(view, own)[::3]
    away = view.xyz[top] - view.eye
    far = behind * away / np.linalg.norm(away, axis=1, keepdims=True)
    views.put(view, top, view.xyz[top] + far)
    core = np.setdiff1d(own, top)
    flies, _ = outline(view, own, top, UNIT)
    _, rim = outline(view, core, top, UNIT)
    lies_behind = behind > 6.6 * UNIT
    assert (flies[np.isin(own, top)].mean() > 0.6) == lies_behind
    assert (rim.mean() > 0.6) != lies_behind
    assert flies[np.isin(own, core)].mean() < 0.03


def test_what_is_as_deep_as_others_beside_it_is_no_rim() -> None:
    view = views.shot(views.box())
    own = np.flatnonzero(view.frame.truth == 1)
    left = view.xyz[own, 0] < np.median(view.xyz[own, 0])
    _, rim = outline(view, own[left], own[~left], UNIT)
    assert rim.mean() < 0.02


@pytest.mark.parametrize("painted", [False, True])
def test_what_rests_keeps_flying_pixels_only_if_it_was_painted_with_them(painted: bool) -> None:
    view = views.shot(views.box())
    own = np.flatnonzero(view.frame.truth == 1)
    top = views.top_of(view, own)[::3]
    views.put(view, top, view.xyz[top] + 0.08 * (view.xyz[top] - view.eye))
    track = begin(view, 1, own, 0.004, OtherMovers.none())
    track.painted = replace(track.painted, with_flying=painted)
    for _ in range(OPTIONS.search.remembered_poses):
        track.motion = track.motion.add(np.eye(4))
    limits = (np.array([-0.4, 0.8, 1.2]), np.array([0.5, 1.6, 2.0]))
    around = view.box(*limits)
    place = Registration(np.eye(4), track.model.xyz, limits, around, around, around, 0.05)
    found = claim(view, own, track.model.xyz, track.model.colour, track.weight, 1.0)
    background = ImageBackground(
        OPTIONS, DepthNoise(0.004, 0.002), *np.full((2, len(view.depth)), np.nan)
    )
    free = np.ones(len(view.xyz), np.bool_)
    associations = Associations(view, background, free, {1: Association(place, found)})
    given = grow({1: track}, associations).labelled[1]
    learnt = given.points
    assert np.isin(top, found.indices).mean() > 0.8
    assert np.isin(top, learnt).mean() < 0.5
    has = np.isin(top, np.concatenate([learnt, given.rim])).mean()
    assert has > 0.8 if painted else has < 0.5


def test_what_shares_a_pixel_with_the_thing_and_lies_behind_it_is_no_rim() -> None:
    # A cloud that was moved has several points in a pixel.
    view = views.shot(views.box())
    own = np.flatnonzero(view.frame.truth == 1)
    top = views.top_of(view, own)
    back = np.flatnonzero(view.frame.truth != 1)[: len(top)]
    views.put(view, back, view.eye + 1.3 * (view.xyz[top] - view.eye))
    _, rim = outline(view, own, back, UNIT)
    assert not rim.any()
