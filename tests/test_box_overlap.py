"""3D IoU of boxes, against shapes whose volumes are known and against counted points."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pointbrush.geometry.box_overlap import iou_3d, iou_matrix, shared_volume
from pointbrush.geometry.quaternions import rotation_of

Floats = NDArray[np.float64]


def place(centre: tuple[float, ...], yaw: float = 0.0) -> Floats:
    T = np.eye(4)
    T[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    T[:3, 3] = centre
    return T


CAR = np.array([4.0, 2.0, 1.5])


def test_known_overlaps() -> None:
    there = place((500_000.0, 5_400_000.0, 1.0), 0.7)
    assert np.isclose(iou_3d(CAR, there, CAR, there), 1)
    assert np.isclose(iou_3d(CAR, there, CAR, place((500_000.0, 5_400_000.0, 1.0), 0.7 + np.pi)), 1)
    cube, origin = np.full(3, 2.0), place((0, 0, 0))
    assert np.isclose(iou_3d(cube, origin, cube, place((1, 0, 0))), 1 / 3)
    # A square and the same one turned by an eighth share a regular octagon.
    octagon = 2 * 8 * (np.sqrt(2) - 1)
    assert np.isclose(shared_volume(cube, origin, cube, place((0, 0, 0), np.pi / 4)), octagon)
    assert shared_volume(cube, origin, cube, place((2, 0, 0))) < 1e-6  # a common face
    assert shared_volume(cube, origin, cube, place((9, 0, 0))) == 0
    assert np.isclose(shared_volume(cube, origin, cube / 4, place((0.1, 0, 0), 0.3)), 1 / 8)


def test_a_matrix_has_a_row_for_each_of_the_first() -> None:
    here, there = place((0, 0, 0)), place((50, 0, 0))
    found = iou_matrix(np.stack([CAR, CAR]), np.stack([here, there]), CAR[None], there[None])
    assert np.allclose(found, [[0], [1]])


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000))
def test_boxes_turned_in_any_way_share_the_points_in_both(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sizes, Ts = rng.uniform(0.5, 3, (2, 3)), np.stack([np.eye(4), np.eye(4)])
    for T in Ts:
        T[:3, :3], T[:3, 3] = rotation_of(rng.normal(size=4)), rng.uniform(-0.7, 0.7, 3)
    points = rng.uniform(-0.5, 0.5, (40_000, 3)) * sizes[0] @ Ts[0][:3, :3].T + Ts[0][:3, 3]
    local = (points - Ts[1][:3, 3]) @ Ts[1][:3, :3]
    counted = (np.abs(local) <= sizes[1] / 2).all(axis=1).mean() * np.prod(sizes[0])
    found = shared_volume(sizes[0], Ts[0], sizes[1], Ts[1])
    assert abs(found - counted) < 0.02 * np.prod(sizes[0])
    assert np.isclose(found, shared_volume(sizes[1], Ts[1], sizes[0], Ts[0]))
