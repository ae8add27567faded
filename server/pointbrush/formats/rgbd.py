"""Depth images with their colour images: TUM RGB-D, and pairs of images (Kinect v2).

Points are in the depth camera's axes: x right, y down, z forward.  Pixels without depth (0) are
missing measurements and left out.
"""

from __future__ import annotations

import io
import json
import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.formats.listing import FrameFile, Listing
from pointbrush.formats.options import Extras, ReadOptions, read_bytes
from pointbrush.formats.poses import of_quaternion
from pointbrush.formats.timing import (
    natural_key,
    rate_of,
    stated_rate,
    times_of,
)
from pointbrush.frame import DepthCamera, PointFrame

MAX_PIXELS = 64_000_000
# Factory values of the Kinect v2's depth camera, and of the Kinect v1 / TUM RGB-D (ROS default).
KINECT_2 = (512, 424, 365.456, 365.456, 254.878, 205.395)
KINECT_1 = (640, 480, 525.0, 525.0, 319.5, 239.5)
# Calibrated colour cameras of the TUM RGB-D benchmark, which depth is registered to.
FREIBURG = {
    "freiburg1": (517.3, 516.5, 318.6, 255.3),
    "freiburg2": (520.9, 521.0, 325.1, 249.7),
    "freiburg3": (535.4, 539.2, 320.1, 247.6),
}
CAMERA_FILES = (
    *("camera.json", "intrinsics.json", "calibration.json", "camera_intrinsics.json"),
    *("camera.txt", "intrinsics.txt", "calibration.txt", "calib.txt", "camera-intrinsics.txt"),
)
IMAGES = (".png", ".tif", ".tiff", ".pgm", ".jpg", ".jpeg", ".bmp", ".ppm")
DEPTH_IMAGES = (".png", ".tif", ".tiff", ".pgm")
DEPTH_FOLDERS = ("depth", "depth_raw", "depths")
COLOR_FOLDERS = ("rgb", "color", "colour", "colors", "registered", "image", "images")
# Files of one moment: the TUM benchmark's tools pair within 20 ms.
NEAR = 0.02
TUM_SCALE = 5000.0


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """Pinhole parameters in pixels, and ``scale``: depth values per metre."""

    fx: float
    fy: float
    cx: float
    cy: float
    scale: float


def read_depth(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """A single depth image (16 bits) without colour; intrinsics from a file beside it."""
    yield depth_frame(path, None, None, options)


def depth_frame(
    depth_path: Path, color_path: Path | None, intrinsics: Intrinsics | None, options: ReadOptions
) -> PointFrame:
    """The valid pixels of a depth image as points.

    A colour image of another size but the same shape is sampled at the nearest pixel.  Raises
    BadInputError for damaged images, depth that is not 16 bits, or colour of another shape.
    """
    depth = _depth_image(depth_path)
    height, width = depth.shape
    known = intrinsics or find_intrinsics(depth_path.parent, width, height)
    pixel = np.flatnonzero(depth)
    z = depth.reshape(-1)[pixel].astype(np.float32) / np.float32(known.scale)
    v, u = np.divmod(pixel, width)
    xyz = np.empty((len(pixel), 3), np.float32)
    xyz[:, 0] = (u - known.cx) * z / known.fx
    xyz[:, 1] = (v - known.cy) * z / known.fy
    xyz[:, 2] = z
    return PointFrame(
        xyz=xyz,
        rgb=None if color_path is None else _colors(color_path, pixel, width, height),
        pose=options.known.pose,
        timestamp=options.known.timestamp,
        viewpoint=np.zeros(3),
        dropped=depth.size - len(pixel),
        camera=DepthCamera(width, height, known.fx, known.fy, known.cx, known.cy),
        pixel=pixel.astype(np.uint32),
        rows=None if len(pixel) == depth.size else pixel.astype(np.int64),
    )


def _image(path: Path) -> Image.Image:
    data = read_bytes(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            image = Image.open(io.BytesIO(data))
            if image.width * image.height > MAX_PIXELS:
                raise TooLargeError(
                    f"{path.name}: expected at most {MAX_PIXELS} pixels, got "
                    f"{image.width}x{image.height}"
                )
            image.load()
    except TooLargeError:
        raise
    # Decoders of many formats raise errors of many kinds for damaged data.
    except Exception as error:
        reason = str(error).split("\n")[0][:120] or type(error).__name__
        raise BadInputError(f"{path.name}: expected a whole image, {reason}") from None
    return image


def _depth_image(path: Path) -> NDArray[Any]:
    image = _image(path)
    depth = np.asarray(image)
    if depth.ndim != 2 or image.mode not in ("I;16", "I;16B", "I;16L", "I", "F"):
        raise BadInputError(
            f"{path.name}: expected a depth image of one channel with 16 bits, got mode "
            f"{image.mode}"
        )
    if depth.dtype.kind == "f":
        return np.where(np.isfinite(depth) & (depth > 0), depth, 0)
    if int(depth.min(initial=0)) < 0:
        raise BadInputError(f"{path.name}: expected depths of 0 or more, got {depth.min()}")
    return depth


def _colors(path: Path, pixel: NDArray[np.int64], width: int, height: int) -> NDArray[np.uint8]:
    image = _image(path)
    if image.width * height != image.height * width:
        raise BadInputError(
            f"{path.name}: expected a colour image of the depth image's shape "
            f"{width}x{height} (registered to it), got {image.width}x{image.height}"
        )
    color = np.asarray(image.convert("RGB"))
    if image.width == width:
        return color.reshape(-1, 3)[pixel]
    v, u = np.divmod(pixel, width)
    step = image.width / width
    return color[((v + 0.5) * step).astype(np.int64), ((u + 0.5) * step).astype(np.int64)]


def find_intrinsics(
    folder: Path, width: int, height: int, scale: float | None = None
) -> Intrinsics:
    """From a camera file in the folder or the two above, else by the size of the images.

    A file is JSON with fx, fy, cx, cy [, depth_scale], or text: ``fx fy cx cy [scale]`` or a
    3x3 matrix.  ``scale`` is that of the layout, where the file does not say.
    Raises BadInputError for a file of another form, or images of an unknown camera.
    """
    for place in (folder, *list(folder.parents)[:2]):
        for name in CAMERA_FILES:
            if (place / name).is_file():
                return _parse(place / name, scale)
    named = [v for k, v in FREIBURG.items() for p in (folder, *folder.parents) if k in p.name]
    for size_x, size_y, *pinhole in (KINECT_2, KINECT_1):
        if (width, height) == (size_x, size_y):
            fx, fy, cx, cy = named[0] if named and width == 640 else pinhole
            return Intrinsics(fx, fy, cx, cy, scale or 1000.0)
    raise BadInputError(
        f"{folder.name}: expected a camera.json with fx, fy, cx, cy for depth images of "
        f"{width}x{height}, got none"
    )


def _parse(path: Path, scale: float | None) -> Intrinsics:
    expected = f"{path.name}: expected fx, fy, cx, cy [, depth_scale] or a 3x3 matrix"
    text = path.read_text("utf-8", "replace")
    try:
        if path.suffix == ".json":
            document = json.loads(text)
            if isinstance(document.get("intrinsic_matrix"), list):
                # Open3D writes the matrix by columns.
                matrix = np.array(document["intrinsic_matrix"], np.float64).reshape(3, 3).T
                numbers = [matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]]
            else:
                numbers = [float(document[key]) for key in ("fx", "fy", "cx", "cy")]
            numbers.append(float(document.get("depth_scale", scale or 1000.0)))
        else:
            lines = [line.split("#")[0].replace(",", " ") for line in text.splitlines()]
            numbers = [float(word) for line in lines for word in line.split()]
            if len(numbers) == 9:
                numbers = [numbers[0], numbers[4], numbers[2], numbers[5]]
            if len(numbers) == 4:
                numbers.append(scale or 1000.0)
    except (ValueError, KeyError, TypeError, AttributeError):
        raise BadInputError(f"{expected}, got another form") from None
    if len(numbers) != 5 or not np.isfinite(numbers).all() or min(*numbers[:2], numbers[4]) <= 0:
        raise BadInputError(f"{expected} with positive fx, fy and scale, got others")
    return Intrinsics(*numbers)


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
