"""Boxes of editors that keep a JSON file a frame: labelCloud, SUSTechPOINTS, Xtreme1."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pointbrush.formats.boxes.attributes import of_text
from pointbrush.formats.boxes.conventions import box_by
from pointbrush.formats.boxes.documents import document, vector
from pointbrush.formats.boxes.figures import FrameBox, FrameBoxes

CLASSES = "_classes.json"
"""labelCloud's file of classes, which states the format of the labels beside it."""
SIDES = ("length", "width", "height")
PSR = ("position", "scale", "rotation")


def read_labelcloud(path: Path) -> Iterator[FrameBoxes]:
    """Read labelCloud's boxes, by their centroid or by their eight corners."""
    entries = document(path)["objects"]
    tool = "labelcloud-radians" if _in_radians(path, entries) else "labelcloud"
    boxes = []
    for entry in entries:
        if "vertices" in entry:
            boxes.append(_of_corners(str(entry["name"]), entry["vertices"]))
            continue
        place, angles = vector(entry["centroid"]), vector(entry["rotations"])
        size = vector(entry["dimensions"], SIDES)
        boxes.append(box_by(tool, str(entry["name"]), "", place, size, angles))
    yield FrameBoxes(None, tuple(boxes))


def labelcloud_format(path: Path) -> str:
    """Read the format that labelCloud states for the labels in a file's folder; "" for none."""
    stated = path.parent / CLASSES
    return str(document(stated).get("format", "")) if stated.is_file() else ""


def _in_radians(path: Path, entries: Any) -> bool:
    """Return whether angles are radians: as stated, else if any is negative (degrees: 0 to 360)."""
    stated = labelcloud_format(path)
    if stated.startswith("centroid"):
        return stated == "centroid_rel"
    angles = [vector(entry["rotations"]) for entry in entries if "rotations" in entry]
    return any(bool((turn < 0).any()) for turn in angles)


def _of_corners(name: str, corners: Any) -> FrameBox:
    """Build the box of labelCloud's corners: 0 to 3 is its length, 0 to 1 width, 0 to 4 height."""
    places = np.array([vector(corner, range(3)) for corner in corners])
    edges = np.stack([places[3] - places[0], places[1] - places[0], places[4] - places[0]], axis=1)
    size = np.linalg.norm(edges, axis=0)
    if len(places) != 8 or not (size > 0).all():
        raise ValueError(corners)
    return FrameBox(name, "", places.mean(axis=0), size, edges / size)


def read_sustechpoints(path: Path) -> Iterator[FrameBoxes]:
    """Read SUSTechPOINTS' boxes: ``psr`` is position, scale and rotation."""
    content = document(path)
    entries = content["objs"] if isinstance(content, dict) else content
    boxes = []
    for entry in entries:
        key, name = str(entry.get("obj_id") or ""), str(entry["obj_type"])
        parts = (vector(entry["psr"][field]) for field in PSR)
        attributes = of_text(str(entry.get("obj_attr") or ""))
        boxes.append(box_by("sustechpoints", name, key, *parts, attributes=attributes))
    yield FrameBoxes(None, tuple(boxes))


def read_xtreme1(path: Path) -> Iterator[FrameBoxes]:
    """Read Xtreme1's results of a frame: objects of several sources, without objects of images."""
    content = document(path)
    boxes = []
    for source in content if isinstance(content, list) else [content]:
        for entry in source.get("objects") or source.get("instances") or []:
            place = entry["contour"]
            if "center3D" not in place:
                continue
            name = entry.get("className") or entry["modelClass"]
            key = str(entry.get("trackId") or entry.get("trackName") or "")
            parts = (vector(place[field]) for field in ("center3D", "size3D", "rotation3D"))
            boxes.append(box_by("xtreme1", str(name), key, *parts))
    yield FrameBoxes(None, tuple(boxes))
