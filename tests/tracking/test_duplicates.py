"""Frames in which points occur several times: dual returns, clouds merged with themselves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import scenes

from pointbrush.tracking import METHODS, FrameKnowledge, FrameResult, Seed, TrackOptions
from pointbrush.tracking.duplicates import Copies
from pointbrush.tracking.interface import PAINTED


def box(rng: np.random.Generator, centre: list[float], size: list[float], count: int) -> np.ndarray:
    points = rng.uniform(-0.5, 0.5, (count, 3))
    points[np.arange(count), rng.integers(0, 3, count)] = rng.choice([-0.5, 0.5], count)
    return points * size + centre


def room(number: int) -> scenes.Frame:
    """A floor and a wall, box 1 that moves by 5 cm a frame and box 2 that stands."""
    rng = np.random.default_rng(number)
    floor = np.c_[rng.uniform(-2, 2, (3000, 2)), rng.normal(0, 0.003, 3000)]
    wall = [rng.uniform(-2, 2, 1200), 2 + rng.normal(0, 0.003, 1200), rng.uniform(0, 2, 1200)]
    moving = box(rng, [-0.4 + 0.05 * number, 0, 0.3], [0.3, 0.25, 0.4], 700)
    standing = box(rng, [-1, 1, 0.25], [0.5, 0.5, 0.5], 600)
    truth = np.repeat([0, 1, 2], [4200, 700, 600])
    colour = np.array([[150, 150, 150], [200, 60, 40], [40, 160, 60]])[truth]
    rgb = np.clip(colour + rng.integers(-8, 8, colour.shape), 0, 255).astype(np.uint8)
    xyz = np.concatenate([floor, np.stack(wall, axis=1), moving, standing]).astype(np.float32)
    return scenes.Frame(xyz, rgb, truth, None)


def each_twice(truth: np.ndarray) -> np.ndarray:
    return np.full(len(truth), 2)


def dual_returns(truth: np.ndarray) -> np.ndarray:
    return 1 + (np.random.default_rng(5).random(len(truth)) < 0.7).astype(int)


def one_object_thrice(truth: np.ndarray) -> np.ndarray:
    return np.where(truth == 1, 3, 1)


def repeated(frame: scenes.Frame, times: np.ndarray) -> scenes.Frame:
    """The copies of a point are not beside each other: merged clouds have them anywhere."""
    assert frame.rgb is not None
    assert frame.truth is not None
    which = np.random.default_rng(3).permutation(np.repeat(np.arange(len(times)), times))
    return scenes.Frame(frame.xyz[which], frame.rgb[which], frame.truth[which], frame.viewpoint)


def run(
    frames: list[scenes.Frame],
    seeds: list[Seed],
    known: Callable[[int], FrameKnowledge | None],
    method: str = "auto",
) -> list[FrameResult]:
    order = range(len(frames))
    made = METHODS[method]().track(frames.__getitem__, order, seeds, known, TrackOptions())
    return list(made)


def seeds_of(frame: scenes.Frame) -> list[Seed]:
    return [Seed(n, np.flatnonzero(frame.truth == n)) for n in (1, 2)]


def overlap(result: FrameResult, frame: scenes.Frame, label: int) -> float:
    found = np.zeros(len(frame.xyz), np.bool_)
    found[result.assignments.get(label, [])] = True
    truth = frame.truth == label
    return float((found & truth).sum() / (found | truth).sum())


@pytest.mark.parametrize("copies", [each_twice, dual_returns, one_object_thrice])
def test_objects_are_followed_where_points_occur_several_times(
    copies: Callable[[np.ndarray], np.ndarray],
) -> None:
    frames = [repeated(f, copies(f.truth)) for f in map(room, range(4))]
    results = run(frames, seeds_of(frames[0]), lambda _: None)
    scores = [overlap(r, f, n) for r, f in zip(results, frames, strict=True) for n in (1, 2)][2:]
    assert np.mean(scores) > 0.85
    for result in results[1:]:
        assert all(result.tracks[n].points == len(p) for n, p in result.assignments.items())


@pytest.mark.parametrize("method", ["icp", "color-icp", "auto"])
def test_copies_of_points_do_not_change_what_a_method_finds(method: str) -> None:
    once = [room(k) for k in range(3)]
    twice = [
        scenes.Frame(np.repeat(f.xyz, 2, axis=0), np.repeat(f.rgb, 2, axis=0), f.truth.repeat(2))
        for f in once
    ]
    alone = run(once, seeds_of(once[0]), lambda _: None, method)
    copied = run(twice, seeds_of(twice[0]), lambda _: None, method)
    for one, two in zip(alone, copied, strict=True):
        assert one.assignments.keys() == two.assignments.keys()
        for label, points in one.assignments.items():
            assert np.array_equal(
                np.repeat(2 * points, 2) + [0, 1] * len(points), two.assignments[label]
            )


def test_a_copy_that_may_not_be_taken_stays_while_the_other_is_labelled() -> None:
    frames = [repeated(f, each_twice(f.truth)) for f in map(room, range(2))]
    copies = Copies.of(frames[1].xyz)
    assert copies is not None
    second = np.setdiff1d(np.arange(len(frames[1].xyz)), copies.first)
    kept, gone = second[:500], second[500:1000]

    def known(number: int) -> FrameKnowledge | None:
        if number == 0:
            return None
        count = len(frames[1].xyz)
        label, source = np.zeros(count, np.uint16), np.zeros(count, np.uint8)
        deleted = np.zeros(count, np.bool_)
        label[kept], source[kept], deleted[gone] = 9, PAINTED, True
        return FrameKnowledge(label, source, deleted)

    result = run(frames, seeds_of(frames[0]), known)[1]
    taken = np.concatenate(list(result.assignments.values()))
    assert not np.isin(np.concatenate([kept, gone]), taken).any()
    assert overlap(result, frames[1], 2) > 0.7


def test_equal_points_are_found_whatever_the_sign_of_zero_and_none_where_all_differ() -> None:
    xyz = np.array([[0, 1, 2], [0, 1, 3], [-0.0, 1, 2], [0, 1, 3], [5, 5, 5]], np.float32)
    copies = Copies.of(xyz)
    assert copies is not None
    assert copies.first.tolist() == [0, 1, 4]
    assert copies.position.tolist() == [0, 1, 0, 1, 2]
    assert Copies.of(np.random.default_rng(0).random((5000, 3)).astype(np.float32)) is None
    assert Copies.of(np.empty((0, 3), np.float32)) is None
