"""Things in the air: painted with what flies about them, or in part; alike; in steps of depth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
import scenes

from pointbrush.tracking import METHODS, Seed, TrackOptions
from pointbrush.tracking.compute.graph import solid
from pointbrush.tracking.model.appearance import ColourHistogram
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import OtherMovers, begin
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.scene.depth import ImageBackground
from pointbrush.tracking.scene.images import DepthNoise, measure_noise
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.association import Associations, LabelledPoints
from pointbrush.tracking.steps.claim import claim
from pointbrush.tracking.steps.grow import grow, own_points
from pointbrush.tracking.steps.settle import hides

OPTIONS = TrackerOptions()

BLUE, GREEN = (40, 90, 200), (60, 160, 70)


def ious(frames: list[scenes.Frame]) -> dict[int, list[float]]:
    """Of each label of the first frame, in each frame after it."""
    first = frames[0].truth
    labels = [int(n) for n in np.unique(first) if n]
    seeds = [Seed(n, np.flatnonzero(first == n)) for n in labels]
    options = TrackOptions(continue_lost=True)
    run = METHODS["auto"]().track(
        frames.__getitem__, range(len(frames)), seeds, lambda _: None, options
    )
    result: dict[int, list[float]] = {n: [] for n in labels}
    for found in run:
        for n in labels:
            truth = frames[found.frame].truth == n
            mine = np.zeros(len(truth), bool)
            mine[found.assignments.get(n, [])] = True
            if found.frame:
                result[n].append(float((mine & truth).sum() / max(1, (mine | truth).sum())))
    return result


def club(label: int, at: np.ndarray, R: np.ndarray) -> list[scenes.Part]:
    """A bat, half a metre long."""
    along = R @ [0.0, 0.25, 0.0]
    return [
        scenes.Part(label, BLUE, at, at + along, 0.05, 0.035),
        scenes.Part(label, GREEN, at - along, at, 0.02, 0.045),
    ]


def test_flying_pixels_of_what_was_painted_are_no_part_of_it() -> None:
    rng = np.random.default_rng(1)
    pin = rng.uniform([-0.03, -0.25, 2.0], [0.03, 0.25, 2.05], (400, 3))
    flying = rng.uniform([-0.05, -0.25, 2.1], [0.05, 0.25, 5.0], (30, 3))
    kept = solid(np.concatenate([pin, flying]), 0.01, options=OPTIONS.link)
    assert kept[:400].mean() > 0.98
    assert kept[400:].mean() < 0.2
    assert solid(flying, 0.01, options=OPTIONS.link).all()  # nothing else was painted
    # Every outline of these recordings has flying pixels.
    found = ious(scenes.juggling(5, 20))
    assert min(np.mean(of) for of in found.values()) > 0.85


def test_like_things_that_start_beside_each_other_stay_apart() -> None:
    found = ious(scenes.juggling(7, 8))
    assert min(np.mean(of) for of in found.values()) > 0.6


@dataclass
class Flight:
    """A club in two frames, 0.3 m apart along x.

    Of the first its points ``painted`` (M,) are known, the ``upper`` end alone or all; in the
    second there are ``other`` parts too.
    """

    other: Sequence[scenes.Part] = ()
    upper: bool = False

    def __post_init__(self) -> None:
        rng = np.random.default_rng(2)
        camera = scenes.Camera(scenes.Sensor(320, 264, 260.0), scenes.room())
        here, there = (club(1, np.array([x, 1.4, 1.9]), np.eye(3)) for x in (0.0, 0.3))
        frames = [camera.shoot(here, rng), camera.shoot([*there, *self.other], rng)]
        lens = find_lens(frames[0], options=OPTIONS)
        self.first, self.view = (
            View(0, frames[0], lens, options=OPTIONS),
            View(1, frames[1], lens, options=OPTIONS),
        )
        unknown = np.full_like(self.first.depth, np.nan)
        noise = DepthNoise(0.004, 0.002)
        self.background = ImageBackground(OPTIONS, noise, unknown, unknown.copy())
        self.mine = np.flatnonzero(self.first.frame.truth == 1)
        self.first.labels = {1: self.mine}
        self.background.learn(self.first, first=True)
        high = self.first.xyz[self.mine, 1] > 1.4
        self.painted = self.mine[high] if self.upper else self.mine
        none = OtherMovers.none()
        self.track = begin(self.first, 1, self.painted, 0.004, none)
        pose, before, ago = np.eye(4), np.eye(4), np.eye(4)
        pose[0, 3], before[0, 3], ago[0, 3] = 0.3, -0.3, -0.6
        poses = (ago, before, np.eye(4))
        self.track.motion = replace(self.track.motion, poses=poses)
        model = self.track.model.xyz
        box = (model.min(axis=0) + [0.3, 0, 0] - 0.15, model.max(axis=0) + 0.45)
        around = self.view.box(*box)
        fit = Registration(pose, model + [0.3, 0, 0], box, around, around, around, 0.05)
        self.found = own_points(self.track, self.view, fit)
        self.core = self.found.claim

    def grown(self) -> np.ndarray:
        """New surface of the club in the second frame."""
        free = np.ones(len(self.view.xyz), np.bool_)
        found = {1: replace(self.found, claim=self.core)}
        associations = Associations(self.view, self.background, free, found)
        self.given = grow({1: self.track}, associations).labelled[1]
        return self.given.grown


def test_what_is_alone_is_taken_whole_however_little_of_it_was_known() -> None:
    flight = Flight(upper=True)
    track, first = flight.track, flight.first
    truth = flight.view.frame.truth == 1
    track.size = 0.3 * float(truth.sum())
    flight.grown()
    assert not flight.given.isolated  # what was not beside it may be another
    missed = np.setdiff1d(flight.mine, flight.painted)
    track.other_movers = OtherMovers(
        first.xyz[missed].astype(np.float64), first.colour(missed), track.weight
    )
    grown = flight.grown()
    assert flight.given.isolated
    assert truth[grown].mean() > 0.95
    assert len(grown) + len(flight.core.indices) > 0.9 * truth.sum()


def rivals_of(flight: Flight, view: View, points: np.ndarray, *, beside: bool) -> OtherMovers:
    """Points of a frame as known to be unlabelled, looked for there alone or everywhere."""
    xyz = view.xyz[points].astype(np.float64)
    box = (xyz.min(axis=0), xyz.max(axis=0)) if beside else None
    return OtherMovers(xyz, view.colour(points), flight.track.weight, box)


@pytest.mark.parametrize(
    ("has_colour_key", "beside", "isolated"),
    [
        (False, True, False),
        (False, False, True),  # most of it was not there, though it was looked for
        (True, True, True),  # its colours are known
    ],
)
def test_an_arm_that_goes_on_beyond_where_it_was_looked_for_is_no_part_of_what_has_no_colours(
    has_colour_key: bool, beside: bool, isolated: bool
) -> None:
    flight = Flight(upper=True)
    track, view = flight.track, flight.view
    track.size = float((view.frame.truth == 1).sum())
    track.weight *= has_colour_key
    rest = np.setdiff1d(np.flatnonzero(view.frame.truth == 1), flight.core.indices)
    near = rest[view.xyz[rest, 1] > np.quantile(view.xyz[rest, 1], 0.6)]
    track.other_movers = rivals_of(flight, view, near, beside=beside)
    flight.grown()
    assert flight.given.isolated == isolated


@pytest.mark.parametrize(
    ("held", "frames_alone", "whole"),
    [
        (False, 0, True),
        (True, 0, False),  # a hand hardly turns: it was there in the last frame too
        (False, OPTIONS.growth.known_frames, False),  # its length is known
    ],
)
def test_a_thing_painted_end_on_gets_its_length_once_that_shows(
    held: bool, frames_alone: int, whole: bool
) -> None:
    flight = Flight(upper=True)
    track, view, own = flight.track, flight.view, flight.core.indices
    truth = np.flatnonzero(view.frame.truth == 1)
    flight.core = flight.core.pick(view.xyz[own, 1] > np.quantile(view.xyz[own, 1], 0.3))
    track.size, track.frames_alone = 0.3 * len(truth), frames_alone
    # Its end shows the colours of all of it; a hand has others.
    track.appearance = ColourHistogram.of(view.colour(truth), OPTIONS.appearance)
    if held:
        missed = np.setdiff1d(truth, flight.core.indices)
        track.other_movers = rivals_of(flight, view, missed, beside=False)
    grown = flight.grown()
    assert flight.given.end_on == flight.given.isolated == whole
    assert (len(grown) + len(flight.core.indices) > 0.9 * len(truth)) == whole


def test_a_hand_that_catches_a_thing_is_not_its_though_its_arm_is_hidden() -> None:
    at = np.array([0.3, 1.2, 1.87])
    beside, wrist = at + [0.05, 0, 0], at + [0.07, 0, -0.2]
    board = scenes.Part(0, (90, 90, 90), wrist, np.array([0.03, 0.2, 0.02]), rot=np.eye(3))
    for colour, hand in (((210, 160, 130), True), (GREEN, False)):
        grip = scenes.Part(0, colour, at, beside, 0.04, 0.04)
        flight = Flight([grip, board])
        grown = flight.grown()
        assert (len(grown) < 10) == hand


def test_another_side_of_a_thing_in_colours_of_its_own_does_not_hide_it() -> None:
    rng = np.random.default_rng(3)
    camera = scenes.Camera(scenes.Sensor(320, 264, 260.0), scenes.room())
    parts = club(1, np.array([0.0, 1.4, 1.9]), np.eye(3))
    parts[1].label = 2
    hand = scenes.Part(3, (210, 160, 130), np.array([0.3, 1.4, 1.9]), np.array([0.4, 1.4, 1.9]))
    hand.ra = hand.rb = 0.05
    frame = camera.shoot([*parts, hand], rng)
    view = View(0, frame, find_lens(frame, options=OPTIONS), options=OPTIONS)
    painted, turned, skin = (np.flatnonzero(frame.truth == label) for label in (1, 2, 3))
    none = OtherMovers.none()
    track = begin(view, 1, painted, 0.004, none)
    both = begin(view, 1, np.concatenate([painted, turned]), 0.004, none).model

    def taken_for_another(points: np.ndarray, isolated: bool = False) -> bool:
        xyz, colour = view.xyz[points].astype(float), view.colour(points)
        found = claim(view, points, xyz, colour, track.weight, 0.1)
        box = (xyz.min(0), xyz.max(0))
        place = Registration(np.eye(4), xyz, box, points, points, points, cost=0.3)
        return hides(track, view, place, LabelledPoints(found, isolated=isolated), 0.0)

    assert taken_for_another(turned)
    assert taken_for_another(skin)
    assert not taken_for_another(turned, isolated=True)  # alone in the air
    track.model = both
    both.hits[:] = OPTIONS.surface.sure_hits
    assert not taken_for_another(turned)
    assert taken_for_another(skin)


def test_noise_of_depth_that_comes_in_steps_is_a_step() -> None:
    rng = np.random.default_rng(4)
    true = np.sort(rng.uniform(1.0, 5.5, 40_000))

    def image() -> np.ndarray:
        disparity = 580 * 0.075 / true + rng.normal(0, 0.04, len(true))
        return (580 * 0.075 / (np.round(disparity * 8) / 8)).astype(np.float32)

    waver = measure_noise(image(), image(), options=OPTIONS.noise)
    for depth in (2.0, 5.0):
        step = depth**2 / (8 * 580 * 0.075)
        assert step < OPTIONS.background.near_sigmas * float(waver(np.float32(depth))) < 2.5 * step
    # Without steps nothing has changed.
    smooth = [(true + rng.normal(0, 0.01, len(true))).astype(np.float32) for _ in range(2)]
    assert 0.008 < float(measure_noise(*smooth, options=OPTIONS.noise)(np.float32(3.0))) < 0.012
