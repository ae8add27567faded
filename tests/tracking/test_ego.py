"""A sensor that moves: its way is found where nobody tells it, results are in its own frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes
from runs import follow

from pointbrush.tracking.compute.rigid import transform
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.scan_odometry import find_trajectory
from pointbrush.tracking.sensors.scanner import find_eye, range_image_of
from pointbrush.tracking.steps.propose import shifts

OPTIONS = TrackerOptions()


@pytest.fixture(scope="module")
def street() -> list[scenes.Frame]:
    return scenes.street(seed=1, frames=4)


def alone(frames: list[scenes.Frame]) -> list[scenes.Frame]:
    """The frames without what they say of the sensor."""
    return [replace(frame, pose=None, viewpoint=None) for frame in frames]


def test_the_way_of_a_lidar_is_found_in_its_frames(street: list[scenes.Frame]) -> None:
    way = find_trajectory(alone(street).__getitem__, range(4), options=OPTIONS)
    assert way is not None
    for number in range(4):
        true = np.linalg.inv(street[0].pose) @ street[number].pose
        assert np.abs(way.pose(number) - true).max() < 0.02


def test_a_street_whose_ground_and_walls_would_fit_a_car_at_rest_as_well() -> None:
    frames = scenes.street(seed=3, frames=2)
    way = find_trajectory(alone(frames).__getitem__, range(2), options=OPTIONS)
    assert way is not None
    true = np.linalg.inv(frames[0].pose) @ frames[1].pose
    assert np.abs(true[:3, 3]).max() > 0.5
    assert np.abs(way.pose(1) - true).max() < 0.02


@pytest.mark.parametrize(("seed", "ahead"), [(5, 1), (1, 2), (3, 2)])
def test_the_front_quarter_of_a_street_is_mostly_road_and_does_not_slip_along_it(
    seed: int, ahead: int
) -> None:
    """Nor does it seem to stand: most of what it shows is near, the next frame metres on."""
    quarter = []
    for frame in alone(scenes.street(seed=seed, frames=ahead + 1))[::ahead]:
        front = np.abs(np.arctan2(frame.xyz[:, 0], frame.xyz[:, 2])) < np.pi / 4
        quarter.append(replace(frame, xyz=frame.xyz[front], truth=None))
    way = find_trajectory(quarter.__getitem__, range(2), options=OPTIONS)
    assert way is not None
    assert np.abs(way.pose(1)[:3, 3] - [0.0, 0.0, 0.8 * ahead]).max() < 0.03


def test_poses_that_are_told_count_from_the_first_frame(street: list[scenes.Frame]) -> None:
    far = np.eye(4)
    far[:3, 3] = [4e6, -3e6, 100.0]
    told = [replace(frame, pose=far @ frame.pose) for frame in street]
    way = find_trajectory(told.__getitem__, range(4), options=OPTIONS)
    assert way is not None
    assert np.allclose(way.pose(0), np.eye(4))
    assert np.allclose(way.pose(3), np.linalg.inv(street[0].pose) @ street[3].pose, atol=1e-6)


def test_a_sensor_at_rest_is_not_moved_by_people_who_walk(passing: list[scenes.Frame]) -> None:
    assert find_trajectory(alone(passing).__getitem__, range(len(passing)), options=OPTIONS) is None


def test_parked_cars_are_kept_from_a_car_that_drives_by(street: list[scenes.Frame]) -> None:
    """With the poses and without; their own poses are in the coordinates of each frame."""
    for frames in (street, alone(street)):
        last = follow(frames)[-1]
        truth = frames[-1].truth
        assert truth is not None
        found = last.assignments[3]
        both = np.count_nonzero(truth[found] == 3)
        assert both > 0.6 * (np.count_nonzero(truth == 3) + len(found) - both)
        # The sensor has gone 2.4 m ahead, so the parked car 2.4 m back.
        assert np.abs(last.tracks[3].pose[:3, 3] - [0.0, 0.0, -2.4]).max() < 0.15


def test_the_sensor_is_found_where_no_surface_hides_another(street: list[scenes.Frame]) -> None:
    eye = find_eye(street[0].xyz, options=OPTIONS)
    assert eye is not None
    assert np.abs(eye).max() < 1e-6
    assert find_eye(street[0].xyz + np.float32([9.0, 0.0, 5.0]), options=OPTIONS) is None


def test_what_was_swept_on_the_move_was_seen_from_about_one_place() -> None:
    """Brought to one moment, points of one direction may lie behind each other."""
    before, after = scenes.street(seed=1, frames=2)
    xyz = np.concatenate([before.xyz[::2] - np.float32([0, 0, 0.8]), after.xyz[1::2]])
    eye = find_eye(xyz, options=OPTIONS)
    assert eye is not None
    assert np.abs(eye).max() < 1e-6
    assert range_image_of(xyz, eye, options=OPTIONS) is not None


def test_what_lies_behind_a_car_is_hidden(street: list[scenes.Frame]) -> None:
    frame = street[0]
    shade = range_image_of(frame.xyz, np.zeros(3), options=OPTIONS)
    assert shade is not None
    car = frame.xyz[frame.truth == 4].astype(np.float64)
    inside = car[np.abs(car - np.median(car, axis=0)).max(axis=1) < 0.5]
    assert shade.hides(1.3 * inside, 0.1).mean() > 0.9
    assert not shade.hides(0.8 * inside, 0.1).any()


def fine_lidar() -> np.ndarray:
    """(N, 3) what 64 rings measure of a road between parked cars and houses, z up, from the
    origin."""
    azimuth, elevation = np.radians(np.arange(0.1, 360, 0.2)), np.radians(np.linspace(-25, 2, 64))
    a, e = (angle.ravel() for angle in np.meshgrid(azimuth, elevation))
    ray = np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=1)
    with np.errstate(divide="ignore"):
        road = np.where(ray[:, 2] < 0, -1.8 / ray[:, 2], np.inf)
        wall, car = 8.0 / np.abs(ray[:, 1]), 3.0 / np.abs(ray[:, 1])
    house = (np.abs(wall * ray[:, 0]) % 9.0 < 6.0) & (wall * ray[:, 2] < 4.0)
    parked = (np.abs(car * ray[:, 0]) % 6.0 < 4.0) & (car * ray[:, 2] < -0.4)
    away = np.minimum(road, np.where(parked, car, np.where(house, wall, np.inf)))
    return (ray * away[:, None])[away < 60.0].astype(np.float32)


@pytest.mark.parametrize("height", [0.0, 1.8])
def test_the_height_of_a_fine_lidar_is_found(height: float) -> None:
    eye = find_eye(fine_lidar() + np.array([0, 0, height], np.float32), options=OPTIONS)
    assert eye is not None
    assert np.allclose(eye, [0, 0, height])


def test_beyond_the_edges_of_what_a_lidar_sees_all_is_hidden() -> None:
    xyz = fine_lidar()
    ahead = np.abs(np.arctan2(xyz[:, 1], xyz[:, 0])) < np.pi / 4
    shade = range_image_of(xyz[ahead], np.zeros(3), options=OPTIONS)
    assert shade is not None
    assert not shade.hides(0.8 * xyz[ahead].astype(np.float64), 0.1).any()
    aside = np.abs(np.arctan2(xyz[:, 1], xyz[:, 0])) > np.radians(50)
    assert shade.hides(0.8 * xyz[aside].astype(np.float64), 0.1).all()


def test_a_thing_that_came_nearer_does_not_hide_itself(street: list[scenes.Frame]) -> None:
    frame = street[0]
    shade = range_image_of(frame.xyz, np.zeros(3), options=OPTIONS)
    assert shade is not None
    car = frame.xyz[frame.truth == 4].astype(np.float64)
    behind = car + 1.5 * car / np.linalg.norm(car, axis=1, keepdims=True)
    own = shade.towards(car)
    assert shade.hides(behind, 0.1).mean() > 0.9
    assert not shade.hides(behind, 0.1, own, 3.0).any()
    assert shade.hides(behind, 0.1, own, 1.0).mean() > 0.9  # so far ahead it is another


def test_what_drove_on_is_found_where_its_points_find_one() -> None:
    rng = np.random.default_rng(0)
    size = np.array([2.2, 0.9, 0.7])
    car = rng.uniform(-1, 1, (400, 3)) * size
    side = rng.integers(0, 2, 400)  # the back and the side that face the sensor
    car[np.arange(400), side] = size[side]
    wall = np.array([0.0, 4.0, 0.0]) + rng.uniform(-1, 1, (2000, 3)) * [6.0, 0.05, 1.5]
    pose = np.eye(4)
    moved = np.vstack([car + [1.7, 0.1, 0.0], wall])
    found = shifts(car[::4], moved, pose, 0.08, options=OPTIONS.propose)
    off = [np.abs(transform(T, car).mean(0) - car.mean(0) - [1.7, 0.1, 0.0]).max() for T in found]
    assert min(off) < 0.32
    # A point that flew off, and a thing whose points are all in one place.
    flown = np.vstack([moved, [[3e7, 0.0, 0.0]]])
    assert len(shifts(car[::4], flown, pose, 1e-4, options=OPTIONS.propose)) > 0


def test_a_figure_sampled_about_its_own_middle_was_not_seen_from_there() -> None:
    """Nor was it by a lidar, though each direction shows one surface of it from there."""
    rng = np.random.default_rng(1)
    half = np.array([0.05, 0.1, 0.25])
    axis = rng.choice(3, 4000, p=(1 / half) / (1 / half).sum())
    xyz = rng.uniform(-half, half, (4000, 3))
    xyz[np.arange(4000), axis] = (half * rng.choice([-1, 1], (4000, 1)))[np.arange(4000), axis]
    assert find_eye(xyz.astype(np.float32), options=OPTIONS) is None
    even = rng.normal(size=(8000, 3))
    even /= np.linalg.norm(even, axis=1, keepdims=True)
    seen = even * (half / np.abs(even)).min(axis=1)[:, None]
    assert find_eye(seen.astype(np.float32), options=OPTIONS) is not None
