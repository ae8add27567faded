"""People before a depth camera that is carried: its way, the scene behind them, and they."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes
from runs import follow

from pointbrush.tracking import FrameResult
from pointbrush.tracking.compute.grid import close_to
from pointbrush.tracking.compute.rigid import inverse, transform
from pointbrush.tracking.interface import F32
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.scene.images import DepthNoise
from pointbrush.tracking.scene.mapped import MapBackground, SurfaceMap, chart_of
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.scan_odometry import find_trajectory
from pointbrush.tracking.sensors.view import View

OPTIONS = TrackerOptions()


@pytest.fixture(scope="module")
def carried() -> list[scenes.Frame]:
    return scenes.carried()


@pytest.fixture(scope="module")
def followed(carried: list[scenes.Frame]) -> list[FrameResult]:
    return follow([replace(frame, pose=None) for frame in carried])


def test_the_way_of_a_camera_is_found_in_its_pictures(carried: list[scenes.Frame]) -> None:
    way = find_trajectory(
        [replace(f, pose=None) for f in carried].__getitem__, range(len(carried)), options=OPTIONS
    )
    assert way is not None
    for number, frame in enumerate(carried):
        scene = frame.xyz[frame.truth == 0].astype(np.float64)
        true = inverse(carried[0].pose) @ frame.pose
        off = np.linalg.norm(transform(way.pose(number), scene) - transform(true, scene), axis=1)
        assert np.median(off / np.linalg.norm(scene, axis=1)) < 0.01


def test_a_camera_at_rest_is_not_moved_by_who_passes_close_by(passing: list[scenes.Frame]) -> None:
    frames = [replace(f, xyz=f.xyz - np.float32([0.0, 1.0, 0.0]), viewpoint=None) for f in passing]
    assert find_lens(frames[0], moves=True, options=OPTIONS) is not None
    assert find_trajectory(frames.__getitem__, range(len(frames)), options=OPTIONS) is None


def test_the_scene_is_charted_without_who_moves_and_who_is_labelled(
    carried: list[scenes.Frame],
) -> None:
    lens = find_lens(carried[0], moves=True, options=OPTIONS)
    back = inverse(carried[0].pose)
    views = [View(i, f, lens, OPTIONS, back @ f.pose) for i, f in enumerate(carried)]
    views[0].labels = {n: np.flatnonzero(carried[0].truth == n) for n in (1, 2)}
    chart = chart_of(views, DepthNoise(0.001, 0.001), options=OPTIONS)
    for view, frame in zip(views, carried, strict=True):
        cell, depth = view.cells
        there = depth > chart.drawn(view)[cell] - 0.05
        assert there[frame.truth == 0].mean() > 0.85
        for label in (1, 2):
            assert there[frame.truth == label].mean() < 0.05


def test_people_are_followed_before_a_camera_that_is_carried(
    carried: list[scenes.Frame], followed: list[FrameResult]
) -> None:
    for result in followed[1:]:
        truth = carried[result.frame].truth
        for label in (1, 2):
            found = result.assignments[label]
            both = np.count_nonzero(truth[found] == label)
            assert both > 0.8 * (np.count_nonzero(truth == label) + len(found) - both)
            assert result.tracks[label].state == "tracked"
            assert result.tracks[label].confidence > 0.8


def test_what_comes_into_the_picture_is_nobody_unless_beside_who_was_labelled(
    carried: list[scenes.Frame],
) -> None:
    lens = find_lens(carried[0], moves=True, options=OPTIONS)
    first, later = (View(i, carried[i], lens, OPTIONS, carried[i].pose) for i in (0, 5))
    first.labels = {n: np.flatnonzero(carried[0].truth == n) for n in (1, 2)}
    nothing = SurfaceMap(np.empty((0, 3)), np.empty((0, 3)))
    background = MapBackground(OPTIONS, _reach, DepthNoise(0.001, 0.001), nothing)
    background.learn(first, first=True)
    every = np.arange(len(later.xyz))
    stands, truth = background.furniture(later, every), carried[5].truth
    assert stands[truth == 2].mean() < 0.05
    away = ~close_to(later.xyz, first.xyz[first.labelled()], 0.5)
    assert away.any()
    assert stands[away].all()


def _reach(world: F32) -> F32:
    return np.full(len(world), 0.03, np.float32)
