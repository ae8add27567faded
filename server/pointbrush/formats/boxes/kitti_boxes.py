"""Boxes of KITTI's text (object and tracking) and of the tracklets of its raw recordings."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.boxes.conventions import box_by
from pointbrush.formats.boxes.documents import lines_of_words
from pointbrush.formats.boxes.editors import labelcloud_format
from pointbrush.formats.boxes.figures import FrameBox, FrameBoxes
from pointbrush.formats.cameras.kitti_cameras import camera_from_velodyne, read_calibration
from pointbrush.formats.geometry.poses import rigid_of
from pointbrush.formats.options import read_bytes
from pointbrush.formats.tables.parsing import parse_xml

Floats = NDArray[np.float64]
CALIBRATIONS = ("calib.txt", "calib_velo_to_cam.txt")
IGNORED = "dontcare"
OBJECT_WORDS = 15
"""Values of a line of KITTI's object labels."""
TRACKING_WORDS = 17
"""Values of a line of KITTI's tracking labels: frame and track, then the values of an object."""
ATTRIBUTES = {"truncated": 1, "occluded": 2}
"""Attributes by the places of their words in an object's line."""
MOST_TRUNCATED = 2
"""The highest level of truncation in tracking's text: largely outside the picture."""
FRAME_LIST = "frame_list.txt"
"""CVAT's file beside its tracklets: number of a frame and its name a line."""
OUTSIDE = ("2", "99")
"""Values of ``truncation`` by which CVAT fills the gaps of a track."""


def read_kitti_object(path: Path) -> Iterator[FrameBoxes]:
    """Read ``label_2/000000.txt``: the boxes of one frame, in the camera's coordinates.

    labelCloud's ``kitti_untransformed`` has centres in the points' coordinates instead.
    """
    untransformed = labelcloud_format(path) == "kitti_untransformed"
    tool = "kitti-untransformed" if untransformed else "kitti"
    # The converter of Waymo's data adds the camera and the object's key.
    boxes = tuple(
        _box(tool, words, words[16] if len(words) > 16 else "")
        for words in _lines(path, OBJECT_WORDS)
    )
    found = FrameBoxes(None, boxes)
    yield found if untransformed else found.moved_back(_camera_from_velodyne(path))


def read_kitti_tracking(path: Path) -> Iterator[FrameBoxes]:
    """Read ``label_02/0000.txt``: the boxes of all frames, in the camera's coordinates."""
    T_cam_velo = _camera_from_velodyne(path)
    frames: dict[int, list[FrameBox]] = {}
    for words in _lines(path, TRACKING_WORDS):
        # A track keeps its number, except 0, which means no instance: it gets a free number.
        box = _box("kitti", words[2:], words[1] if int(words[1]) >= 0 else "", MOST_TRUNCATED)
        frames.setdefault(int(words[0]), []).append(box)
    for frame, boxes in sorted(frames.items()):
        yield FrameBoxes(frame, tuple(boxes), numbered=True).moved_back(T_cam_velo)


def _lines(path: Path, count: int) -> Iterator[list[str]]:
    """Split the lines into words, without the lines of unlabelled regions."""
    for words in lines_of_words(path, count):
        if words[count - OBJECT_WORDS].lower() != IGNORED:
            yield words


def _box(tool: str, words: list[str], key: str, most_truncated: float = 1.0) -> FrameBox:
    """Build the box of an object's words: size h w l, place, angle.

    A negative truncation or occlusion is unknown: the box lacks the attribute.
    """
    numbers = np.array([float(word) for word in words[8:15]])
    attributes = {name: float(words[place]) for name, place in ATTRIBUTES.items()}
    attributes["truncated"] /= most_truncated
    attributes = {name: value for name, value in attributes.items() if value >= 0}
    return box_by(
        tool, words[0], key, numbers[3:6], numbers[:3], numbers[6:], attributes=attributes
    )


def read_kitti_tracklets(path: Path) -> Iterator[FrameBoxes]:
    """Read tracklets, in the scanner's coordinates.

    Tracklets of KITTI have length, width and height along x, y and z, and the middle of the bottom;
    tracklets of CVAT have sizes along x, y and z as ``w``, ``h`` and ``l``, and the centre.
    """
    root = _tracklets(path)
    names = _frame_names(path)
    by_cvat = bool(names) or root.findtext("./tracklets/item/poses/item_version") == "0"
    frames: dict[int, list[FrameBox]] = {}
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
            tool = "tracklets-cvat" if by_cvat else "tracklets"
            box = box_by(tool, _text(item, "objectType"), str(number), place, size, angles)
            frames.setdefault(first + step, []).append(box)
    for frame, boxes in sorted(frames.items()):
        yield FrameBoxes(names.get(frame, frame), tuple(boxes), numbered=True)


def _tracklets(path: Path) -> ElementTree.Element:
    try:
        return parse_xml(read_bytes(path))
    except ValueError as error:
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
