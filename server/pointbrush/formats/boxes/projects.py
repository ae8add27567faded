"""Labels of projects: Supervisely's, which CVAT writes too, and CVAT's Datumaro 3D."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pointbrush.formats.boxes.documents import document, vector
from pointbrush.formats.boxes.figures import Box, Figure, FrameBoxes, PointFigure
from pointbrush.formats.boxes.rotations import Order, euler_matrix

FRAME_MAP = "frame_pointcloud_map.json"
"""Supervisely's file of an episode: index of a frame → name of its file of points."""
_HYPHENATED = re.compile(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")
"""Keys that CVAT makes; Supervisely's own have no hyphens."""


def read_supervisely(path: Path) -> Iterator[FrameBoxes]:
    """Read the figures of an episode (``frames``) or of one frame: cuboids and point masks."""
    content = document(path)
    content = content.get("annotation", content)
    classes = {str(entry["key"]): str(entry["classTitle"]) for entry in content["objects"]}
    if "frames" not in content:
        yield FrameBoxes(None, tuple(_figures(content["figures"], classes)))
        return
    beside = path.parent / FRAME_MAP
    names = document(beside) if beside.is_file() else None
    for entry in content["frames"]:
        index = int(entry["index"])
        frame = index if names is None else str(names[str(index)])
        yield FrameBoxes(frame, tuple(_figures(entry["figures"], classes)))


def _figures(entries: Any, classes: dict[str, str]) -> Iterator[Figure]:
    for entry in entries:
        key, place = str(entry["objectKey"]), entry["geometry"]
        kind = entry.get("geometryType", "cuboid_3d")
        if kind == "point_cloud":
            yield PointFigure(classes[key], key, np.array(place["indices"], np.int64))
        elif kind == "cuboid_3d":
            order: Order = "xyz" if _HYPHENATED.fullmatch(key) else "zyx"
            rotation = euler_matrix(vector(place["rotation"]), order)
            center, size = vector(place["position"]), vector(place["dimensions"])
            yield Box(classes[key], key, center, size, rotation)


def read_datumaro(path: Path) -> Iterator[FrameBoxes]:
    """Read the cuboids of Datumaro's items; an item is the frame of its name."""
    content = document(path)
    labels = [str(entry["name"]) for entry in content["categories"]["label"]["labels"]]
    for item in content["items"]:
        boxes = []
        for entry in item["annotations"]:
            if entry["type"] != "cuboid_3d":
                continue
            center, angles, size = (
                vector(entry[key], range(3)) for key in ("position", "rotation", "scale")
            )
            track = entry.get("attributes", {}).get("track_id")
            key = "" if track is None else str(track)
            rotation = euler_matrix(angles, "xyz")
            boxes.append(Box(labels[int(entry["label_id"])], key, center, size, rotation))
        yield FrameBoxes(str(item["id"]), tuple(boxes))
