"""A sensor that moves: its way is found where nobody tells it, results are in its own frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes
from conftest import follow

from pointbrush.tracking.ego import sensor_poses
from pointbrush.tracking.shade import find_eye, shade_of


@pytest.fixture(scope="module")
def street() -> list[scenes.Frame]:
    return scenes.street(seed=1, frames=4)


def alone(frames: list[scenes.Frame]) -> list[scenes.Frame]:
    """The frames without what they say of the sensor."""
    return [replace(frame, pose=None, viewpoint=None) for frame in frames]


def test_the_way_of_a_lidar_is_found_in_its_frames(street: list[scenes.Frame]) -> None:
    poses = sensor_poses(alone(street).__getitem__, range(4))
    assert poses is not None
    for number in range(4):
        true = np.linalg.inv(street[0].pose) @ street[number].pose
        assert np.abs(poses(number) - true).max() < 0.02


def test_poses_that_are_told_count_from_the_first_frame(street: list[scenes.Frame]) -> None:
    far = np.eye(4)
    far[:3, 3] = [4e6, -3e6, 100.0]
    told = [replace(frame, pose=far @ frame.pose) for frame in street]
    poses = sensor_poses(told.__getitem__, range(4))
    assert poses is not None
    assert np.allclose(poses(0), np.eye(4))
    assert np.allclose(poses(3), np.linalg.inv(street[0].pose) @ street[3].pose, atol=1e-6)


def test_a_sensor_at_rest_is_not_moved_by_people_who_walk(passing: list[scenes.Frame]) -> None:
    assert sensor_poses(alone(passing).__getitem__, range(len(passing))) is None


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
    eye = find_eye(street[0].xyz)
    assert eye is not None
    assert np.abs(eye).max() < 1e-6
    assert find_eye(street[0].xyz + np.float32([9.0, 0.0, 5.0])) is None


def test_what_lies_behind_a_car_is_hidden(street: list[scenes.Frame]) -> None:
    frame = street[0]
    shade = shade_of(frame.xyz, np.zeros(3))
    assert shade is not None
    car = frame.xyz[frame.truth == 4].astype(np.float64)
    inside = car[np.abs(car - np.median(car, axis=0)).max(axis=1) < 0.5]
    assert shade.hides(1.3 * inside, 0.1).mean() > 0.9
    assert not shade.hides(0.8 * inside, 0.1).any()
