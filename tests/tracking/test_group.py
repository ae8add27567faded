"""People before a camera at rest, followed together with those whom nobody labelled."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
import scenes
from runs import follow
from scipy.ndimage import minimum_filter
from views import shot

from pointbrush.tracking import FrameResult, Seed, TrackOptions
from pointbrush.tracking.compute.graph import Paths, agreed, paths_into
from pointbrush.tracking.model.appearance import ColourHistogram
from pointbrush.tracking.model.motion import Motion
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.people.arrivals import come_back, exchange, exchanged, mistakable
from pointbrush.tracking.people.foreground import Foreground
from pointbrush.tracking.people.group import Group, JointTracking, astray, cell_size, outcome
from pointbrush.tracking.people.observation import PersonObservation
from pointbrush.tracking.people.person import Person, PersonEvidence
from pointbrush.tracking.people.stature import across, upright
from pointbrush.tracking.scene.depth import ImageBackground
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.settle import Outcome
from pointbrush.tracking.tracker import Run

OPTIONS = TrackerOptions()

RATE = 5.0
SURE = PersonEvidence(
    fit=0.5,
    disputed=0.0,
    size=0.9,
    change=1.0,
    shown=0.9,
    like=0.0,
    back=False,
    touching=0.0,
    wider=0.0,
    astray=0.0,
)


def overlap(found: np.ndarray, truth: np.ndarray) -> float:
    mask = np.zeros(len(truth), np.bool_)
    mask[found] = True
    return float((mask & truth).sum() / (mask | truth).sum())


def crossing(stranger: bool, frames: int = 12, *, ball: bool = False) -> list[scenes.Frame]:
    """1 and 2 cross, one behind the other, five frames a second; a third comes in later.

    ``ball``: there is a ball on the floor too, 3.
    """
    rng = np.random.default_rng(7)
    sensor = scenes.Sensor(192, 168, 130.0, origin=np.array([0.0, 1.3, 0.0]))
    camera = scenes.Camera(sensor, scenes.room())
    made = []
    for i in range(frames):
        t = i / RATE
        one, two = np.array([1.1 * t - 1.1, 0, 2.4]), np.array([1.2 - 1.1 * t, 0, 3.2])
        parts = scenes.person(1, one, np.pi / 2, 7.0 * t, (60, 110, 200))
        parts += scenes.person(2, two, -np.pi / 2, 7.0 * t + 1, (190, 80, 60))
        if stranger:
            three = np.array([3.2 - 1.4 * t, 0, 2.8])
            parts += scenes.person(3, three, -np.pi / 2, 8.0 * t + 2, (70, 160, 80))
        if ball:
            at = np.array([0.7, 0.08, 2.8])
            parts.append(scenes.Part(3, (220, 190, 60), at, at + 1e-3, 0.08, 0.08))
        made.append(camera.shoot(parts, rng))
    return made


@pytest.fixture(scope="module", params=[False, True], ids=["alone", "stranger"])
def colourless(request: pytest.FixtureRequest) -> list[scenes.Frame]:
    return [replace(frame, rgb=None) for frame in crossing(request.param)]


@pytest.fixture(scope="module")
def found(colourless: list[scenes.Frame]) -> list[FrameResult]:
    return follow(colourless)


def test_people_who_cross_keep_their_labels_without_colour(
    colourless: list[scenes.Frame], found: list[FrameResult]
) -> None:
    for label in (1, 2):
        truths = [colourless[result.frame].truth == label for result in found]
        shares = [
            overlap(result.assignments[label], truth)
            for result, truth in zip(found, truths, strict=True)
            if truth.sum() > 300 and label in result.assignments
        ]
        assert len(shares) >= len(found) - 3
        assert np.mean(shares) > 0.85


def test_people_are_followed_together_beside_a_small_thing() -> None:
    frames = [replace(frame, rgb=None) for frame in crossing(stranger=False, ball=True)]
    shares = {
        label: [
            overlap(result.assignments[label], frames[result.frame].truth == label)
            for result in follow(frames)[1:]
        ]
        for label in (1, 2, 3)
    }
    assert np.mean(shares[1] + shares[2]) > 0.95
    assert np.mean(shares[3]) > 0.9


def test_no_label_goes_over_to_a_stranger(
    colourless: list[scenes.Frame], found: list[FrameResult]
) -> None:
    for result in found:
        strange = colourless[result.frame].truth == 3
        for points in result.assignments.values():
            assert strange[points].sum() <= 0.1 * len(points)


def test_what_they_hold_and_they_share_the_points_where_they_touch() -> None:
    rng = np.random.default_rng(3)
    sensor = scenes.Sensor(192, 168, 160.0, origin=np.array([0.0, 1.3, 0.0]))
    camera = scenes.Camera(sensor, scenes.room())
    frames = []
    for i in range(12):
        at = np.array([0.06 * i - 0.35, 0, 2.0])
        held = at + np.array([0.06 * np.sin(0.5 * i), 1.15 + 0.1 * np.cos(0.5 * i), -0.4])
        hands = [held + np.array([side, 0, 0.06]) for side in (0.1, -0.1)]
        parts = scenes.person(1, at, np.pi, 2.0 * i / RATE, (60, 110, 200), arms=hands)
        ball = scenes.Part(2, (220, 190, 60), held, held + 1e-3, 0.1, 0.1)
        frames.append(camera.shoot([*parts, ball], rng))
    for result in follow(frames)[1:]:
        truth = frames[result.frame].truth
        assert overlap(result.assignments[2], truth == 2) > 0.88
        assert overlap(result.assignments[1], truth == 1) > 0.85


def outlined(frame: scenes.Frame, painted: bool) -> tuple[scenes.Frame, np.ndarray]:
    """Every fifth pixel at the outlines lies 30 cm behind, as its truth if ``painted``; and which
    those are."""
    lens = find_lens(frame, options=OPTIONS)
    assert lens is not None
    assert frame.truth is not None
    cell = lens.cells(frame.xyz, options=OPTIONS.lens)[0]
    image = np.zeros(lens.shape, np.bool_)
    image.ravel()[cell] = frame.truth > 0
    rim = (image & ~minimum_filter(image, 3)).ravel()[cell]
    mixed = rim & (np.random.default_rng(1).random(len(cell)) < 0.2)
    xyz, truth = frame.xyz.copy(), frame.truth.copy()
    away = xyz[mixed] - lens.eye
    xyz[mixed] += 0.3 * away / np.linalg.norm(away, axis=1, keepdims=True)
    truth[mixed] = frame.truth[mixed] if painted else 0
    return replace(frame, xyz=xyz.astype(np.float32), truth=truth), mixed


@pytest.mark.parametrize("painted", [False, True])
def test_flying_pixels_are_somebodys_where_he_was_painted_with_them(painted: bool) -> None:
    made = [outlined(frame, painted) for frame in crossing(stranger=False, frames=4)]
    shares = []
    for result in follow([frame for frame, _ in made])[1:]:
        found = np.concatenate(list(result.assignments.values()))
        shares.append(np.isin(np.flatnonzero(made[result.frame][1]), found).mean())
    assert np.mean(shares) > 0.75 if painted else np.mean(shares) < 0.4


def test_a_flying_pixel_between_two_people_is_one_of_theirs() -> None:
    frame = crossing(stranger=False, frames=1)[0]
    view = View(0, frame, find_lens(frame, options=OPTIONS), options=OPTIONS)
    assert frame.truth is not None
    left, right = np.array_split(np.flatnonzero(frame.truth == 1), 2)
    both = np.flatnonzero((view.around(left) & view.around(right))[view.cells[0]])
    cells = Foreground.of(view, np.setdiff1d(np.concatenate([left, right]), both), 0.1)
    observation = PersonObservation(view, cells, np.eye(3)[:, [0, 2]], UP, both)
    assert np.array_equal(observation.take_flying(left), both)
    assert not len(observation.take_flying(right))


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
    person = Person.met(OPTIONS, 1, middle, middle.astype(np.float32), 0)
    person.frames_unseen = 1
    person.follow(cast(PersonObservation, observation), np.zeros(3), 1)
    assert len(person.xyz) == 5


UP = np.array([0.0, -1.0, 0.0])
RED, BLUE = np.array([0.4, 0.0, 0.5], np.float32), np.array([-0.4, 0.1, 0.5], np.float32)


def body(right: float, colour: np.ndarray, tall: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Middles (30, 3) of cells 0.1 m apart, three metres away, and their colours."""
    across, down = np.meshgrid(np.arange(3) / 10, np.arange(10) / 10 - tall)
    middle = np.stack([right + across.ravel(), down.ravel(), np.full(30, 3.0)], axis=1)
    return middle, np.tile(colour, (30, 1))


def staged(*bodies: tuple[np.ndarray, np.ndarray], coloured: bool = True) -> PersonObservation:
    """The bodies, five points in each cell."""
    middle, colour = (np.vstack(each) for each in zip(*bodies, strict=True))
    many = np.full(len(middle), 5)
    cell = np.repeat(np.arange(len(middle)), 5)
    cells = Foreground(OPTIONS, np.arange(len(cell)), cell, many, middle, colour, 0.1, many)
    view = SimpleNamespace(
        options=OPTIONS,
        frame=SimpleNamespace(rgb=True if coloured else None),
        xyz=middle[cell],
        cells=SimpleNamespace(cell=np.append(np.full(len(cell), 50), [0, 99])),
        camera=SimpleNamespace(shape=(1, 100)),
        colour=lambda points: colour[cell[points]],
        depth=np.full(1, np.inf),
        project=lambda xyz: (np.zeros(len(xyz), np.int64), xyz[:, 2]),
        hides=lambda xyz, _: np.zeros(len(xyz), np.bool_),
    )
    return PersonObservation(cast(View, view), cells, np.eye(3)[:, [0, 2]], UP, cell[:0])


def somebody(label: int, right: float, colour: np.ndarray, well: int) -> Person:
    middle, tints = body(right, colour)
    person = Person.met(
        OPTIONS, label, middle, tints, 0, ColourHistogram.of(tints, OPTIONS.appearance)
    )
    person.well, person.area = well, 30 * 5 * 9.0
    return person


def test_who_was_not_met_where_he_was_expected_is_missing_in_the_same_frame() -> None:
    near, gone = somebody(1, 0.0, RED, well=9), somebody(2, 1.0, RED, well=2)
    observation = staged(body(0.1, RED))
    come_back(observation, [near, gone], 30, now=10)
    assert np.all(observation.owner == 1)


def test_who_is_missing_is_looked_for_in_what_another_has_by_clothes() -> None:
    both, gone = somebody(1, 0.0, RED, well=9), somebody(2, 0.3, BLUE, well=5)
    observation = staged(body(0.0, RED), body(0.3, BLUE))
    observation.owner[:] = 1
    come_back(observation, [both, gone], 30, now=10)
    assert np.mean(observation.owner[:30] == 1) > 0.6
    assert np.all(observation.owner[33:] == 2)


@pytest.mark.parametrize(("wear", "doubted"), [(RED, True), (BLUE, False)])
def test_who_is_found_where_another_dressed_alike_is_missing_is_doubted(
    wear: np.ndarray, doubted: bool
) -> None:
    found, gone = somebody(1, 0.0, RED, well=5), somebody(2, 0.2, wear, well=5)
    found.frames_unseen = gone.frames_unseen = 4
    observation = staged(body(0.1, RED))
    observation.owner[:] = 1
    assert (mistakable(observation, [found, gone], found, 10) == [gone]) == doubted
    group = Group(OPTIONS, [found, gone], 0.1, 0.01, observation.flat, UP, 30.0, 10)
    group.doubt(observation, found, SURE)
    assert found.identity.doubts == ({2} if doubted else set())
    assert gone.identity.doubts == ({1} if doubted else set())
    # The other is found elsewhere: in clothes that both wear, either may still be either.
    found.frames_unseen, gone.well = 0, 10
    observation.owner[15:] = 2
    group.doubt(observation, found, SURE)
    assert bool(found.identity.doubts) == doubted
    # Painted anew, or looked for no more, the other is not he.
    group.drop(2)
    assert not found.identity.doubts


def test_doubts_end_when_clothes_tell() -> None:
    one, two = somebody(1, 0.0, RED, well=10), somebody(2, 1.0, BLUE, well=10)
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
    person = somebody(1, 0.0, BLUE, well=10)
    person.identity.colours, person.identity.shown = legs[1], 30 * 5 * 9.0
    if doubted:
        person.doubt(somebody(2, 1.0, RED, well=5))
    observation = staged(legs, shirt)
    observation.owner[:] = 1
    assert person.likeness(shirt[1]) < -OPTIONS.body.unlike_log
    group = Group(OPTIONS, [person], 0.1, 0.01, observation.flat, UP, 30.0, 10)
    group.doubt(observation, person, replace(SURE, touching=touching))
    assert (person.likeness(shirt[1]) > -0.3) == told
    assert person.likeness(legs[1]) > -0.3


def test_who_has_two_bodies_is_doubted_while_another_is_missing() -> None:
    both, gone = somebody(1, 0.0, RED, well=9), somebody(2, 0.3, RED, well=5)
    group = Group(OPTIONS, [both, gone], 0.1, 0.01, np.eye(3)[:, [0, 2]], UP, 30.0, 10)
    observation = staged(body(0.0, RED), body(0.3, RED))
    observation.owner[:30] = 1
    group.doubt(observation, both, replace(SURE, size=1.0))
    assert not both.identity.doubts
    observation.owner[:] = 1
    group.doubt(observation, both, replace(SURE, size=2.0))
    assert both.identity.doubts
    assert gone.identity.doubts


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


def test_who_is_where_another_was_expected_is_astray() -> None:
    observation = staged(body(0.0, RED))
    here, beside = np.array([0.1, 3.0]), np.array([0.6, 3.0])
    cells = np.arange(30)
    assert astray(observation, 1, cells, {1: here, 2: beside}) < -1
    assert astray(observation, 1, cells, {1: beside, 2: here}) > 1
    assert astray(observation, 1, cells, {1: here}) < -2


@pytest.mark.parametrize(("noise", "size"), [(0.002, 0.04), (0.01, 0.045), (0.05, 0.09)])
def test_cells_are_as_large_as_noise_asks_but_no_larger_than_limbs(
    noise: float, size: float
) -> None:
    view = SimpleNamespace(options=OPTIONS, cells=(None, np.full(5, 3.0)), labels={1: np.arange(5)})
    track = SimpleNamespace(options=OPTIONS, label=1, unit=0.01, span=0.9)
    background = SimpleNamespace(noise=lambda depth: np.full(len(depth), noise))
    found = cell_size(cast(View, view), cast(Track, track), cast(ImageBackground, background))
    assert found == pytest.approx(size, rel=0.02)


def test_somebody_has_gone_where_he_is_elsewhere_along_the_ground() -> None:
    observation = staged(body(0.0, RED))
    person = somebody(1, 0.0, RED, 0)
    observation.owner[:] = 1
    stride = 0.2 * observation.flat[:, 0]
    for now in range(3):
        person.follow(observation, observation.up, now)
    assert person.gone() is None
    for now in range(3, 6):
        person.follow(observation, stride, now)
    assert person.gone() == (3, pytest.approx(0.6))


def test_what_somebody_leaves_behind_is_made_scenery() -> None:
    observation = staged(body(0.0, RED))
    told: list[tuple[int, int, float]] = []
    background = SimpleNamespace(left_behind=lambda *what: told.append(what))
    people = [somebody(label, 0.0, RED, 0) for label in (1, 2, -1)]
    for person, stride in zip(people, (0.3, 0.1, 0.3), strict=True):
        person.ways.extend(np.array([stride * i, 0.0]) for i in range(4))
    group = Group(OPTIONS, people, 0.1, 0.01, observation.flat, observation.up, 30.0)
    group.leave_behind(cast(ImageBackground, background))
    assert told == [(1, 2, pytest.approx(0.6))]


def test_what_shows_of_who_is_all_but_hidden_is_his() -> None:
    person = somebody(1, 0.0, RED, well=9)
    observation = staged(body(0.0, RED))
    observation.owner[:2] = 1
    person.follow(observation, np.zeros(3), 10)
    assert person.frames_unseen == 1
    found = outcome(observation, person, None)
    track, points = found.state, found.points
    assert track.state == "occluded"
    assert np.all(observation.owner[observation.cells.cell[points]] == 1)
    assert len(points) > 0


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
        assert person.elsewhere(scraps, 1)


def test_scraps_are_not_where_somebody_was_well_seen() -> None:
    person = somebody(1, 0.0, RED, well=4)
    observation = staged(body(2.0, RED), body(0.2, RED))
    # One point in a cell, of a few that lie elsewhere, is hardly anything of him.
    observation.cells.count[:30] = 1
    observation.owner[:10] = 1
    person.follow(observation, np.array([2.0, 0.0, 0.0]), 9)
    assert person.well == 4
    come_back(observation, [person], 30, now=10)
    assert np.all(observation.owner[30:] == 1)


@pytest.mark.parametrize(("right", "cut"), [(-1.1, True), (0.0, False), (1.1, True)])
def test_who_touches_a_side_of_what_was_measured_may_leave_there(right: float, cut: bool) -> None:
    at, size = np.array([right, 1.2, 1.6]), np.array([0.4, 0.5, 0.1])
    view = shot(scenes.Part(1, (40, 90, 200), at, size, rot=np.eye(3)))
    cells = Foreground.of(view, np.flatnonzero(view.frame.truth == 1), 0.1)
    observation = PersonObservation(view, cells, np.eye(3)[:, [0, 2]], UP, np.empty(0, np.int64))
    assert observation.at_side(np.arange(len(cells.count))) == cut


@pytest.mark.parametrize(("tops", "back"), [([1.7, 1.71], False), ([1.7, 1.71, 1.69], True)])
@pytest.mark.parametrize("tall", [1.7, 1.8])
def test_a_newcomer_is_a_person_who_left_only_once_stature_tells(
    tops: list[float], back: bool, tall: float
) -> None:
    person, newcomer = somebody(1, 0.0, RED, well=4), somebody(-1, 0.3, RED, well=9)
    person.at_side, person.frames_unseen, newcomer.since = True, 5, 8
    person.identity.stature.tops, newcomer.identity.stature.tops = [tall] * 3, tops
    observation = staged(body(0.3, RED))
    observation.owner[:] = -1
    come_back(observation, [person, newcomer], 30, now=10)
    returned = back and tall == 1.7
    assert np.all(observation.owner == (1 if returned else -1))
    if returned:
        person.follow(observation, np.zeros(3), 10)
        person.identity.confidence = 1.0
        state = outcome(observation, person, SURE).state
        assert state.confidence <= OPTIONS.body.doubted_confidence


@pytest.mark.parametrize(("wear", "told"), [(BLUE, True), (RED, False)])
def test_who_changed_places_are_changed_back_when_their_clothes_tell(
    wear: np.ndarray, told: bool
) -> None:
    one, two = somebody(1, 0.0, RED, well=9), somebody(2, 1.0, wear, well=9)
    one.went = np.array([0.5, 0.0, 0.0])
    observation = staged(body(0.0, wear), body(1.0, RED))
    observation.owner[:] = np.repeat([1, 2], 30)
    for now in range(10, 10 + OPTIONS.arrivals.exchange_frames):
        assert observation.owner[0] == 1
        assert bool(one.identity.doubts) == (told and now > 10)
        one.well = two.well = now - 1
        exchange(observation, [one, two], now)
    assert observation.owner[[0, 30]].tolist() == ([2, 1] if told else [1, 2])
    assert one.label == (2 if told else 1)
    him = two if told else one
    np.testing.assert_allclose(him.went, [1.5 if told else 0.5, 0.0, 0.0], atol=1e-9)


def as_tall(label: int, right: float, tall: float) -> Person:
    person = somebody(label, right, RED, well=9)
    person.identity.stature.tops = [tall, tall]
    return person


@pytest.mark.parametrize(("other", "told"), [(0.2, True), (0.01, False)])
def test_who_changed_places_are_changed_back_when_their_statures_tell(
    other: float, told: bool
) -> None:
    one, two = as_tall(1, 0.0, 0.0), as_tall(2, 1.0, other)
    observation = staged(body(0.0, RED, other), body(1.0, RED, 0.0), coloured=False)
    observation.owner[:] = np.repeat([1, 2], 30)
    exchange(observation, [one, two], 10)
    assert observation.owner[[0, 30]].tolist() == ([2, 1] if told else [1, 2])
    assert one.identity.stature.tops[0] == (other if told else 0.0)


@pytest.mark.parametrize("doubted", [True, False])
def test_who_is_doubted_and_as_tall_as_somebody_new_without_a_label_is_he(doubted: bool) -> None:
    one, stranger = as_tall(1, 0.0, 0.3), somebody(-1, 1.0, RED, well=9)
    one.identity.doubts = {2} if doubted else set()
    one.identity.sure, stranger.since = 4, 6
    observation = staged(body(0.0, RED, 0.0), body(1.0, RED, 0.3), coloured=False)
    observation.owner[:] = np.repeat([1, -1], 30)
    for now in range(10, 10 + OPTIONS.arrivals.exchange_frames):
        one.well = stranger.well = now
        exchange(observation, [one, stranger], now)
    assert observation.owner[[0, 30]].tolist() == ([-1, 1] if doubted else [1, -1])
    # Who was there while he was surely himself is not he.
    one.identity.sure = 8
    assert not list(exchanged(observation, [one, stranger], 10))


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


def test_of_two_who_are_missing_the_one_who_is_as_tall_has_come_back() -> None:
    gone = [as_tall(1, 0.05, 0.0), as_tall(2, 0.1, 0.2)]
    for person in gone:
        person.well = 5
    observation = staged(body(0.0, RED, 0.2), coloured=False)
    come_back(observation, gone, 30, now=10)
    assert np.all(observation.owner == 2)


@pytest.mark.parametrize("touching", [False, True])
def test_of_two_bodies_that_one_has_each_is_whose_stature_it_has(touching: bool) -> None:
    both, gone = as_tall(1, 0.0, 0.0), as_tall(2, 0.0, 0.2)
    gone.well = 5
    hands = np.stack([np.linspace(0.3, 0.5, 3), np.full(3, 0.5), np.full(3, 3.0)], axis=1)
    between = [(hands, np.tile(RED, (3, 1)))] if touching else []
    observation = staged(body(0.0, RED, 0.2), body(0.6, RED), *between, coloured=False)
    observation.owner[:] = 1
    come_back(observation, [both, gone], 30, now=10)
    assert observation.owner[[0, 30]].tolist() == [2, 1]
    assert both.identity.doubts == {2}
    assert gone.identity.doubts == {1}


def test_a_raised_arm_is_nobody_elses() -> None:
    both, gone = as_tall(1, 0.0, 0.0), as_tall(2, 0.0, 0.2)
    gone.well = 5
    arm = np.stack([np.linspace(0.3, 0.7, 5), np.linspace(0.3, -0.1, 5), np.full(5, 3.0)], axis=1)
    observation = staged(body(0.0, RED), (arm, np.tile(RED, (5, 1))), coloured=False)
    observation.owner[:] = 1
    come_back(observation, [both, gone], 30, now=10)
    assert np.all(observation.owner == 1)


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


def test_ways_lead_into_what_is_sought_alone() -> None:
    links, length = np.array([[0, 1], [1, 2], [0, 3]]), np.array([1.0, 2.0, 3.0])
    ways = paths_into(links, length, np.array([True, True, False, False]))
    assert ways.start.tolist() == [0, 1, 2, 3, 4]
    assert ways.end.tolist() == [1, 0, 1, 0]
    assert ways.length.tolist() == [1.0, 1.0, 2.0, 3.0]


@pytest.mark.parametrize(("confidence", "along"), [(0.9, True), (0.1, False)])
def test_what_somebody_carries_goes_along_with_them_while_it_is_hidden(
    confidence: float, along: bool
) -> None:
    bearer = somebody(2, 0.0, RED, well=9)
    view = cast(View, SimpleNamespace(xyz=np.vstack([bearer.xyz, bearer.xyz]).astype(np.float32)))
    bag = SimpleNamespace(
        label=1, unit=0.01, confidence=confidence, away=True, carrier=None, size=9.0,
        motion=Motion(OPTIONS.search, np.median(bearer.xyz, axis=0)),
    )  # fmt: skip
    tracking = JointTracking(cast(dict[int, Track], {1: bag}), OPTIONS, continue_lost=False)
    tracking.group = Group(OPTIONS, [bearer], 0.1, 0.01, np.eye(3)[:, [0, 2]], UP, 30.0)
    own, theirs = np.split(np.arange(len(view.xyz)), 2)
    seen, hidden = (
        SimpleNamespace(state=SimpleNamespace(state=state), points=points)
        for state, points in (("tracked", own), ("occluded", own[:0]))
    )
    person = SimpleNamespace(state=SimpleNamespace(state="tracked"), points=theirs)
    before = bag.motion.place
    tracking.carry(view, cast(dict[int, Outcome], {1: seen, 2: person}))
    bearer.xyz = bearer.xyz + [0.4, 0.0, 0.1]
    tracking.carry(view, cast(dict[int, Outcome], {1: hidden, 2: person}))
    assert np.allclose(bag.motion.place - before, np.multiply([0.4, 0.0, 0.1], along))
