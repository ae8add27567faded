"""Boxes made elsewhere: labelCloud, SUSTechPOINTS, Supervisely episodes, KITTI tracking.

A box's axes are those of its own length, width and height; places are in the points' coordinates.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.kitti_cameras import camera_from_velodyne, read_calibration
from pointbrush.formats.options import read_bytes
from pointbrush.formats.poses import rigid_of

Floats = NDArray[np.float64]
CALIBRATIONS = ("calib.txt", "calib_velo_to_cam.txt")
IGNORED = {"dontcare"}


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """``center`` (3,) and ``size`` (3,) full edges, metres; ``rotation`` (3, 3) axes as columns;
    ``instance`` a number that its object keeps, 0 for none; ``label`` the id of the label of ours
    that it is of, 0 for others."""

    name: str
    instance: int
    center: Floats
    size: Floats
    rotation: Floats
    label: int = 0

    def inside(self, xyz: Floats) -> NDArray[np.bool_]:
        """Return which points (N, 3) are in the box."""
        local = np.abs((xyz - self.center) @ self.rotation)
        return np.asarray((local <= self.size / 2).all(axis=1))


@dataclass(frozen=True, slots=True, eq=False)
class FrameBoxes:
    """Boxes of a frame; ``frame`` None where the file's name tells it."""

    frame: int | None
    boxes: tuple[Box, ...]


def read_boxes(path: Path, format: str) -> list[FrameBoxes]:
    """Return the boxes of one file.  Raises BadInputError naming it."""
    try:
        return list(BOX_READERS[format](path))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        if isinstance(error, BadInputError):
            raise
        raise BadInputError(f"{path.name}: expected {format} boxes, got another file") from None


def is_box_file(path: Path, format: str) -> bool:
    """Return whether a file is of a format of boxes, by its first bytes."""
    lower = path.name.lower()
    if format == "kitti-tracking":
        return lower.endswith(".txt") and _KITTI.match(_start(path)) is not None
    if format == "kitti-tracklets":
        return lower.endswith(".xml") and "<tracklets" in _start(path)
    return lower.endswith(".json") and all(word in _start(path) for word in MARKS[format])


def _start(path: Path) -> str:
    with path.open("rb") as file:
        return file.read(1 << 16).decode("utf-8", "replace")


MARKS = {
    "labelcloud": ('"objects"', '"centroid"', '"dimensions"'),
    "sustechpoints": ('"psr"', '"obj_type"'),
    "supervisely": ('"figures"', '"objectKey"'),
    "boxes": ('"boxes"', '"upright"'),
}
"""Words by which a JSON file is told."""
_KITTI = re.compile(r"\d+ -?\d+ [A-Za-z_]+ -?[\d.]+ -?\d+( -?[\d.eE+-]+){12}")


def _document(path: Path) -> Any:
    return json.loads(read_bytes(path).decode("utf-8-sig"))


def _vector(values: Any, keys: Iterable[Any] = "xyz") -> Floats:
    vector = np.array([float(values[key]) for key in keys])
    if not np.isfinite(vector).all():
        raise ValueError(values)
    return vector


def _turned(angles: Floats) -> Floats:
    """Rotation of angles about x, y, z, radians, applied in that order."""
    x, y, z = angles
    cx, sx, cy, sy, cz, sz = np.cos(x), np.sin(x), np.cos(y), np.sin(y), np.cos(z), np.sin(z)
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)


def _turned_about_own_axes(angles: Floats) -> Floats:
    """Rotation Rx Ry Rz of angles about x, y, z, radians, as three.js's order XYZ has it."""
    return _turned(-angles).T


def _labelcloud(path: Path) -> Iterator[FrameBoxes]:
    boxes = []
    for entry in _document(path)["objects"]:
        size = np.array([float(entry["dimensions"][k]) for k in ("length", "width", "height")])
        angles = np.radians(_vector(entry["rotations"]))
        boxes.append(Box(str(entry["name"]), 0, _vector(entry["centroid"]), size, _turned(angles)))
    yield FrameBoxes(None, tuple(boxes))


def _sustechpoints(path: Path) -> Iterator[FrameBoxes]:
    document = _document(path)
    entries = document["objs"] if isinstance(document, dict) else document
    boxes = []
    for entry in entries:
        place = entry["psr"]
        digits = re.sub(r"\D", "", str(entry.get("obj_id") or ""))
        boxes.append(
            Box(
                str(entry["obj_type"]),
                int(digits[:9] or 0),
                _vector(place["position"]),
                _vector(place["scale"]),
                _turned_about_own_axes(_vector(place["rotation"])),
            )
        )
    yield FrameBoxes(None, tuple(boxes))


def _supervisely(path: Path) -> Iterator[FrameBoxes]:
    document = _document(path)
    objects = {entry["key"]: entry["classTitle"] for entry in document["objects"]}
    numbers = {key: k + 1 for k, key in enumerate(objects)}
    frames = document.get("frames", [{**document, "index": None}])
    for entry in frames:
        boxes = []
        for figure in entry["figures"]:
            key, place = figure["objectKey"], figure["geometry"]
            boxes.append(
                Box(
                    str(objects[key]),
                    numbers[key],
                    _vector(place["position"]),
                    _vector(place["dimensions"]),
                    _turned(_vector(place["rotation"])),
                )
            )
        yield FrameBoxes(None if entry["index"] is None else int(entry["index"]), tuple(boxes))


def _kitti_tracking(path: Path) -> Iterator[FrameBoxes]:
    T_velo_cam = np.linalg.inv(_camera_from_velodyne(path))
    frames: dict[int, list[Box]] = {}
    for number, line in enumerate(read_bytes(path).decode("utf-8", "replace").splitlines(), 1):
        words = line.split()
        if not words:
            continue
        if len(words) < 17:
            raise BadInputError(f"{path.name} line {number}: expected 17 values, got {len(words)}")
        if words[2].lower() in IGNORED:
            continue
        height, width, length, x, y, z, turn = (float(word) for word in words[10:17])
        center = T_velo_cam[:3, :3] @ [x, y - height / 2, z] + T_velo_cam[:3, 3]
        rotation = T_velo_cam[:3, :3] @ _turned(np.array([0.0, turn, 0.0]))
        size = np.array([length, height, width])
        # Numbers of tracks count from 0, and 0 is no instance.
        box = Box(words[2], int(words[1]) + 1, center, size, rotation)
        frames.setdefault(int(words[0]), []).append(box)
    yield from (FrameBoxes(frame, tuple(boxes)) for frame, boxes in sorted(frames.items()))


def _kitti_tracklets(path: Path) -> Iterator[FrameBoxes]:
    """Tracklets of KITTI's raw recordings: boxes of objects, in the velodyne's coordinates."""
    data = read_bytes(path)
    if b"<!ENTITY" in data:
        raise BadInputError(f"{path.name}: expected tracklets, got XML with entities of its own")
    try:
        root = ElementTree.fromstring(data)  # noqa: S314 – without entities
    except ElementTree.ParseError as error:
        raise BadInputError(f"{path.name}: expected tracklets as XML: {error}") from None
    frames: dict[int, list[Box]] = {}
    for number, item in enumerate(root.findall("./tracklets/item"), start=1):
        size = np.array([float(_text(item, name)) for name in "lwh"])
        first = int(_text(item, "first_frame"))
        for step, pose in enumerate(item.findall("./poses/item")):
            place = np.array([float(_text(pose, f"t{axis}")) for axis in "xyz"])
            angles = np.array([float(_text(pose, f"r{axis}")) for axis in "xyz"])
            if not np.isfinite([*place, *angles, *size]).all():
                raise BadInputError(f"{path.name}: expected finite numbers in item {number}")
            rotation = _turned(angles)
            # A tracklet's place is the middle of the bottom.
            center = place + rotation[:, 2] * size[2] / 2
            box = Box(_text(item, "objectType"), number, center, size, rotation)
            frames.setdefault(first + step, []).append(box)
    yield from (FrameBoxes(frame, tuple(boxes)) for frame, boxes in sorted(frames.items()))


def _text(element: ElementTree.Element, name: str) -> str:
    found = element.findtext(name)
    if found is None:
        raise ValueError(name)
    return found.strip()


def _camera_from_velodyne(path: Path) -> Floats:
    """``T_camera_velodyne`` (4, 4), rectified, of the calibration that lies with a label file."""
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


MARGIN = 1e-6
"""Metres by which a box of ours is enlarged: its outermost points lie on its faces."""


def _own_boxes(path: Path) -> Iterator[FrameBoxes]:
    """Read ``boxes.json`` of our export: the tightest box of each label in each frame."""
    frames: dict[int, list[Box]] = {}
    for entry in _document(path)["boxes"]:
        box, label = entry["box"], int(entry["label"])
        center, size = _vector(box["center"], range(3)), _vector(box["size"], range(3))
        rotation = np.array(box["rotation"], float).reshape(3, 3)
        made = Box(str(entry["name"]), 0, center, size + 2 * MARGIN, rotation, label)
        frames.setdefault(int(entry["frame"]), []).append(made)
    yield from (FrameBoxes(frame, tuple(boxes)) for frame, boxes in sorted(frames.items()))


BOX_READERS: Mapping[str, Callable[[Path], Iterator[FrameBoxes]]] = MappingProxyType({
    "labelcloud": _labelcloud,
    "sustechpoints": _sustechpoints,
    "supervisely": _supervisely,
    "kitti-tracking": _kitti_tracking,
    "kitti-tracklets": _kitti_tracklets,
    "boxes": _own_boxes,
})  # fmt: skip


def points_of(
    boxes: tuple[Box, ...], xyz: Floats, up: Floats, *, no_ground: bool
) -> NDArray[np.int64]:
    """Return the box (N,) that each point is in, -1 for none; of several the one of nearer centre.

    ``up`` (3,) points away from the floor; with ``no_ground`` what is near the lowest points
    round a box is left out.
    """
    which = np.full(len(xyz), -1, np.int64)
    nearest = np.full(len(xyz), np.inf)
    for number, box in enumerate(boxes):
        inside = box.inside(xyz)
        if no_ground:
            inside &= ~_ground(box, xyz, up)
        rows = np.flatnonzero(inside)
        away = np.linalg.norm(xyz[rows] - box.center, axis=1)
        closer = rows[away < nearest[rows]]
        which[closer], nearest[closer] = number, away[away < nearest[rows]]
    return which


GROUND_REACH, GROUND_ABOVE, GROUND_SHARE = 1.0, 0.2, 0.1
"""Metres round a box whose lowest points are the ground, metres above it that are, and the share
of the points there that lie below it."""


def _ground(box: Box, xyz: Floats, up: Floats) -> NDArray[np.bool_]:
    """Return the points of the ground at a box."""
    wide = Box(box.name, 0, box.center, box.size + 2 * GROUND_REACH, box.rotation)
    height = xyz @ up
    near = wide.inside(xyz) & ~box.inside(xyz)
    if not near.any():
        return np.zeros(len(xyz), np.bool_)
    level = float(np.quantile(height[near], GROUND_SHARE))
    bottom = float(box.center @ up) - float(np.abs(box.rotation.T @ up) @ box.size) / 2
    # Where there is no ground below it the lowest points are the object's own.
    if level > bottom + 2 * GROUND_ABOVE:
        return np.zeros(len(xyz), np.bool_)
    return np.asarray(height < level + GROUND_ABOVE)
