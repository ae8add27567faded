"""A run's labels depend neither on a thread that reads ahead, nor on another run beside it."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import scenes

from pointbrush.tracking import METHODS, FrameResult, Seed, TrackOptions

FIRST, LAST = 5, 8


def run(frames: list[scenes.Frame], *, ahead: bool) -> list[FrameResult]:
    truth = frames[FIRST].truth
    seeds = [Seed(n, np.flatnonzero(truth == n)) for n in np.unique(truth).tolist() if n]
    order, options = range(FIRST, LAST + 1), TrackOptions(read_ahead=ahead)
    return list(METHODS["auto"]().track(frames.__getitem__, order, seeds, lambda _: None, options))


def assert_same(found: list[FrameResult], expected: list[FrameResult]) -> None:
    assert [r.frame for r in found] == [r.frame for r in expected]
    for one, other in zip(found, expected, strict=True):
        assert set(one.tracks) == set(other.tracks)
        for label, track in one.tracks.items():
            again = other.tracks[label]
            assert (track.state, track.points) == (again.state, again.points)
            # Sums of some builds of NumPy round by where an array lies.
            assert track.confidence == pytest.approx(again.confidence, abs=1e-6)
            np.testing.assert_allclose(track.pose, again.pose, atol=1e-6)
        for label, points in one.assignments.items():
            assert np.array_equal(points, other.assignments[label])


@pytest.fixture(scope="module")
def alone(tabletop: list[scenes.Frame]) -> list[FrameResult]:
    return run(tabletop, ahead=False)


def test_frames_read_ahead_change_nothing(
    tabletop: list[scenes.Frame], alone: list[FrameResult]
) -> None:
    assert_same(run(tabletop, ahead=True), alone)


def test_two_runs_at_once_find_what_one_finds(
    tabletop: list[scenes.Frame], alone: list[FrameResult]
) -> None:
    with ThreadPoolExecutor(2) as pool:
        for found in pool.map(lambda _: run(tabletop, ahead=True), range(2)):
            assert_same(found, alone)
