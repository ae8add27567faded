"""Folders of depth and colour images: the TUM RGB-D layout, and pairs of images (Kinect v2)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pointbrush.errors import BadInputError
from pointbrush.formats.depth import Intrinsics, depth_frame, find_intrinsics
from pointbrush.formats.listing import FrameFile, Listing
from pointbrush.formats.options import Extras, ReadOptions
from pointbrush.formats.poses import of_quaternion
from pointbrush.formats.timing import (
    natural_key,
    rate_of,
    stated_rate,
    times_of,
)
from pointbrush.frame import PointFrame

IMAGES = (".png", ".tif", ".tiff", ".pgm", ".jpg", ".jpeg", ".bmp", ".ppm")
DEPTH_IMAGES = (".png", ".tif", ".tiff", ".pgm")
DEPTH_FOLDERS = ("depth", "depth_raw", "depths")
COLOR_FOLDERS = ("rgb", "color", "colour", "colors", "registered", "image", "images")
# Files of one moment: the TUM benchmark's tools pair within 20 ms.
NEAR = 0.02
TUM_SCALE = 5000.0


@dataclass(frozen=True, slots=True)
class Pair:
    """The images of one moment."""

    depth: Path
    color: Path | None
    time: float | None = None


@dataclass(frozen=True, slots=True)
class Camera:
    """The camera of a recording: the size of its first depth image, which all must have."""

    size: tuple[int, int]
    intrinsics: Intrinsics


def list_rgbd(folder: Path) -> Listing | None:
    """The depth images of a folder with their colours as frames; None if it has no such layout.

    TUM RGB-D: ``depth.txt`` and ``rgb.txt`` list times and files, ``groundtruth.txt`` poses.
    Otherwise: a ``depth`` and a ``color`` (``rgb``) folder, or files named so, in natural order.
    Raises BadInputError when lists do not fit, or numbers of images differ.
    """
    tum = (folder / "depth.txt").is_file() and (folder / "rgb.txt").is_file()
    pairs = _tum_pairs(folder) if tum else _paired(folder)
    if not pairs:
        return None
    times = [pair.time for pair in pairs if pair.time is not None]
    known = times if len(times) == len(pairs) else None
    poses = _poses(folder / "groundtruth.txt", known)
    camera = _camera(pairs[0].depth, TUM_SCALE if tum else None)
    frames = [
        FrameFile(
            partial(_read, pair, camera),
            Extras(timestamp=pair.time, pose=poses[i] if poses else None),
        )
        for i, pair in enumerate(pairs)
    ]
    return Listing("rgbd", frames, known, rate_of(known) or stated_rate(folder), len(frames))


def _read(pair: Pair, camera: Camera, options: ReadOptions) -> Iterator[PointFrame]:
    frame = depth_frame(pair.depth, pair.color, camera.intrinsics, options)
    if frame.camera and (frame.camera.width, frame.camera.height) != camera.size:
        raise BadInputError(
            f"{pair.depth.name}: expected a depth image of {camera.size[0]}x{camera.size[1]} as "
            f"the first, got {frame.camera.width}x{frame.camera.height}"
        )
    yield frame


def _camera(depth: Path, scale: float | None) -> Camera:
    try:
        with Image.open(depth) as image:
            size = image.size
    except (OSError, ValueError, SyntaxError) as error:
        reason = str(error).split("\n")[0][:120]
        raise BadInputError(f"{depth.name}: expected a depth image, {reason}") from None
    return Camera(size, find_intrinsics(depth.parent, *size, scale))


# ── TUM RGB-D ────────────────────────────────────────────────────────────────────────────────


def _tum_pairs(folder: Path) -> list[Pair]:
    depths, colors = _timed(folder, "depth.txt"), _timed(folder, "rgb.txt")
    if not depths or not colors:
        raise BadInputError(f"{folder.name}: expected lines in depth.txt and rgb.txt, got none")
    moments = np.array([time for time, _ in colors])
    pairs = []
    for time, depth in depths:
        nearest = int(np.argmin(np.abs(moments - time)))
        if abs(moments[nearest] - time) <= NEAR:
            pairs.append(Pair(depth, colors[nearest][1], time))
    if not pairs:
        raise BadInputError(
            f"{folder.name}: expected depth and colour images within {NEAR} s, got none"
        )
    return pairs


def _timed(folder: Path, name: str) -> list[tuple[float, Path]]:
    """Lines ``time file``, by time; raises BadInputError for other lines or absent files."""
    rows = []
    for number, words in _rows(folder / name):
        try:
            time, path = float(words[0]), folder / words[1]
        except (ValueError, IndexError):
            raise BadInputError(
                f"{name} line {number}: expected a time and a file, got another line"
            ) from None
        if not np.isfinite(time) or not path.resolve().is_relative_to(folder.resolve()):
            raise BadInputError(f"{name} line {number}: expected a file within {folder.name}")
        if not path.is_file():
            raise BadInputError(f"{name} line {number}: its file is absent")
        rows.append((time, path))
    return sorted(rows)


def _rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    for number, line in enumerate(path.read_text("utf-8", "replace").splitlines(), start=1):
        words = line.split("#")[0].split()
        if words:
            yield number, words


def _poses(path: Path, times: list[float] | None) -> list[NDArray[np.float64]] | None:
    """``T_world_camera`` nearest to each time from lines ``t tx ty tz qx qy qz qw``, or None."""
    if times is None or not path.is_file():
        return None
    rows = []
    for number, words in _rows(path):
        try:
            row = [float(word) for word in words[:8]]
        except ValueError:
            row = []
        if len(row) != 8 or not np.isfinite(row).all() or not any(row[4:]):
            raise BadInputError(f"{path.name} line {number}: expected a time and a pose")
        rows.append(row)
    table = np.array(sorted(rows)).reshape(-1, 8)
    poses = []
    for time in times:
        nearest = int(np.argmin(np.abs(table[:, 0] - time))) if len(table) else 0
        if not len(table) or abs(table[nearest, 0] - time) > 10 * NEAR:
            return None
        poses.append(of_quaternion(path.name, table[nearest, 1:8]))
    return poses


# ── pairs of images ──────────────────────────────────────────────────────────────────────────


def _paired(folder: Path) -> list[Pair]:
    inner = {path.name.lower(): path for path in folder.iterdir() if path.is_dir()}
    depth_folder = next((inner[name] for name in DEPTH_FOLDERS if name in inner), None)
    color_folder = next((inner[name] for name in COLOR_FOLDERS if name in inner), None)
    if depth_folder is not None:
        depths = _images(depth_folder, DEPTH_IMAGES)
        colors = _images(color_folder, IMAGES) if color_folder else []
    else:
        images = _images(folder, IMAGES)
        depths = [p for p in images if "depth" in p.stem.lower() and p.suffix.lower() != ".jpg"]
        colors = [p for p in images if re.search(r"rgb|colou?r", p.stem.lower())]
    if not depths:
        return []
    if colors and len(colors) != len(depths):
        raise BadInputError(
            f"{folder.name}: expected a colour image for each of {len(depths)} depth images, got "
            f"{len(colors)}"
        )
    times = times_of(depths, depth_folder or folder)
    pairs = [
        Pair(depth, colors[i] if colors else None, times[i] if times else None)
        for i, depth in enumerate(depths)
    ]
    return sorted(pairs, key=lambda pair: pair.time or 0.0) if times else pairs


def _images(folder: Path, endings: tuple[str, ...]) -> list[Path]:
    found = (path for path in folder.iterdir() if path.suffix.lower() in endings)
    return sorted((path for path in found if not path.name.startswith(".")), key=natural_key)
