"""A depth camera in a hand that is held still: seen as one at rest, from the middle of its way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
import scenes
from runs import follow

from pointbrush.frame import PointFrame
from pointbrush.sequences.depth.finding import find_lattice
from pointbrush.tracking.compute.rigid import inverse, transform
from pointbrush.tracking.interface import F64
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import find_lens, steadied
from pointbrush.tracking.sensors.scan_odometry import find_trajectory
from pointbrush.tracking.sensors.trajectory import Trajectory
from pointbrush.tracking.sensors.view import View

OPTIONS = TrackerOptions()


@pytest.fixture(scope="module")
def swaying() -> list[scenes.Frame]:
    return scenes.swaying()


def way_of(frames: Sequence[scenes.Frame]) -> Trajectory:
    """The way that the frames alone show."""
    untold = [replace(frame, pose=None) for frame in frames]
    painted = np.flatnonzero(frames[0].truth)
    way = find_trajectory(untold.__getitem__, range(len(untold)), painted, options=OPTIONS)
    assert way is not None
    return way


def true_pose(frames: Sequence[scenes.Frame], number: int) -> F64:
    return np.asarray(inverse(frames[0].pose) @ frames[number].pose)


def apart(one: F64, other: F64) -> float:
    """Metres between where two poses see what is 3 m ahead."""
    ahead = np.array([[0.0, 0.0, 3.0]])
    return float(np.linalg.norm(transform(one, ahead) - transform(other, ahead)))


def test_a_camera_that_hardly_sways_is_not_taken_to_be_at_rest() -> None:
    frames = scenes.swaying(far=0.003, turn=0.003)
    way = way_of(frames)
    for number in range(len(frames)):
        assert apart(way.pose(number), true_pose(frames, number)) < 0.005


def test_a_camera_whose_pixels_the_import_found_is_seen_to_sway(
    swaying: list[scenes.Frame],
) -> None:
    first = swaying[0]
    found = find_lattice(PointFrame(first.xyz, first.rgb), first.xyz, np.zeros(3), 0.001)
    assert found is not None
    way = way_of([replace(frame, lattice=found) for frame in swaying])
    for number in (3, 9):
        assert apart(way.pose(number), true_pose(swaying, number)) < 0.005


def test_its_way_is_found_again_after_a_hand_was_before_the_lens(
    swaying: list[scenes.Frame],
) -> None:
    covered = list(swaying)
    for number in (4, 5):
        frame = swaying[number]
        x, y = (frame.xyz[:, :2] / frame.xyz[:, 2:]).T
        depth = 0.35 + 0.1 * np.sin(9 * x + 1) + 0.05 * y
        hand = (frame.xyz * (depth / frame.xyz[:, 2])[:, None]).astype(np.float32)
        covered[number] = replace(frame, xyz=hand, rgb=np.full_like(frame.rgb, 150))
    way = way_of(covered)
    for number in (3, 6, 9):
        assert apart(way.pose(number), true_pose(swaying, number)) < 0.005
    assert way.lost == {4, 5}


def test_a_camera_at_rest_is_not_moved_by_who_stops_the_recording() -> None:
    frames = [replace(f, pose=None) for f in scenes.swaying(frames=6, far=0.0, turn=0.0)]
    last = frames[-1]
    across = last.xyz[:, 0] / last.xyz[:, 2]
    depth = np.where(across < np.quantile(across, 0.3), last.xyz[:, 2], 1.0 + 0.3 * across**2)
    depth += np.random.default_rng(1).normal(0.0, 0.002, len(depth))
    near = last.xyz * (depth / last.xyz[:, 2])[:, None]
    frames[-1] = replace(last, xyz=near.astype(np.float32), truth=None)
    painted = np.flatnonzero(frames[0].truth)
    assert find_trajectory(frames.__getitem__, range(6), painted, options=OPTIONS) is None


def test_people_before_it_are_followed_without_a_doubt(swaying: list[scenes.Frame]) -> None:
    for result in follow([replace(frame, pose=None) for frame in swaying])[1:]:
        frame = swaying[result.frame]
        for label in (1, 2):
            found = result.assignments[label]
            both = np.count_nonzero(frame.truth[found] == label)
            assert both > 0.85 * (np.count_nonzero(frame.truth == label) + len(found) - both)
            assert result.tracks[label].confidence > 0.5
        # Who stands is at rest in the world, and moves in the frames as the camera does not.
        stands = swaying[0].xyz[swaying[0].truth == 2].mean(axis=0)[None].astype(np.float64)
        there = transform(inverse(true_pose(swaying, result.frame)), stands)
        assert np.linalg.norm(transform(result.tracks[2].pose, stands) - there) < 0.05


def test_a_lens_that_bends_straight_lines_changes_nothing(swaying: list[scenes.Frame]) -> None:
    """Pixels that were set straight lie on no lattice."""
    bent = []
    for frame in swaying:
        plane = frame.xyz[:, :2] / frame.xyz[:, 2:]
        plane *= 1 + 0.06 * (plane**2).sum(axis=1, keepdims=True)
        xyz = np.hstack([plane, np.ones((len(plane), 1))]) * frame.xyz[:, 2:]
        bent.append(replace(frame, xyz=xyz.astype(np.float32), pose=None))
    for result in follow(bent)[1:]:
        truth = bent[result.frame].truth
        for label in (1, 2):
            found = result.assignments[label]
            both = np.count_nonzero(truth[found] == label)
            assert both > 0.8 * (np.count_nonzero(truth == label) + len(found) - both)
            assert result.tracks[label].confidence > 0.5


def test_all_that_it_sees_lies_in_one_picture_and_nothing_is_hidden_there(
    swaying: list[scenes.Frame],
) -> None:
    lens = find_lens(swaying[0], moves=True, options=OPTIONS)
    assert lens is not None
    poses = [true_pose(swaying, number) for number in range(len(swaying))]
    depth = View(0, swaying[0], lens, options=OPTIONS).cells[1]
    still = steadied(lens, depth, poses[::3], options=OPTIONS)
    assert still is not None
    for number, frame in enumerate(swaying):
        view = View(number, frame, still, OPTIONS, poses[number], steady=True)
        cell, depth = view.cells
        assert (cell >= 0).all()
        assert (depth > 1.1 * view.depth[cell]).mean() < 0.01


def test_a_camera_that_is_carried_away_or_turned_round_is_none(
    swaying: list[scenes.Frame],
) -> None:
    lens = find_lens(swaying[0], moves=True, options=OPTIONS)
    assert lens is not None
    depth = View(0, swaying[0], lens, options=OPTIONS).cells[1]
    carried = scenes.carried()
    assert (
        steadied(lens, depth, [true_pose(carried, n) for n in range(len(carried))], options=OPTIONS)
        is None
    )
    about = np.diag([-1.0, 1.0, -1.0, 1.0])
    assert steadied(lens, depth, [np.eye(4), about], options=OPTIONS) is None


def test_a_frame_that_shows_nothing_is_taken_to_be_where_the_last_one_was(
    swaying: list[scenes.Frame],
) -> None:
    empty = replace(swaying[1], xyz=swaying[1].xyz[:0], rgb=swaying[1].rgb[:0], truth=None)
    way = way_of([swaying[0], empty, *swaying[2:]])
    assert np.array_equal(way.pose(1), np.eye(4))
    assert way.lost == {1}
    assert apart(way.pose(2), true_pose(swaying, 2)) < 0.005
