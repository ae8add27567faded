"""Poses of the sensor at each frame, from files beside a recording.

``poses.txt`` of KITTI (12 or 16 numbers in each line, of the camera if ``calib.txt`` has its
mounting) and of KITTI-360 (the number of a frame before them), lines ``time x y z qx qy qz qw``
(TUM), and the OXTS folder of KITTI's raw recordings.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.formats.geometry.interpolation import Pose, interpolated
from pointbrush.formats.inside import require_inside
from pointbrush.formats.options import ReadOptions
from pointbrush.formats.tables.names import POSES
from pointbrush.formats.tables.numbers import is_number
from pointbrush.formats.times.matching import FrameName, matched, partners
from pointbrush.formats.times.timing import lines_of, natural_key, read_times, seconds_of
from pointbrush.geometry.quaternions import rotation_of

log = logging.getLogger(__name__)
CAMERA_KEYS = ("Tr", "Tr_velo_to_cam", "Tr_velo_cam")
EARTH_RADIUS = 6_378_137.0
"""Metres; radius in the projection of KITTI's development kit."""
MARKED = ({13}, {17})
"""Numbers of words in lines with a matrix after the number, time or name of a frame."""
MOST_OFF = 0.05
"""Greatest difference of a rotation's determinant from 1, which rounding causes."""


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """``T_world_frame`` (4, 4) of each frame, or None, and their file."""

    matrices: Sequence[Pose | None]
    source: str


def named_file(options: ReadOptions) -> Path | None:
    """Return the file of poses that the user named; raise NotFoundError, ForbiddenError."""
    path = options.chosen.poses_file
    if path is not None and options.limits.roots:
        require_inside([path], options.limits.roots)
    if path is not None and not path.is_file():
        raise NotFoundError(
            f"poses: expected {', '.join(POSES)} or a file, there is no {path.name}"
        )
    return path


def find_poses(
    folder: Path,
    names: Sequence[str],
    times: Sequence[float] | None,
    *,
    above: bool,
    by_order: bool = False,
) -> Poses | None:
    """Find the poses beside the files ``names`` of a folder; None if there are none.

    ``above``: also search the parent folder, as in KITTI's layouts.  Raises BadInputError for a
    file that is not a list of poses, or one that does not fit the frames.
    """
    for place in (folder, folder.parent) if above else (folder,):
        path = place / "poses.txt"
        if path.is_file():
            return read_poses(path, names, times, by_order=by_order)
    if not above:
        return None
    # dataset/sequences/00/velodyne has its poses in dataset/poses/00.txt.
    listed = folder.parent.parent.parent / "poses" / f"{folder.parent.name}.txt"
    if folder.parent.parent.name == "sequences" and listed.is_file():
        return read_poses(listed, names, times, calibration=folder.parent)
    drive = folder.parent.parent
    # KITTI-360: data_3d_raw/DRIVE/velodyne_points/data has its poses in data_poses/DRIVE.
    numbered = drive.parent.parent / "data_poses" / drive.name / "poses.txt"
    if numbered.is_file():
        return read_poses(numbered, names, times)
    if (drive / "oxts" / "data").is_dir() and folder.parent.name == "velodyne_points":
        return _of_oxts(drive, names, times)
    return None


def read_poses(
    path: Path,
    names: Sequence[str],
    times: Sequence[float] | None = None,
    *,
    by_order: bool = False,
    calibration: Path | None = None,
) -> Poses:
    """Read a file of poses, one for each of the files ``names``; poses of a camera are converted to
    the scanner, relative to the scanner of the first frame.

    Lines that begin with a time, a name or a number are matched to frames by it; poses at another
    rate than the frames are interpolated at ``times``, seconds.  ``by_order``: lines with a time
    are matched to frames by order.  ``calibration``: the folder of ``calib.txt``, by default the
    folder of the file.  Raises BadInputError for other lines.
    """
    rows = [
        (f"{path.name} line {number}", words)
        for number, line in enumerate(path.read_text("utf-8", "replace").splitlines(), start=1)
        if (words := line.split("#")[0].replace(",", " ").split())
    ]
    if rows and not any(is_number(word) for word in rows[0][1]):
        rows = rows[1:]  # a header
    if not rows:
        raise BadInputError(f"{path.name}: expected lines of poses, got none")
    widths = {len(words) for _, words in rows}
    poses: list[Pose | None]
    if widths <= {7, 8}:
        poses = [of_quaternion(where, _floats(where, words[-7:])) for where, words in rows]
    else:
        T_world_world, T_pose_frame = _mounting(path, calibration or path.parent)
        poses = [
            None if pose is None else T_world_world @ pose @ T_pose_frame
            for pose in (_matrix(where, words) for where, words in rows)
        ]
    if widths in MARKED or widths == {8}:
        return Poses(_marked(path.name, rows, poses, names, times, by_order), path.name)
    fitting = [poses[line] for line in lines_of(path.name, "poses", len(poses), names)]
    _warn_of_lost(path.name, fitting)
    return Poses(fitting, path.name)


def _matrix(where: str, words: list[str]) -> Pose | None:
    """Return the pose of a line, after its mark if it has one; None for NaN."""
    words = words[1:] if {len(words)} in MARKED else words
    return None if {word.lower() for word in words} == {"nan"} else pose_of(where, words)


def _warn_of_lost(name: str, found: Sequence[Pose | None]) -> None:
    lost = sum(pose is None for pose in found)
    if lost:
        log.warning("%s: %d of %d frames have no pose", name, lost, len(found))


def _marked(
    name: str,
    rows: list[tuple[str, list[str]]],
    poses: Sequence[Pose | None],
    names: Sequence[str],
    times: Sequence[float] | None,
    by_order: bool,
) -> list[Pose | None]:
    """Return the pose of each frame by the names, times or numbers at the start of lines.

    Poses are interpolated if the lines begin with times.
    """
    # With an ending, the decimals of a time are not read as an ending.
    marks = [FrameName(f"{words[0]}.txt") for _, words in rows]
    frames = [FrameName(file) for file in names]
    found = [] if by_order or all(mark.is_time for mark in marks) else matched(frames, marks)
    if times is not None and not any(line is not None for line in found) and not by_order:
        stamps = [seconds_of(words[0]) for _, words in rows]
        if None in stamps:
            raise BadInputError(f"{rows[stamps.index(None)][0]}: expected a time first")
        known = {
            stamp or 0.0: pose
            for stamp, pose in zip(stamps, poses, strict=True)
            if pose is not None
        }
        return interpolated(name, list(known), list(known.values()), times)
    found = partners(frames, marks, by_order=by_order)
    matching = [None if line is None else poses[line] for line in found]
    _warn_of_lost(name, matching)
    return matching


def of_quaternion(where: str, row: NDArray[np.float64]) -> Pose:
    """The pose of a row x y z qx qy qz qw; raises BadInputError naming ``where``."""
    pose = np.eye(4)
    try:
        pose[:3, :3] = rotation_of(row[3:])
    except BadInputError as error:
        raise BadInputError(f"{where}: {error}") from None
    pose[:3, 3] = row[:3]
    return pose


def _floats(where: str, words: list[str]) -> NDArray[np.float64]:
    try:
        values = np.array([float(word) for word in words])
    except ValueError:
        values = np.full(1, np.nan)
    if not np.isfinite(values).all():
        raise BadInputError(f"{where}: expected numbers, got other words")
    return values


def _mounting(path: Path, calibration: Path) -> tuple[Pose, Pose]:
    """Return the transforms before and after each matrix of a file that give the scanner's pose."""
    T_cam_velo = _keyed(calibration / "calib.txt", CAMERA_KEYS)
    if T_cam_velo is not None:
        return _inverse(T_cam_velo), T_cam_velo
    # KITTI-360: data_poses/DRIVE/poses.txt are of the vehicle, cam0_to_world.txt of a camera.
    for folder in (path.parent, path.absolute().parent.parent.parent / "calibration"):
        T_velo_cam = _keyed(folder / "calib_cam_to_velo.txt", ("",))
        T_pose_cam = _keyed(folder / "calib_cam_to_pose.txt", ("image_00",))
        if T_velo_cam is not None and path.stem.startswith("cam0"):
            return np.eye(4), _inverse(T_velo_cam)
        if T_velo_cam is not None and T_pose_cam is not None:
            return np.eye(4), T_pose_cam @ _inverse(T_velo_cam)
    log.warning(
        "%s: there is no 'Tr' in a calib.txt beside it: the poses are used as poses of the lidar; "
        "if they are poses of a camera, the frames do not match",
        path.name,
    )
    return np.eye(4), np.eye(4)


def _inverse(matrix: Pose) -> Pose:
    return np.asarray(np.linalg.inv(matrix), np.float64)


def _keyed(path: Path, keys: Sequence[str]) -> Pose | None:
    """Return the matrix of a line that begins with a key of ``keys`` and a colon; "": no key."""
    if path.is_file():
        for line in path.read_text("utf-8", "replace").splitlines():
            key, _, values = line.rpartition(":")
            if key.strip() in keys and values.strip():
                return pose_of(f"{path.name} {key.strip()}", values.split())
    return None


def pose_of(where: str, words: list[str]) -> Pose:
    """The pose of 12 or 16 numbers, by rows; raises BadInputError naming ``where``."""
    values = _floats(where, words)
    if values.size not in (12, 16):
        raise BadInputError(f"{where}: expected 12 numbers, got {len(words)} words")
    matrix = np.eye(4)
    matrix[:3] = values[:12].reshape(3, 4)
    determinant = float(np.linalg.det(matrix[:3, :3]))
    if abs(determinant + 1) < MOST_OFF:
        raise BadInputError(
            f"{where}: expected a rotation of right-handed axes, got one of left-handed axes "
            "(determinant -1); convert points and poses first, as by turning the sign of y"
        )
    if abs(determinant - 1) > MOST_OFF:
        raise BadInputError(f"{where}: expected a rotation and a translation, got another matrix")
    return matrix


# ── KITTI raw ────────────────────────────────────────────────────────────────────────────────


def rigid_of(path: Path) -> Pose | None:
    """The transform of a KITTI calibration file with lines ``R:`` and ``T:``, or None."""
    if not path.is_file():
        return None
    found = dict(re.findall(r"^(R|T): *(.+)$", path.read_text("utf-8", "replace"), re.MULTILINE))
    if set(found) != {"R", "T"}:
        return None
    matrix = np.eye(4)
    try:
        matrix[:3, :3] = np.array(found["R"].split(), np.float64).reshape(3, 3)
        matrix[:3, 3] = np.array(found["T"].split(), np.float64)
    except ValueError:
        raise BadInputError(f"{path.name}: expected R of 9 and T of 3 numbers") from None
    return matrix


def _of_oxts(drive: Path, names: Sequence[str], times: Sequence[float] | None) -> Poses:
    """Poses from the positions and angles of a GPS and inertial unit, first frame at the origin."""
    from scipy.spatial.transform import Rotation

    T_velo_imu = rigid_of(drive.parent / "calib_imu_to_velo.txt")
    if T_velo_imu is None:
        log.warning(
            "oxts: there is no calib_imu_to_velo.txt: the poses are used as poses of the lidar; "
            "they are off by the mount of the GPS unit, about a metre",
        )
        T_velo_imu = np.eye(4)
    files = sorted((drive / "oxts" / "data").glob("*.txt"), key=natural_key)
    rows = [_floats(file.name, file.read_text("utf-8", "replace").split()[:6]) for file in files]
    if not rows or any(len(row) < 6 for row in rows):
        raise BadInputError("oxts: expected files of latitude, longitude, altitude and angles")
    table = np.array(rows)
    scale = np.cos(np.radians(table[0, 0])) * EARTH_RADIUS
    latitude = np.radians(90 + np.clip(table[:, 0], -89.9, 89.9)) / 2
    position = np.stack(
        [scale * np.radians(table[:, 1]), scale * np.log(np.tan(latitude)), table[:, 2]], axis=1
    )
    T_imu_velo = np.linalg.inv(T_velo_imu)
    poses = []
    for place, angles in zip(position - position[0], table[:, 3:6], strict=True):
        T_world_imu = np.eye(4)
        T_world_imu[:3, :3] = Rotation.from_euler("ZYX", angles[::-1]).as_matrix()
        T_world_imu[:3, 3] = place
        poses.append(T_world_imu @ T_imu_velo)
    to_first = np.linalg.inv(poses[0])
    poses = [to_first @ pose for pose in poses]
    stamps = drive / "oxts" / "timestamps.txt"
    if times is not None and stamps.is_file():
        moments = read_times(stamps, [file.name for file in files])
        return Poses(interpolated("oxts", moments, poses, times), "oxts")
    found = partners([FrameName(name) for name in names], [FrameName(f.name) for f in files])
    return Poses([None if place is None else poses[place] for place in found], "oxts")
