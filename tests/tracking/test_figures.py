"""People: what hangs together is theirs, who passes keeps his own body, who was hidden is found."""

from __future__ import annotations

import pickle
from collections.abc import Callable

import numpy as np
import pytest
import scenes
from runs import follow

from pointbrush.tracking import FrameResult
from pointbrush.tracking.model.appearance import ColourHistogram
from pointbrush.tracking.model.track import OtherMovers, Track, begin
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.people.bodies import has_own_colours, reappearing_points, undisputed
from pointbrush.tracking.people.foreground import Foreground
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import Claim

OPTIONS = TrackerOptions()

STEP = 0.01
SIZE = 3 * STEP
BLUE, RED = (60, 110, 200), (190, 80, 60)
NO_RIVALS = OtherMovers.none()


def overlap(found: np.ndarray, truth: np.ndarray) -> float:
    mask = np.zeros(len(truth), np.bool_)
    mask[found] = True
    return float((mask & truth).sum() / (mask | truth).sum())


# ── whole runs ───────────────────────────────────────────────────────────────────────────────


def test_people_who_pass_keep_a_body_each(
    passing: list[scenes.Frame], followed: list[FrameResult]
) -> None:
    near, far = [], []
    for result in followed[1:]:
        truth = passing[result.frame].truth
        for label, other in ((1, 2), (2, 1)):
            points = result.assignments[label]
            assert (truth[points] == other).sum() <= 0.02 * len(points)
        near.append(overlap(result.assignments[1], truth == 1))
        far.append(overlap(result.assignments[2], truth == 2))
    assert np.mean(near) > 0.9
    assert min(far[0], far[-1]) > 0.85


def test_people_are_followed_the_same_way_twice(passing: list[scenes.Frame]) -> None:
    one, other = (
        [pickle.dumps((dict(r.assignments), dict(r.tracks))) for r in follow(passing[5:9])]
        for _ in range(2)
    )
    assert one == other


# ── what hangs together ──────────────────────────────────────────────────────────────────────


class Strip:
    """A strip 1 m long and 0.3 m wide, seen as a grid of points, coloured along x."""

    def __init__(self, colour: Callable[[np.ndarray], np.ndarray], gap: float = 0.0) -> None:
        x, y = np.meshgrid(np.arange(0, 1, STEP), np.arange(0, 0.3, STEP))
        self.x = x.ravel()
        keep = np.abs(self.x - 0.6) >= gap / 2
        self.x = self.x[keep]
        xyz = np.stack([self.x, y.ravel()[keep], np.full(len(self.x), 2.0)], axis=1)
        red = colour(self.x)[:, None]
        rgb = np.where(red, RED, BLUE).astype(np.uint8)
        view = View(0, scenes.Frame(xyz.astype(np.float32), rgb), None, options=OPTIONS)
        self.cells = Foreground.of(view, np.arange(len(xyz)), SIZE)

    def spread(
        self,
        cores: dict[int, np.ndarray],
        outside: np.ndarray | None = None,
        other: np.ndarray | None = None,
        certain: bool = True,
        far: float = 2.0,
    ) -> np.ndarray:
        none = np.zeros(len(self.x), np.bool_)
        sure = np.full(len(self.x), certain)
        nobody, others = none if outside is None else outside, none if other is None else other
        clothes = dict.fromkeys(
            cores, ColourHistogram.of(np.empty((0, 3), np.float32), OPTIONS.appearance)
        )
        longest = dict.fromkeys(cores, far)
        return self.cells.spread(cores, nobody, others, sure, longest, clothes)


def plain(x: np.ndarray) -> np.ndarray:
    return np.zeros(len(x), np.bool_)


def test_two_who_touch_part_where_their_clothes_meet() -> None:
    strip = Strip(lambda x: x > 0.3)
    label = strip.spread({4: strip.x < 0.05, 9: strip.x > 0.95})
    assert (label[strip.x < 0.3 - SIZE] == 4).all()
    assert (label[strip.x > 0.3 + SIZE] == 9).all()


def test_a_limb_that_moved_far_hangs_together_with_its_figure() -> None:
    strip = Strip(plain)
    core = {3: strip.x < 0.1}
    assert (strip.spread(core) == 3).all()
    near = strip.spread(core, far=0.4, certain=False)
    assert (near[strip.x > 0.5 + SIZE] == 0).all()


def test_the_floor_goes_with_the_floor_unless_it_is_surely_something_before_it() -> None:
    strip = Strip(plain)
    core, floor = {3: strip.x < 0.2}, strip.x > 0.6
    uncovered = strip.spread(core, outside=floor, certain=False)
    assert (uncovered[strip.x > 0.4 + SIZE] == 0).all()
    assert (uncovered[strip.x < 0.4 - SIZE] == 3).all()
    assert (strip.spread(core, outside=floor)[~floor] == 3).mean() > 0.9


def test_what_somebody_unlabelled_wears_is_not_taken() -> None:
    strip = Strip(plain)
    label = strip.spread({3: strip.x < 0.2}, other=strip.x > 0.6)
    assert (label[strip.x > 0.4 + SIZE] < 0).all()
    assert (label[strip.x < 0.4 - SIZE] == 3).all()


@pytest.mark.parametrize("alike", [True, False])
def test_a_leg_behind_the_other_is_found_by_its_colour(alike: bool) -> None:
    strip = Strip(plain if alike else lambda x: x > 0.6, gap=0.2)
    label = strip.spread({3: strip.x < 0.3})
    assert (label[strip.x < 0.5] == 3).all()
    assert (label[strip.x > 0.7 + SIZE] == (3 if alike else 0)).all()


# ── who has a body, and who comes out ────────────────────────────────────────────────────────


def thing_of(frame: scenes.Frame, number: int, label: int) -> tuple[Track, np.ndarray]:
    view = View(0, frame, find_lens(frame, options=OPTIONS), options=OPTIONS)
    points = np.flatnonzero(frame.truth == number)
    return begin(view, label, points, 0.002, NO_RIVALS), points


def claim_of(points: np.ndarray, cost: float) -> Claim:
    none = np.zeros(len(points))
    return Claim(points, np.full(len(points), cost, np.float32), none, none.astype(np.int64))


@pytest.mark.parametrize("likelier", [1, 2])
def test_a_body_that_two_want_goes_whole_to_the_likelier(
    passing: list[scenes.Frame], likelier: int
) -> None:
    tracks = {}
    for label in (1, 2):
        tracks[label], points = thing_of(passing[0], 1, label)
    assert tracks[1].large
    both = len(points) // 2
    wanted = {1: points[: both + 100], 2: points[100:]}
    claims = {n: claim_of(p, 0.004 if n == likelier else 0.008) for n, p in wanted.items()}
    result = undisputed(claims, tracks, options=OPTIONS.body)
    loser = 3 - likelier
    np.testing.assert_array_equal(result[likelier].indices, wanted[likelier])
    np.testing.assert_array_equal(
        result[loser].indices, np.setdiff1d(wanted[loser], wanted[likelier])
    )


def test_a_touch_and_small_things_are_no_dispute(passing: list[scenes.Frame]) -> None:
    one, points = thing_of(passing[0], 1, 1)
    other, _ = thing_of(passing[0], 1, 2)
    third = len(points) // 3
    touch = {1: claim_of(points[: third + 20], 0.004), 2: claim_of(points[third:], 0.008)}
    assert undisputed(touch, {1: one, 2: other}, options=OPTIONS.body) == touch
    other.unit = other.span
    same = {1: claim_of(points, 0.004), 2: claim_of(points, 0.008)}
    assert undisputed(same, {1: one, 2: other}, options=OPTIONS.body) == same


def test_who_comes_out_of_hiding_is_known_by_their_clothes(passing: list[scenes.Frame]) -> None:
    track, _ = thing_of(passing[0], 2, 2)
    track.frames_unseen = 3
    last = passing[-1]
    view = View(1, last, find_lens(last, options=OPTIONS), options=OPTIONS)
    found = reappearing_points(view, {2: track}, np.flatnonzero(last.truth > 0))[2]
    assert overlap(found, last.truth == 2) > 0.7
    assert not (last.truth[found] == 1).any()
    assert not reappearing_points(view, {2: track}, np.flatnonzero(last.truth == 1))
    assert not reappearing_points(view, {2: track}, np.empty(0, np.int64))
    assert not reappearing_points(view, {}, np.flatnonzero(last.truth > 0))


@pytest.mark.parametrize(("noise", "large"), [(0.005, True), (0.05, True), (0.2, False)])
def test_people_are_large_also_before_a_noisy_sensor(
    passing: list[scenes.Frame], noise: float, large: bool
) -> None:
    view = View(0, passing[0], find_lens(passing[0], options=OPTIONS), options=OPTIONS)
    points = np.flatnonzero(passing[0].truth == 1)
    assert begin(view, 1, points, noise, NO_RIVALS).body == large


def test_one_is_not_taken_for_another_by_what_the_other_wears(passing: list[scenes.Frame]) -> None:
    tracks = {label: thing_of(passing[0], label, label)[0] for label in (1, 2)}
    last = passing[-1]
    view = View(1, last, find_lens(last, options=OPTIONS), options=OPTIONS)
    for label in (1, 2):
        seen = np.flatnonzero(last.truth == label)
        assert has_own_colours(label, tracks, view, seen)
        assert not has_own_colours(3 - label, tracks, view, seen)


def test_what_somebody_will_uncover_is_scenery_from_the_first_frame_on() -> None:
    frames = scenes.walking(seed=5, frames=8, people=1, rate=5.0)
    missed = wrong = 0
    for result in follow(frames)[1:]:
        truth, points = frames[result.frame].truth, result.assignments[1]
        missed += int((truth == 1).sum() - (truth[points] == 1).sum())
        wrong += int((truth[points] != 1).sum())
    total = sum(int((f.truth == 1).sum()) for f in frames[1:])
    assert missed < 0.1 * total
    assert wrong < 0.05 * total


def test_people_at_five_frames_a_second_keep_their_bodies() -> None:
    frames = scenes.walking(seed=61, frames=7, people=3, rate=5.0)
    ious = [
        overlap(result.assignments.get(label, np.empty(0, np.int64)), truth == label)
        for result in follow(frames)[1:]
        for truth in [frames[result.frame].truth]
        for label in (1, 2, 3)
        if (truth == label).sum() >= 40
    ]
    assert np.mean(ious) > 0.85
