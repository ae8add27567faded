"""What is no surface of a thing though it moves along: flying pixels, and hands behind it."""

from __future__ import annotations

import numpy as np
import pytest
import scenes
import views
from scipy.spatial.transform import Rotation

from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import OtherMovers, begin
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.scene.depth import ImageBackground
from pointbrush.tracking.scene.images import DepthNoise
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.association import Association, Associations
from pointbrush.tracking.steps.claim import claim, flying
from pointbrush.tracking.steps.grow import grow

OPTIONS = TrackerOptions()

SKIN, UNIT = (210, 160, 130), 0.01


def test_pixels_that_lie_alone_behind_an_outline_are_flying() -> None:
    view = views.shot(views.box())
    own = np.flatnonzero(view.frame.truth == 1)
    top = views.top_of(view, own)
    rest = np.setdiff1d(own, top)
    assert flying(view, own, UNIT).mean() < 0.03
    moved = top[::3]
    views.put(view, moved, view.xyz[moved] + 0.04 * (view.xyz[moved] - view.eye))  # 6 cm
    assert flying(view, top[::3], UNIT).sum() == 0  # nothing of the thing is before them
    found = own[flying(view, own, UNIT)]
    assert np.isin(top[::3], found).mean() > 0.6
    assert np.isin(rest, found).mean() < 0.03


def test_where_pixels_hold_several_points_none_is_taken_to_be_flying() -> None:
    view = views.shot(views.box())
    own = np.flatnonzero(view.frame.truth == 1)
    top = views.top_of(view, own)[::3]
    views.put(view, top, view.xyz[top] + 0.04 * (view.xyz[top] - view.eye))
    turn = Rotation.from_euler("xyz", (0.2, 0.3, 0.1)).as_matrix()
    view.frame.xyz[:] = view.frame.xyz @ turn.T
    lens = find_lens(view.frame, options=OPTIONS)
    assert lens is not None
    assert not lens.lattice
    assert not flying(View(1, view.frame, lens, options=OPTIONS), own, UNIT).any()


@pytest.mark.parametrize(("colour", "taken"), [(views.BLUE, True), (SKIN, False)])
def test_a_hand_that_goes_along_behind_a_thing_is_no_new_side_of_it(
    colour: tuple[int, int, int], taken: bool
) -> None:
    post = scenes.Part(
        1, views.BLUE, np.array([0, 1.08, 1.6]), np.array([0, 1.32, 1.6]), 0.07, 0.07
    )
    size, at = np.array([0.03, 0.06, 0.02]), np.array([0.08, 1.2, 1.61])
    view = views.shot(post, scenes.Part(2, colour, at, size, rot=np.eye(3)))
    core, beside = (np.flatnonzero(view.frame.truth == label) for label in (1, 2))
    step = np.eye(4)
    step[:3, 3] = [0.15, 0.0, 0.0]  # farther than what is where it was may be
    hand = view.xyz[beside].astype(np.float64) - step[:3, 3]
    track = begin(view, 1, core, 0.004, OtherMovers(np.empty((0, 3)), view.colour(beside[:0])))
    track.other_movers = OtherMovers(hand, view.colour(beside), track.weight)
    track.model.xyz -= step[:3, 3]
    track.size = 1.2 * len(core)
    box = (np.array([-0.4, 0.8, 1.2]), np.array([0.5, 1.6, 1.9]))
    around = view.box(*box)
    world = track.model.xyz + step[:3, 3]
    place = Registration(step, world, box, around, around, around, 0.05)
    own = claim(view, core, world, track.model.colour, track.weight, 0.05)
    unknown = np.full_like(view.depth, np.nan)
    still = ImageBackground(OPTIONS, DepthNoise(0.004, 0.002), unknown, unknown.copy())
    free = np.ones(len(view.xyz), np.bool_)
    found = Associations(view, still, free, {1: Association(place, own)})
    grown = grow({1: track}, found).labelled[1].grown
    assert np.isin(beside, grown).mean() > 0.8 if taken else not len(grown)
