"""Intrinsics of depth cameras, from files beside the images, or of known cameras."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.formats.tables.parsing import parse_json

log = logging.getLogger(__name__)
CAMERA_FILES = (
    *("camera.json", "intrinsics.json", "calibration.json", "camera_intrinsics.json"),
    # Written by Open3D's reader of Azure Kinect recordings, and its recorder of RealSense cameras.
    *("intrinsic.json", "camera_intrinsic.json"),
    *("camera.txt", "intrinsics.txt", "calibration.txt", "calib.txt", "camera-intrinsics.txt"),
    *("intrinsic_depth.txt", "intrinsic/intrinsic_depth.txt"),
)
COLOR_FILES = ("intrinsic_color.txt", "intrinsic/intrinsic_color.txt")
"""Files of the colour camera of ScanNet's scenes, written by its SensReader."""


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """Pinhole parameters in pixels."""

    fx: float
    fy: float
    cx: float
    cy: float
    scale: float | None = None
    """Depth values per metre, or None if the file does not state them."""
    source: str = ""
    """The file that states them, "" for a known camera."""
    assumed: str = ""
    """The known camera that the intrinsics are assumed from, "" if a file states them."""


@dataclass(frozen=True, slots=True)
class KnownCamera:
    """A camera with published intrinsics."""

    name: str
    width: int
    height: int
    intrinsics: Intrinsics
    folder: str = ""
    """Part of the name of a folder above its images."""
    image: str = ""
    """End of the names of its images."""


KNOWN = (
    # Calibrated colour cameras of the TUM RGB-D benchmark, which depth is registered to.
    KnownCamera("TUM RGB-D", 640, 480, Intrinsics(517.3, 516.5, 318.6, 255.3), folder="freiburg1"),
    KnownCamera("TUM RGB-D", 640, 480, Intrinsics(520.9, 521.0, 325.1, 249.7), folder="freiburg2"),
    KnownCamera("TUM RGB-D", 640, 480, Intrinsics(535.4, 539.2, 320.1, 247.6), folder="freiburg3"),
    # Depth camera, from the page of the 7-Scenes data set.
    KnownCamera("7-Scenes", 640, 480, Intrinsics(585.0, 585.0, 320.0, 240.0), image=".depth.png"),
    # Factory values of the Kinect v2's depth camera, and the Kinect v1's (ROS default).
    KnownCamera("a Kinect v2", 512, 424, Intrinsics(365.456, 365.456, 254.878, 205.395)),
    KnownCamera("a Kinect v1", 640, 480, Intrinsics(525.0, 525.0, 319.5, 239.5)),
)
"""Known cameras; the first one with matching size and names is used."""


def find_intrinsics(image: Path, width: int, height: int) -> Intrinsics:
    """Find the intrinsics of a depth image in a camera file in its folder or the two above, else
    by its size and the names.

    A file is JSON with fx, fy, cx, cy [, depth_scale], or text: ``fx fy cx cy [scale]``, or a 3x3
    or 4x4 matrix.  Raises BadInputError for a file of another form, or an unknown camera.
    """
    found = next(_stated(image.parent, CAMERA_FILES), None)
    if found is not None:
        return found
    folders = [folder.name for folder in image.parents]
    for camera in KNOWN:
        named = image.name.lower().endswith(camera.image) and (
            not camera.folder or any(camera.folder in name for name in folders)
        )
        if (width, height) == (camera.width, camera.height) and named:
            if not (camera.folder or camera.image):
                log.warning(
                    "the intrinsics are assumed, those of %s, by the size %dx%d: there is no "
                    "camera.json with fx, fy, cx, cy", camera.name, width, height,
                )  # fmt: skip
            return replace(camera.intrinsics, assumed=f"those of {camera.name}")
    raise BadInputError(
        f"{image.parent.name}: expected a camera.json with fx, fy, cx, cy for depth images of "
        f"{width}x{height}, got none"
    )


def find_color_intrinsics(image: Path) -> Intrinsics | None:
    """Find the intrinsics of the colour camera beside a depth image, or None without a file."""
    return next(_stated(image.parent, COLOR_FILES), None)


def _stated(folder: Path, names: tuple[str, ...]) -> Iterator[Intrinsics]:
    for place in (folder, *list(folder.parents)[:2]):
        for name in names:
            if (place / name).is_file():
                yield _parse(place / name)


def _parse(path: Path) -> Intrinsics:
    expected = f"{path.name}: expected fx, fy, cx, cy [, depth_scale], or a 3x3 or 4x4 matrix"
    text = path.read_text("utf-8", "replace")
    try:
        numbers = _of_json(text) if path.suffix == ".json" else _of_text(text)
    except (ValueError, KeyError, TypeError, AttributeError):
        raise BadInputError(f"{expected}, got another form") from None
    right = len(numbers) in (4, 5) and np.isfinite(numbers).all()
    if not right or min(*numbers[:2], *numbers[4:]) <= 0:
        raise BadInputError(f"{expected} with positive fx, fy and scale, got others")
    fx, fy, cx, cy = numbers[:4]
    return Intrinsics(fx, fy, cx, cy, numbers[4] if len(numbers) > 4 else None, path.name)


def _of_json(text: str) -> list[float]:
    document = parse_json(text)
    if isinstance(document.get("intrinsic_matrix"), list):
        # Open3D writes the matrix by columns.
        matrix = np.array(document["intrinsic_matrix"], np.float64).reshape(3, 3).T
        numbers = [matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]]
    else:
        numbers = [float(document[key]) for key in ("fx", "fy", "cx", "cy")]
    return numbers + [float(document[key]) for key in ("depth_scale",) if key in document]


def _of_text(text: str) -> list[float]:
    lines = [line.split("#")[0].replace(",", " ") for line in text.splitlines()]
    numbers = [float(word) for line in lines for word in line.split()]
    side = {9: 3, 16: 4}.get(len(numbers))
    return [numbers[i] for i in (0, side + 1, 2, side + 2)] if side else numbers
