"""The object tool gets the sensor of a file's frames, and no place but a known one."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import plyfile
import pytest
from numpy.typing import NDArray

from pointbrush.cli import main
from pointbrush.samples import generate
from pointbrush.selection.objects import ObjectFrame
from pointbrush.sequences import open_sequence
from pointbrush.work.objects.frames import object_frame
from pointbrush_samples.scanning import room_scan, room_view
from pointbrush_samples.street import street

ORIGIN = (0.0, 0.0, 0.0)


@cache
def camera_points(kind: str) -> NDArray[np.float32]:
    """Points of a depth camera's frame."""
    return (room_view(3).frame if kind == "view" else generate(kind, 3, 2).frame(1)).xyz


@cache
def room_points() -> NDArray[np.float32]:
    return np.asarray(room_scan(3, points=40_000, views=6).frame.xyz)


def imported(file: Path, *options: str) -> ObjectFrame:
    """The first frame of a file as the object tool gets it after ``pointbrush import``."""
    workspace = file.parent / "workspace"
    asked = ["import", str(file), "--name", "one", "--workspace", str(workspace), *options]
    assert main(asked) == 0
    recording = open_sequence(next((workspace / "sequences").iterdir()))
    return object_frame(recording[0], recording.manifest)


def ply(path: Path, xyz: NDArray[np.floating]) -> Path:
    rows = np.rec.fromarrays(xyz.astype(np.float32).T, names="x,y,z")
    plyfile.PlyData([plyfile.PlyElement.describe(rows, "vertex")]).write(path)
    return path


def distorted(xyz: NDArray[np.floating]) -> NDArray[np.floating]:
    """Positions through a lens that is no pinhole, so that they lie on no lattice."""
    tangents = xyz[:, :2] / xyz[:, 2:]
    square = (tangents**2).sum(axis=1, keepdims=True)
    return np.hstack([tangents * (1 + 0.08 * square) * xyz[:, 2:], xyz[:, 2:]])


@pytest.mark.parametrize("kept", [4, 16])
@pytest.mark.parametrize("kind", ["tabletop", "juggling", "walking", "view"])
def test_a_depth_camera_without_a_lattice_is_one(tmp_path: Path, kind: str, kept: int) -> None:
    frame = imported(ply(tmp_path / "kinect.ply", distorted(camera_points(kind))[::kept]))
    assert frame.sensor == "camera"
    assert frame.viewpoint is not None
    assert np.allclose(frame.viewpoint, ORIGIN)


def test_a_depth_camera_is_where_its_lattice_is(tmp_path: Path) -> None:
    frame = imported(ply(tmp_path / "kinect.ply", camera_points("view")))
    assert frame.sensor == "camera"
    assert frame.viewpoint is not None
    assert np.allclose(frame.viewpoint, ORIGIN)


@pytest.mark.parametrize("about", ["middle", "corner", "floor"])
def test_a_scanned_room_has_no_place_though_the_origin_lies_in_it(
    tmp_path: Path, about: str
) -> None:
    xyz = room_points()
    low, high = xyz.min(axis=0), xyz.max(axis=0)
    origin = {"middle": (low + high) / 2, "corner": low, "floor": np.zeros(3)}[about]
    frame = imported(ply(tmp_path / "room.ply", xyz - origin))
    assert (frame.sensor, frame.viewpoint) == ("room", None)


def test_a_lidar_is_where_its_ranges_hide_nothing(tmp_path: Path) -> None:
    xyz = np.asarray(street(3).frame.xyz, np.float32)
    records = np.hstack([xyz, np.zeros((len(xyz), 1), np.float32)])
    records.astype("<f4").tofile(tmp_path / "000000.bin")
    frame = imported(tmp_path / "000000.bin", "--format", "kitti")
    assert frame.sensor == "lidar"
    assert frame.viewpoint is not None
    assert np.allclose(frame.viewpoint, ORIGIN)


def test_a_frame_with_a_pose_is_about_its_sensor(tmp_path: Path) -> None:
    xyz = np.asarray(street(4).frame.xyz, np.float32)
    behind = xyz * np.where(np.arange(len(xyz)) % 3, 1.0, 1.5)[:, None]  # of several sensors
    np.savez(tmp_path / "0.npz", xyz=behind.astype(np.float32), pose=np.eye(4))
    frame = imported(tmp_path / "0.npz")
    assert frame.sensor == "lidar"
    assert frame.viewpoint is not None
    assert np.allclose(frame.viewpoint, ORIGIN)
