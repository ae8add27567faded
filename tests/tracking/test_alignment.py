"""Mounts of several sensors are corrected by the surfaces that they share."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pointbrush.errors import ConflictError
from pointbrush.tracking.compute.rigid import inverse, transform
from pointbrush.tracking.sensors.alignment import SensorPoints, align_mounts

NAMES = ("front", "left", "right")
MOUNTS = {
    0: (np.array([0.0, 0.0, 0.0]), 0.0),
    1: (np.array([-1.5, -0.3, 1.0]), 40.0),
    2: (np.array([1.5, 0.2, 1.5]), -50.0),
}
"""Position in metres and turn about the vertical y in degrees of each sensor."""
NOISE_M = 0.003


def mount(number: int) -> np.ndarray:
    place, turn = MOUNTS[number]
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.from_euler("y", turn, degrees=True).as_matrix(), place
    return T


def error(rng: np.random.Generator, metres: float, degrees: float) -> np.ndarray:
    axis, way = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(np.radians(degrees) * axis).as_matrix()
    T[:3, 3] = metres * way
    return T


def corner(rng: np.random.Generator) -> np.ndarray:
    """Points of a floor, a back wall and a ball that all sensors see."""
    floor = np.column_stack([rng.uniform(-2, 2, 9000), np.full(9000, 1.2), rng.uniform(2, 4, 9000)])
    wall = np.column_stack([rng.uniform(-2, 2, 9000), rng.uniform(-1, 1.2, 9000), np.full(9000, 4)])
    round_ = rng.normal(size=(9000, 3))
    round_ /= np.linalg.norm(round_, axis=1, keepdims=True)
    ball = round_[round_[:, 2] < 0.2] * 0.8 + [0.0, 0.4, 3.0]
    return np.concatenate([floor, wall, ball])


def seen(xyz: np.ndarray, rng: np.random.Generator, number: int, wrong: np.ndarray) -> SensorPoints:
    own = transform(inverse(mount(number)), xyz)
    return SensorPoints(number, mount(number) @ wrong, own + rng.normal(0, NOISE_M, own.shape))


def test_mounts_are_corrected_from_two_centimetres_and_two_degrees() -> None:
    rng = np.random.default_rng(201)
    wrong = [np.eye(4), error(rng, 0.02, 2.0), error(rng, 0.02, 2.0)]
    frames = [[seen(corner(rng), rng, n, wrong[n]) for n in MOUNTS] for _ in range(2)]
    found = align_mounts(frames, NAMES)
    assert np.array_equal(found[0].T, np.eye(4))  # the reference stays
    for number in (1, 2):
        left = wrong[number] @ found[number].T
        assert np.linalg.norm(left[:3, 3]) < 0.003
        assert Rotation.from_matrix(left[:3, :3]).magnitude() < np.radians(0.2)
        assert found[number].after < 0.25 * found[number].before


def test_a_sensor_that_sees_no_common_surface_is_named() -> None:
    rng = np.random.default_rng(1)
    frames = [[seen(corner(rng), rng, 0, np.eye(4)), seen(corner(rng) + 9.0, rng, 1, np.eye(4))]]
    with pytest.raises(ConflictError, match="left: no surface is also seen by another sensor"):
        align_mounts(frames, NAMES[:2])


def test_a_floor_alone_does_not_determine_a_mount() -> None:
    rng = np.random.default_rng(2)
    frames = [[seen(corner(rng)[:9000], rng, n, np.eye(4)) for n in (0, 1)]]
    with pytest.raises(ConflictError, match=r"left: the surfaces .* leave its position open"):
        align_mounts(frames, NAMES[:2])
