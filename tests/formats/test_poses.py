"""Poses of frames: by name, by time and between the times of a list, or told to be absent."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pointbrush.errors import BadInputError
from pointbrush.formats import open_source, reported
from pointbrush.formats.geometry.interpolation import interpolated
from pointbrush.formats.tables.corrections import Corrections

START = 1616431234.0


def recording(folder: Path, names: Sequence[str], poses: Sequence[str]) -> Path:
    folder.mkdir()
    for k, name in enumerate(names):
        (folder / f"{name}.xyz").write_text(f"{k} 0 0\n1 1 1\n")
    (folder / "poses.txt").write_text("\n".join(poses) + "\n")
    return folder


def places(folder: Path) -> tuple[list[float | None], str]:
    """The x of each frame's pose, and what the readers warn of."""
    with reported() as warnings:
        frames = list(open_source([folder]).frames)
    found = [None if frame.pose is None else float(frame.pose[0, 3]) for frame in frames]
    return found, " ".join(warnings)


def test_a_scan_between_two_poses_lies_between_them(tmp_path: Path) -> None:
    names = [f"{START + k / 10:.2f}" for k in range(9)]
    poses = [f"{START + k / 5:.2f} {2 * k} 0 0 0 0 0 1" for k in range(5)]
    found, said = places(recording(tmp_path / "a", names, poses))
    assert found == pytest.approx(list(range(9)), abs=1e-5)
    assert not said


def test_a_turn_is_interpolated_on_the_shortest_arc() -> None:
    poses: list[NDArray[np.float64]] = []
    for degrees in (170, -170):
        pose = np.eye(4)
        pose[:3, :3] = Rotation.from_euler("z", degrees, degrees=True).as_matrix()
        poses.append(pose)
    (middle,) = interpolated("a", [0.0, 1.0], poses, [0.25])
    assert middle is not None
    angle = Rotation.from_matrix(middle[:3, :3]).as_euler("zyx", degrees=True)[0]
    assert angle == pytest.approx(175)


def test_frames_that_the_poses_do_not_reach_have_none_and_are_counted(tmp_path: Path) -> None:
    names = [f"{START + k:.2f}" for k in range(8)]
    # None before 1, and a gap between 3 and 6.
    poses = [f"{START + k:.2f} {k} 0 0 0 0 0 1" for k in (1, 2, 3, 6, 6.99)]
    found, said = places(recording(tmp_path / "a", names, poses))
    expected = [None, 1, 2, 3, None, None, 6, 6.99]
    assert [None if x is None else round(x, 6) for x in found] == expected
    assert "poses.txt: 3 of 8 frames have no pose" in said


def test_poses_of_other_times_are_told(tmp_path: Path) -> None:
    names = [f"{START + k:.2f}" for k in range(3)]
    poses = [f"{k} {k} 0 0 0 0 0 1" for k in range(3)]
    found, said = places(recording(tmp_path / "a", names, poses))
    assert found == [None] * 3
    assert "expected poses at the times of the frames, 1616431234.000 to" in said
    with pytest.raises(BadInputError, match=r"got poses of 0\.000 to 2\.000 s"):
        interpolated("p", [0.0, 2.0], [np.eye(4), np.eye(4)], [5.0])


@pytest.mark.parametrize("header", ["# time x y z qx qy qz qw", "time,x,y,z,qx,qy,qz,qw"])
@pytest.mark.parametrize("first", [1616431234000000000, 100_000_000, 7])
def test_poses_named_as_the_frames_are_theirs(tmp_path: Path, first: int, header: str) -> None:
    step = 100_000_000 if first > 10 else 1
    names = [f"{first + k * step:010d}" for k in range(4)]
    poses = [header, *(f"{first + k * step},{k},0,0,0,0,0,1" for k in range(-1, 6))]
    assert places(recording(tmp_path / "a", names, poses)) == ([0, 1, 2, 3], "")


def test_a_left_handed_pose_is_refused_as_such(tmp_path: Path) -> None:
    folder = recording(tmp_path / "a", ["0"], ["1 0 0 0 0 -1 0 0 0 0 1 0"])
    found, said = places(folder)
    assert found == [None]
    assert "right-handed axes, got one of left-handed axes (determinant -1)" in said


def numbered_poses(width: int, numbers: Sequence[int]) -> str:
    """Lines of KITTI-360: the number of a frame, and a matrix that moves it along x."""
    lines = []
    for k in numbers:
        pose = np.eye(4)
        pose[0, 3] = 10 * k
        lines.append(" ".join(map(str, [k, *pose.ravel()[:width]])))
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("width", [12, 16])
@pytest.mark.parametrize("frames", [range(6), range(2, 5), range(400, 404)])
def test_matrices_after_a_number_are_of_the_frame_of_it(
    tmp_path: Path, width: int, frames: Sequence[int]
) -> None:
    numbers = [k for k in (*range(1, 6), *range(400, 404)) if k != 3]
    names = [f"{k:010d}" for k in frames]
    found, said = places(recording(tmp_path / "a", names, [numbered_poses(width, numbers)]))
    assert found == [10 * k if k in numbers else None for k in frames]
    lost = sum(k not in numbers for k in frames)
    assert (f"{lost} of {len(frames)} frames have no pose" in said) == (lost > 0)


def test_a_line_of_nan_is_a_frame_without_a_pose(tmp_path: Path) -> None:
    lines = ["1 0 0 0 0 1 0 0 0 0 1 0", " ".join(["nan"] * 12), "1 0 0 2 0 1 0 0 0 0 1 0"]
    found, said = places(recording(tmp_path / "a", ["0", "1", "2"], lines))
    assert found == [0, None, 2]
    assert "1 of 3 frames have no pose" in said


def test_matrices_of_kitti_360_are_moved_to_the_scanner(tmp_path: Path) -> None:
    """``poses.txt`` of its layout is of the vehicle, ``cam0_to_world.txt`` of a camera."""
    drive = tmp_path / "data_3d_raw" / "drive" / "velodyne_points" / "data"
    listed, calibration = tmp_path / "data_poses" / "drive", tmp_path / "calibration"
    for folder in (drive, listed, calibration):
        folder.mkdir(parents=True)
    for k in range(3):
        np.full((4, 4), 5, np.float32).tofile(drive / f"{k:010d}.bin")
    (listed / "poses.txt").write_text(numbered_poses(12, (0, 1)))
    (listed / "cam0_to_world.txt").write_text(numbered_poses(16, (0, 1)))
    (calibration / "calib_cam_to_velo.txt").write_text("1 0 0 0.5 0 1 0 0 0 0 1 0\n")
    (calibration / "calib_cam_to_pose.txt").write_text(
        "image_00: 1 0 0 2 0 1 0 0 0 0 1 0\nimage_01: 1 0 0 9 0 1 0 0 0 0 1 0\n"
    )
    found, said = places(drive)
    assert found == [1.5, 11.5, None]
    assert "Tr" not in said
    with open_source(
        [drive], chosen=Corrections(poses=str(listed / "cam0_to_world.txt"))
    ) as source:
        poses = [frame.pose for frame in source.frames]
    assert [pose if pose is None else pose[0, 3] for pose in poses] == [-0.5, 9.5, None]
