"""The room: whichever way a file's axes point, the floor ends up under the feet."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pointbrush.sequences.floor import find_floor, thin
from pointbrush.sequences.room import RoomFinder

ZUP = np.eye(3)
YUP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


def hall(seed: int = 0) -> np.ndarray:
    """A furnished room, z up, floor at z = 0: floor, two walls, ceiling strip, tables, people."""
    rng = np.random.default_rng(seed)

    def box(count: int, low: list[float], high: list[float]) -> np.ndarray:
        return rng.uniform(low, high, (count, 3))

    parts = [
        box(9000, [-2.5, -3, 0], [2.5, 3, 0]),
        box(6000, [-2.5, 3, 0], [2.5, 3, 2.6]),
        box(6000, [-2.5, -3, 0], [-2.5, 3, 2.6]),
        box(2000, [-2.5, 1, 2.6], [2.5, 3, 2.6]),
        box(2000, [0.5, 1, 0.75], [2, 2, 0.75]),
        box(3000, [-0.3, 0.5, 0], [0.2, 0.9, 1.75]),
    ]
    return np.concatenate(parts) + rng.normal(0, 0.006, (28_000, 3))


def tilt(degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[1.0, 0, 0], [0, c, -s], [0, s, c]])


def kinect(pitch: float, *, y_down: bool) -> tuple[np.ndarray, np.ndarray]:
    """The hall as a camera at 1.6 m sees it that looks along +y, ``pitch`` degrees down.

    Returns the points in the camera's axes (z forward), and the room's up in them.
    """
    xyz = hall() - [0, -2.9, 1.6]
    down = -1.0 if y_down else 1.0
    axes = np.array([[-down, 0, 0], [0, 0, down], [0, 1.0, 0]])
    R_camera_hall = tilt(-down * pitch) @ axes
    seen = xyz @ R_camera_hall.T
    depth = seen[:, 2]
    ok = (depth > 0.5) & (np.abs(seen[:, 0]) < 0.7 * depth) & (np.abs(seen[:, 1]) < 0.6 * depth)
    return seen[ok], R_camera_hall @ [0, 0, 1]


def stand(points: np.ndarray, viewpoint: np.ndarray | None = None, camera: bool = False):  # type: ignore[no-untyped-def]
    finder = RoomFinder(np.zeros(3))
    finder.add(points.astype(np.float32), viewpoint)
    T_room_local = finder.room(camera=camera)
    R = T_room_local[:3, :3]
    assert pytest.approx(np.eye(3)) == R @ R.T
    assert np.linalg.det(R) == pytest.approx(1)
    return points @ R.T + T_room_local[:3, 3], T_room_local


@pytest.mark.parametrize("axes", [ZUP, YUP], ids=["z up", "y up"])
@pytest.mark.parametrize("lean", [0, 4])
def test_a_surveyed_room_stands_on_its_floor(axes: np.ndarray, lean: float) -> None:
    rotation = tilt(lean) @ axes
    room, T_room_local = stand(hall() @ rotation.T)
    assert T_room_local[:3, :3] @ (rotation @ [0, 0, 1]) == pytest.approx([0, 1, 0], abs=0.01)
    assert np.abs(room[:9000, 1]).max() < 0.04
    assert room[:, 1].max() == pytest.approx(2.6, abs=0.06)
    assert np.abs(np.quantile(room[:, [0, 2]], [0.02, 0.98], axis=0).sum(axis=0)).max() < 0.1


@pytest.mark.parametrize("y_down", [True, False], ids=["y down", "y up"])
@pytest.mark.parametrize("pitch", [0, 12, 30])
@pytest.mark.parametrize("known", [True, False], ids=["depth image", "bare points"])
def test_what_a_camera_sees_stands_on_its_floor(y_down: bool, pitch: float, known: bool) -> None:
    if known and not y_down:
        pytest.skip("unprojected depth images have y down")
    points, up = kinect(pitch, y_down=y_down)
    room, T_room_local = stand(points, np.zeros(3) if known else None, camera=known)
    assert T_room_local[:3, :3] @ up == pytest.approx([0, 1, 0], abs=0.02)
    assert T_room_local[1, 3] == pytest.approx(1.6, abs=0.04)
    assert np.quantile(room[:, 1], 0.001) > -0.05
    # The camera looks into the room: what is far has smaller z.
    assert np.corrcoef(points[:, 2], room[:, 2])[0, 1] < -0.7


def test_map_coordinates_have_z_up_whatever_the_planes_say() -> None:
    wall = np.random.default_rng(0).uniform(0, 1, (4000, 3)) * [40, 0.01, 12]
    finder = RoomFinder(np.array([448_000.0, 5_411_000.0, 0.0]))
    finder.add(wall.astype(np.float32), None)
    assert finder.room(camera=False)[1, :3] == pytest.approx([0, 0, 1], abs=0.05)


def test_a_tall_room_does_not_lie_on_its_wall() -> None:
    shaft = hall() * [0.5, 0.5, 1.2]
    _, T_room_local = stand(shaft)
    assert T_room_local[1, :3] == pytest.approx([0, 0, 1], abs=0.02)


def test_what_lies_off_the_axis_was_not_seen_by_a_camera() -> None:
    _, T_room_local = stand(hall() * [0.2, 0.2, 0.2] + [0, 6, 9])
    assert T_room_local[1, :3] == pytest.approx([0, 0, 1], abs=0.02)


@pytest.mark.parametrize("points", [6, 8])
def test_the_corners_of_a_solid(points: int) -> None:
    signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T
    corners = signs if points == 8 else np.concatenate([np.eye(3), -np.eye(3)])
    room, _ = stand(corners)
    assert room[:, 1].min() == pytest.approx(0, abs=0.1)


@pytest.mark.parametrize("count", [0, 1, 3, 50])
def test_too_few_or_equal_points_still_give_a_room(count: int) -> None:
    room, T_room_local = stand(np.full((count, 3), 2.0))
    assert np.isfinite(T_room_local).all()
    assert np.abs(room).max(initial=0) < 1e-6


def test_a_ball_without_a_floor_rests_on_the_ground() -> None:
    ball = np.random.default_rng(0).normal(size=(3000, 3))
    ball *= 0.2 / np.linalg.norm(ball, axis=1, keepdims=True)
    room, _ = stand(ball)
    assert room[:, 1].min() == pytest.approx(0, abs=0.02)


def test_a_long_recording_keeps_few_samples_and_is_repeatable() -> None:
    def run() -> np.ndarray:
        finder = RoomFinder(np.zeros(3))
        for index in range(300):
            finder.add(hall(index)[::20].astype(np.float32), None)
        assert len(finder._points) <= 12
        return finder.room(camera=False)

    assert np.array_equal(run(), run())


def test_thinning_forgets_density() -> None:
    rng = np.random.default_rng(0)
    near = rng.uniform(0, 1, (9_000, 3)) * [1, 1, 0]
    far = rng.uniform(1, 2, (4_000, 3)) * [1, 1, 0]
    means = thin(np.concatenate([near, far]), cells=20)
    assert 0.5 < (means[:, 0] > 1).sum() / (means[:, 0] < 1).sum() < 2


@pytest.mark.parametrize("scene", ["dgp_scene_01", "dgp_scene_02"])
def test_a_real_lidar_stands_on_the_street(shared: Path, scene: str) -> None:
    xyz = np.load(shared / "realdata" / scene / "npz" / "0000.npz")["xyz"].astype(float)
    floor = find_floor(xyz[::7], np.zeros((0, 3)))
    assert floor.found
    assert floor.up == pytest.approx([0, 0, 1], abs=0.03)
    ring = np.linalg.norm(xyz[:, :2], axis=1)
    street = np.quantile(xyz[(ring > 4) & (ring < 10), 2], 0.2)
    assert floor.height == pytest.approx(street, abs=0.3)
