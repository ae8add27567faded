"""Cameras and pictures of KITTI's layouts, by their calibration files."""

from __future__ import annotations

import logging
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.cameras.pictures import Camera, PictureSource, of_files, projecting
from pointbrush.formats.geometry.poses import rigid_of
from pointbrush.formats.options import Limits
from pointbrush.formats.times.matching import FrameName, partners

log = logging.getLogger(__name__)
Floats = NDArray[np.float64]
MOUNTINGS = ("Tr_velo_cam", "Tr_velo_to_cam", "Tr_velo_to_cam_0", "Tr")
"""Names of the transform from the scanner to the first camera."""
RECTIFICATIONS = ("R_rect", "R0_rect", "R_rect_00")
SIZES = {12: (3, 4), 9: (3, 3)}
PICTURES = (".png", ".jpg", ".jpeg")


def read_calibration(path: Path) -> dict[str, Floats]:
    """The matrices of a calibration file, lines ``name: 9 or 12 numbers``; others are left out."""
    found: dict[str, Floats] = {}
    for line in path.read_text("utf-8", "replace").splitlines():
        words = line.replace(":", " ").split()
        if len(words) - 1 in SIZES:
            try:
                numbers = np.array([float(word) for word in words[1:]])
            except ValueError:
                continue
            if np.isfinite(numbers).all():
                found[words[0]] = numbers.reshape(SIZES[len(numbers)])
    return found


def camera_from_velodyne(matrices: Mapping[str, Floats]) -> Floats | None:
    """``T_camera_velodyne`` (4, 4) of the first camera, rectified; None where it is not given."""
    name = next((key for key in MOUNTINGS if key in matrices), None)
    if name is None or matrices[name].shape != (3, 4):
        return None
    T_cam_velo, R_rect = np.eye(4), np.eye(4)
    T_cam_velo[:3] = matrices[name]
    for key in RECTIFICATIONS:
        if key in matrices and matrices[key].shape == (3, 3):
            R_rect[:3, :3] = matrices[key]
            break
    return np.asarray(R_rect @ T_cam_velo)


def kitti_pictures(files: Sequence[Path], folder: Path, limits: Limits) -> PictureSource | None:
    """Return the pictures beside KITTI's scans in ``folder``, or None without any.

    Supports the layouts of odometry (``calib.txt``, ``image_2``), object (``calib/000000.txt``),
    tracking (``calib/0000.txt``, ``image_02/0000``) and raw recordings (``image_02/data``).
    """
    raw = folder.parent.name == "velodyne_points"
    inner = folder.name if folder.parent.name == "velodyne" else ""
    top = folder.parent.parent if raw or inner else folder.parent
    places = {
        place.name: place / ("data" if raw else inner)
        for place in sorted(top.glob("image_*"))
        if re.fullmatch(r"image_0?[0-9]", place.name)
    }
    if not places:
        return None
    calibrations = _calibrations(files, top, inner, raw=raw)
    rows: list[dict[Camera, Path]] = [{} for _ in files]
    cameras: dict[tuple[str, int], Camera] = {}
    scans = [FrameName(file.name) for file in files]
    for name, place in places.items():
        shown = [p for p in sorted(place.glob("*")) if p.suffix.lower() in PICTURES]
        found = partners(scans, [FrameName(path.name) for path in shown]) if shown else []
        for row, matrices, picture in zip(rows, calibrations, found, strict=bool(shown)):
            if picture is not None:
                key = (name, id(matrices))
                cameras[key] = cameras.get(key) or _camera(name, matrices)
                row[cameras[key]] = shown[picture]
    named = {camera.name: camera for camera in reversed(cameras.values())}
    if named and all(camera.T_camera_frame is None for camera in named.values()):
        log.warning(
            "%s: there is no 'Tr' of the lidar in a calibration: the pictures of %s have no "
            "position, and points cannot be projected into them",
            top.name, ", ".join(sorted(named)),
        )  # fmt: skip
    return of_files(top, rows, [named[name] for name in sorted(named)], limits)


def _calibrations(
    files: Sequence[Path], top: Path, inner: str, *, raw: bool
) -> list[Mapping[str, Floats]]:
    """Return the matrices of each scan, {} without a calibration file."""
    if raw:
        path = top.parent / "calib_cam_to_cam.txt"
        matrices = read_calibration(path) if path.is_file() else {}
        mounting = rigid_of(top.parent / "calib_velo_to_cam.txt")
        if mounting is not None:
            matrices[MOUNTINGS[0]] = mounting[:3]
        return [matrices] * len(files)
    whole = [top / "calib.txt", top / "calib" / f"{inner}.txt"]
    found = next((path for path in whole if path.is_file()), None)
    if found is not None:
        return [read_calibration(found)] * len(files)
    each = [top / "calib" / f"{file.stem}.txt" for file in files]
    return [read_calibration(path) if path.is_file() else {} for path in each]


def _camera(name: str, matrices: Mapping[str, Floats]) -> Camera:
    """Return the camera ``image_N`` from its projection P_N; the last column gives its place."""
    number = int(name.removeprefix("image_"))
    P = next(
        (matrices[key] for key in (f"P{number}", f"P_rect_{number:02d}") if key in matrices), None
    )
    if P is None or P.shape != (3, 4):
        return Camera(name)
    if abs(np.linalg.det(P[:, :3])) < 1e-9:
        raise BadInputError(f"calibration: expected a projection P{number}, got a singular one")
    return projecting(name, P, camera_from_velodyne(matrices))
