"""The plane under a ray: all of a floor, none of what stands on it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pointbrush.formats import read
from pointbrush.selection import Points, select
from tests.selection.test_select import indexed, stroke

SEEDS = st.integers(0, 2**32 - 1)
FLOOR, WALL, CHAIR, TABLE = 0, 1, 2, 3


def room(seed: int, noise: float = 0.004) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A floor (z = 0) with a wall (x = 0), a box and a table on it, and what each point is of."""
    rng = np.random.default_rng(seed)
    u = rng.uniform(0, 1, (24_000, 2))
    floor = np.column_stack([u[:14_000] * [3, 3], np.zeros(14_000)])
    # Nothing is seen of the floor under the box.
    hidden = ((floor[:, :2] > [1.0, 1.0]) & (floor[:, :2] < [1.4, 1.4])).all(axis=1)
    wall = np.column_stack([np.zeros(6000), u[14_000:20_000] * [3, 2]])
    side = u[20_000:22_000] * [0.4, 0.5]
    chair = np.column_stack([1 + side[:, 0], np.ones(2000), side[:, 1]])
    table = np.column_stack([1.8 + u[22_000:] * [0.8, 0.8], np.full(2000, 0.7)])
    parts = [floor[~hidden], wall, chair, table]
    xyz = np.concatenate(parts)
    xyz += rng.normal(0, noise, xyz.shape)
    return xyz, np.repeat([FLOOR, WALL, CHAIR, TABLE], [len(part) for part in parts])


def taken(points: Points, at: list[float], eye: list[float], **fields: object) -> set[int]:
    way = np.subtract(at, eye)
    return set(select(points, stroke("plane", eye, way, radius=0.05, **fields)).tolist())


def shares(got: set[int], part: NDArray[np.int64]) -> list[float]:
    numbers = np.fromiter(got, np.int64)
    return [float((part[numbers] == k).sum() / (part == k).sum()) for k in range(4)]


@given(SEEDS)
@settings(max_examples=15)
def test_takes_the_floor_and_leaves_what_stands_on_it(seed: int) -> None:
    xyz, part = room(seed)
    got = taken(indexed(xyz.astype(np.float32)), [2.5, 0.5, 0], [1.5, 0.3, 1.6])
    floor, wall, chair, table = shares(got, part)
    assert floor > 0.95
    # Only the foot of the wall and of the box lies as near to the floor as the floor itself.
    assert wall < 0.03
    assert chair < 0.08
    assert table == 0


@given(SEEDS, st.lists(st.floats(-180, 180), min_size=3, max_size=3))
@settings(max_examples=15)
def test_planes_lie_any_way(seed: int, angles: list[float]) -> None:
    xyz, part = room(seed)
    turn = Rotation.from_euler("xyz", angles, degrees=True)
    points = indexed(turn.apply(xyz).astype(np.float32))
    wall = [0.0, 1.5, 1.2], [1.5, 1.5, 1.2]
    got = taken(points, *(turn.apply(place).tolist() for place in wall))
    assert shares(got, part)[WALL] > 0.95
    assert shares(got, part)[FLOOR] < 0.03


def test_stops_at_a_gap_wider_than_the_brush_bridges() -> None:
    rng = np.random.default_rng(3)
    near = np.column_stack([rng.uniform(0, 1, (4000, 2)), np.zeros(4000)])
    far = near + [1.5, 0, 0]
    points = indexed(np.concatenate([near, far]).astype(np.float32))
    eye = [0.5, 0.5, 1.0]
    assert max(taken(points, [0.5, 0.5, 0], eye)) < 4000
    wide = select(points, stroke("plane", eye, [0, 0, -1], radius=0.3))
    assert len(wide) == 8000


def test_what_is_deleted_is_neither_met_nor_taken() -> None:
    xyz, part = room(5)
    points = indexed(xyz.astype(np.float32))
    ray = stroke("plane", [2.2, 2.2, 1.6], [0, 0, -1], radius=0.05)
    assert shares(set(select(points, ray).tolist()), part)[TABLE] > 0.95
    alive = part != TABLE
    got = select(points, ray, lambda numbers: alive[numbers])
    assert shares(set(got.tolist()), part)[FLOOR] > 0.95
    assert alive[got].all()


def test_a_few_points_are_no_reason_to_fail() -> None:
    for count in (1, 2, 3, 4):
        xyz = np.zeros((count, 3), np.float32)
        xyz[:, 0] = np.arange(count) * 0.01
        got = select(indexed(xyz), stroke("plane", [0, 0, 1], radius=0.05))
        assert len(got) in (0, count)


def test_takes_a_wall_of_a_real_recording(shared: Path) -> None:
    files = sorted((shared / "realdata" / "pcl_kinect3").rglob("*.pcd"))
    if not files:
        pytest.skip("pcl_kinect3 holds no frames")
    xyz = np.asarray(next(iter(read(files[0]))).xyz)
    xyz = xyz[np.isfinite(xyz).all(axis=1)].astype(np.float32)
    got = taken(indexed(xyz), xyz[len(xyz) // 5].tolist(), [0, 0, 0])
    numbers = np.fromiter(got, np.int64)
    off = xyz[numbers].astype(np.float64) - xyz[numbers].mean(axis=0)
    spread = np.linalg.svd(off, compute_uv=False) / np.sqrt(len(numbers))
    # As wide as a forearm at least, and as flat as the sensor's noise of a few millimetres.
    assert len(numbers) > 5000
    assert spread[1] > 0.03
    assert spread[2] < 0.005
