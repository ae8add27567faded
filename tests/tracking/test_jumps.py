"""A sensor at rest that jumps between two frames: the scenery tells where to, labels go on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest
import scenes
from runs import follow

from pointbrush.tracking.compute.rigid import transform
from pointbrush.tracking.interface import F64, FrameResult, Frames, Known, Seed, TrackOptions
from pointbrush.tracking.jumps import AcrossJumps, find_jumps
from pointbrush.tracking.options import TrackerOptions

OPTIONS = TrackerOptions()

AFTER = 5
"""The first frame behind the jump."""
PLACES = np.array([[-0.5, 1.4, 0.0], [1.0, 1.4, -0.9]])
"""Where the camera stands before and after, 1.7 m apart."""


def hold(i: int) -> tuple[F64, F64]:
    return np.zeros(3), PLACES[int(i >= AFTER)]


@pytest.fixture(scope="module")
def jumped() -> list[scenes.Frame]:
    return [replace(frame, pose=None) for frame in scenes.carried(10, hold)]


def share_of(found: np.ndarray, truth: np.ndarray) -> float:
    both = np.count_nonzero(truth[found])
    return both / (np.count_nonzero(truth) + len(found) - both)


def test_the_scenery_tells_where_the_sensor_went(jumped: list[scenes.Frame]) -> None:
    (jump,) = find_jumps(jumped.__getitem__, range(10), options=OPTIONS)
    assert jump.at == AFTER
    assert jump.T[:3, 3] == pytest.approx(PLACES[0] - PLACES[1], abs=0.02)
    back = list(range(9, -1, -1))
    (jump,) = find_jumps(jumped.__getitem__, back, options=OPTIONS)
    assert back[jump.at] == AFTER - 1


def test_labels_are_found_behind_a_jump_and_poses_go_across_it(jumped: list[scenes.Frame]) -> None:
    results = follow(jumped)
    assert [result.frame for result in results] == list(range(10))
    for result in results[AFTER + 1 :]:
        for label in (1, 2):
            truth = jumped[result.frame].truth == label
            assert share_of(result.assignments[label], truth) > 0.8
            assert result.tracks[label].state == "tracked"
    # The person who stands is where they were, as the camera now sees it.
    start = jumped[0].xyz[jumped[0].truth == 2].astype(np.float64)
    moved = transform(results[-1].tracks[2].pose, start)
    expected = start + PLACES[0] - PLACES[1]
    assert np.linalg.norm(moved.mean(axis=0) - expected.mean(axis=0)) < 0.1


def test_a_sensor_that_moves_or_rests_does_not_jump(passing: list[scenes.Frame]) -> None:
    carried = [replace(frame, pose=None) for frame in scenes.carried()]
    street = [replace(frame, pose=None) for frame in scenes.street(1, 8)]
    for frames in (carried, street, passing):
        assert list(find_jumps(frames.__getitem__, range(len(frames)), options=OPTIONS)) == []


def test_recorded_poses_are_believed(jumped: list[scenes.Frame]) -> None:
    told = [replace(frame, pose=np.eye(4)) for frame in jumped]
    told[-1] = replace(told[-1], pose=np.diag([1.0, 1, 1, 1]) + np.eye(4, k=3))
    assert list(find_jumps(told.__getitem__, range(10), options=OPTIONS)) == []


class Loses:
    """A method that finds nothing behind its first frame."""

    def track(
        self,
        frames: Frames,  # noqa: ARG002
        order: Sequence[int],
        seeds: Sequence[Seed],  # noqa: ARG002
        known: Known,  # noqa: ARG002
        options: TrackOptions,  # noqa: ARG002
    ) -> Iterator[FrameResult]:
        return (FrameResult(number, {}, {}) for number in order)


def test_every_frame_has_a_result_where_all_was_lost_before_a_jump(
    jumped: list[scenes.Frame],
) -> None:
    seeds = [Seed(2, np.flatnonzero(jumped[0].truth == 2))]
    method = AcrossJumps(Loses(), Loses())
    found = method.track(jumped.__getitem__, range(10), seeds, lambda _: None, TrackOptions())
    assert [result.frame for result in found] == list(range(10))
