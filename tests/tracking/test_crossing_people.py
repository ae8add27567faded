"""People who cross before a camera at rest keep their points and labels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes
from runs import follow
from scipy.ndimage import minimum_filter
from staged_people import (
    OPTIONS,
    RATE,
    UP,
    crossing,
    overlap,
)

from pointbrush.tracking import FrameResult
from pointbrush.tracking.people.foreground import Foreground
from pointbrush.tracking.people.observation import PersonObservation
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.view import View


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
