"""Predictions: what moves evenly, or falls, is predicted exactly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from pointbrush.tracking.model.motion import Motion
from pointbrush.tracking.options import TrackerOptions

OPTIONS = TrackerOptions()


def flight(i: int) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec([0.0, 0.5 * i, 0.0]).as_matrix()
    T[:3, 3] = [0.1 * i, 0.2 * i - 0.01 * i * i, 0.0]
    return T


def test_free_flight_with_spin_is_predicted() -> None:
    motion = Motion(OPTIONS.search, np.zeros(3))
    assert motion.is_unknown
    for i in range(1, 4):
        motion = motion.add(flight(i))
    assert np.allclose(motion.predictions[0], flight(4))
    motion = replace(motion, gap=2)
    assert np.allclose(motion.predictions[0], flight(5))


def test_what_tumbles_about_another_point_than_its_centre_is_predicted() -> None:
    """As a pin does: the middle of what was painted is not its centre of mass."""
    motion = Motion(OPTIONS.search, np.array([0.0, 0.12, 0.0]))
    flown = []
    for i in range(5):
        T = np.eye(4)
        T[:3, :3] = Rotation.from_rotvec([0.7 * i, 0.0, 0.0]).as_matrix()
        T[:3, 3] = [0.05 * i, 0.1 * i, 0.0]
        flown.append(T)
    for T in flown[1:4]:
        motion = motion.add(T)
    centre = np.append(motion.centre, 1.0)
    missed = np.linalg.norm((motion.predictions[0] - flown[4]) @ centre)
    repeated = np.linalg.norm((motion.predictions[1] - flown[4]) @ centre)
    assert missed < 0.02
    assert missed < 0.5 * repeated


def test_an_unsure_pose_leaves_the_motion_as_it_was() -> None:
    motion = Motion(OPTIONS.search, np.zeros(3))
    for i in range(1, 4):
        motion = motion.add(flight(i))
    before = motion.speed
    jump = flight(4)
    jump[:3, 3] += 1.0
    motion = motion.add(jump, sure=False)
    assert np.isclose(motion.speed, before, rtol=0.3)


def test_what_rested_is_looked_for_where_it_was_until_it_is_well_seen_elsewhere() -> None:
    motion, pushed = Motion(OPTIONS.search, np.zeros(3)), np.eye(4)
    for _ in range(8):
        motion = motion.add(np.eye(4))
    motion = motion.seen(unit=0.01)
    for i in range(1, 4):  # what half hides it seems to push it
        pushed = np.eye(4)
        pushed[0, 3] = 0.02 * i
        motion = motion.add(pushed)
    motion = replace(motion, gap=5)
    assert (np.abs(motion.predictions - np.eye(4)).max(axis=(1, 2)) < 1e-9).any()
    motion = motion.seen(unit=0.01)
    assert motion.rested is None
    assert (np.abs(motion.predictions - np.eye(4)).max(axis=(1, 2)) > 0.01).all()
