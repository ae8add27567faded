"""Boxes of KITTI's text (object and tracking) and of the tracklets of its raw recordings."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.boxes.documents import lines_of_words
from pointbrush.formats.boxes.editors import labelcloud_format
from pointbrush.formats.boxes.figures import Box, FrameBoxes
from pointbrush.formats.boxes.rotations import euler_matrix
from pointbrush.formats.kitti_cameras import camera_from_velodyne, read_calibration
from pointbrush.formats.options import read_bytes
from pointbrush.formats.poses import rigid_of

Floats = NDArray[np.float64]
CALIBRATIONS = ("calib.txt", "calib_velo_to_cam.txt")
IGNORED = "dontcare"
OBJECT_WORDS = 15
"""Values of a line of KITTI's object labels."""
TRACKING_WORDS = 17
"""Values of a line of KITTI's tracking labels: frame and track, then those of an object."""
FRAME_LIST = "frame_list.txt"
"""CVAT's file beside its tracklets: number of a frame and its name a line."""
OUTSIDE = ("2", "99")
"""Values of ``truncation`` by which CVAT fills the gaps of a track."""


def read_kitti_object(path: Path) -> Iterator[FrameBoxes]:
    """Read ``label_2/000000.txt``: the boxes of one frame, in the camera's coordinates.

    labelCloud's ``kitti_untransformed`` has centres in the points' coordinates instead.
    """
    if labelcloud_format(path) == "kitti_untransformed":
        boxes = [_untransformed(words) for words in _lines(path, OBJECT_WORDS)]
    else:
        T_velo_cam = np.asarray(np.linalg.inv(_camera_from_velodyne(path)), np.float64)
        boxes = [
            # The converter from Waymo adds the camera and the object's key.
            _of_camera(words, words[16] if len(words) > 16 else "", T_velo_cam)
            for words in _lines(path, OBJECT_WORDS)
        ]
    yield FrameBoxes(None, tuple(boxes))


def read_kitti_tracking(path: Path) -> Iterator[FrameBoxes]:
    """Read ``label_02/0000.txt``: the boxes of all frames, in the camera's coordinates."""
    T_velo_cam = np.asarray(np.linalg.inv(_camera_from_velodyne(path)), np.float64)
    frames: dict[int, list[Box]] = {}
    for words in _lines(path, TRACKING_WORDS):
        # Numbers of tracks count from 0, and 0 is no instance; -1 is no track.
        track = int(words[1])
        box = _of_camera(words[2:], str(track + 1) if track >= 0 else "", T_velo_cam)
        frames.setdefault(int(words[0]), []).append(box)
    yield from (FrameBoxes(frame, tuple(boxes)) for frame, boxes in sorted(frames.items()))


def _lines(path: Path, count: int) -> Iterator[list[str]]:
    """Split the lines into words; those of regions that nobody labelled are left out."""
    for words in lines_of_words(path, count):
        if words[count - OBJECT_WORDS].lower() != IGNORED:
            yield words


def _of_camera(words: list[str], key: str, T_velo_cam: Floats) -> Box:
    """Build the box of an object's words: size h w l, the bottom's middle, the angle about y."""
    height, width, length, x, y, z, turn = (float(word) for word in words[8:15])
    center = T_velo_cam[:3, :3] @ [x, y - height / 2, z] + T_velo_cam[:3, 3]
    rotation = T_velo_cam[:3, :3] @ euler_matrix(np.array([0.0, turn, 0.0]), "zyx")
    return Box(words[0], key, center, np.array([length, height, width]), rotation)


def _untransformed(words: list[str]) -> Box:
    height, width, length, x, y, z, turn = (float(word) for word in words[8:15])
    rotation = euler_matrix(np.array([0.0, 0.0, turn]), "zyx")
    return Box(words[0], "", np.array([x, y, z]), np.array([length, width, height]), rotation)


def read_kitti_tracklets(path: Path) -> Iterator[FrameBoxes]:
    """Read tracklets, in the scanner's coordinates.

    KITTI's have length, width and height along x, y and z, and the middle of the bottom; CVAT's
    have its sizes along x, y and z as ``w``, ``h`` and ``l``, and the centre.
    """
    root = _tracklets(path)
    names = _frame_names(path)
    by_cvat = bool(names) or root.findtext("./tracklets/item/poses/item_version") == "0"
    frames: dict[int, list[Box]] = {}
    for number, item in enumerate(root.findall("./tracklets/item"), start=1):
        size = np.array([float(_text(item, name)) for name in ("whl" if by_cvat else "lwh")])
        first = int(_text(item, "first_frame"))
        for step, pose in enumerate(item.findall("./poses/item")):
            if by_cvat and pose.findtext("truncation") in OUTSIDE:
                continue
            place = np.array([float(_text(pose, f"t{axis}")) for axis in "xyz"])
            angles = np.array([float(_text(pose, f"r{axis}")) for axis in "xyz"])
            if not np.isfinite([*place, *angles, *size]).all():
                raise BadInputError(f"{path.name}: expected finite numbers in item {number}")
            rotation = euler_matrix(angles, "xyz" if by_cvat else "zyx")
            center = place if by_cvat else place + rotation[:, 2] * size[2] / 2
            box = Box(_text(item, "objectType"), str(number), center, size, rotation)
            frames.setdefault(first + step, []).append(box)
    for frame, boxes in sorted(frames.items()):
        yield FrameBoxes(names.get(frame, frame), tuple(boxes))


def _tracklets(path: Path) -> ElementTree.Element:
    data = read_bytes(path)
    if b"<!ENTITY" in data:
        raise BadInputError(f"{path.name}: expected tracklets, got XML with entities of its own")
    try:
        return ElementTree.fromstring(data)  # noqa: S314 – without entities
    except ElementTree.ParseError as error:
        raise BadInputError(f"{path.name}: expected tracklets as XML: {error}") from None


def _frame_names(path: Path) -> dict[int, str]:
    beside = path.parent / FRAME_LIST
    if not beside.is_file():
        return {}
    lines = [line.split(maxsplit=1) for line in beside.read_text("utf-8").splitlines()]
    return {int(words[0]): words[1] for words in lines if len(words) == 2 and words[0].isdigit()}


def _text(element: ElementTree.Element, name: str) -> str:
    found = element.findtext(name)
    if found is None:
        raise ValueError(name)
    return found.strip()


def _camera_from_velodyne(path: Path) -> Floats:
    """Find ``T_camera_velodyne`` (4, 4), rectified, in the calibration beside a label file."""
    for folder in (path.parent, path.parent.parent):
        for place in (*(folder / name for name in CALIBRATIONS), folder / "calib" / path.name):
            if place.is_file():
                return _calibration(place)
    raise BadInputError(
        f"{path.name}: expected a calibration with 'Tr_velo_cam' beside it (calib.txt, or "
        f"calib/{path.name}): its boxes are in the camera's coordinates"
    )


def _calibration(path: Path) -> Floats:
    found = camera_from_velodyne(read_calibration(path))
    found = rigid_of(path) if found is None else found
    if found is None:
        raise BadInputError(f"{path.name}: expected a line 'Tr_velo_cam' of 12 numbers, got none")
    return found
