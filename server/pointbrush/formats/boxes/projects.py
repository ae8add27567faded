"""Labels of projects: Supervisely (also written by CVAT), CVAT's Datumaro 3D, Segments.ai."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.formats.boxes.attributes import value_of
from pointbrush.formats.boxes.conventions import box_by
from pointbrush.formats.boxes.documents import document, vector
from pointbrush.formats.boxes.figures import Figure, FrameBoxes, PointFigure
from pointbrush.geometry.oriented_box import AttributeValue

FRAME_MAP = "frame_pointcloud_map.json"
"""Supervisely's file of an episode: index of a frame → name of its file of points."""
CUBOID = ("position", "dimensions", "rotation")
"""Supervisely's place, size and rotation of a cuboid."""
SILENT = {"keyframe": True, "occluded": False, "outside": False}
"""Values of attributes that CVAT gives to every cuboid."""
_HYPHENATED = re.compile(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")
"""Keys that CVAT makes; Supervisely's own have no hyphens."""


def read_supervisely(path: Path) -> Iterator[FrameBoxes]:
    """Read the figures of an episode (``frames``) or of one frame: cuboids and point masks."""
    content = document(path)
    content = content.get("annotation", content)
    objects = {str(entry["key"]): entry for entry in content["objects"]}
    if "frames" not in content:
        yield FrameBoxes(None, tuple(_figures(content["figures"], objects, 0)))
        return
    beside = path.parent / FRAME_MAP
    names = document(beside) if beside.is_file() else None
    for entry in content["frames"]:
        index = int(entry["index"])
        frame = index if names is None else str(names[str(index)])
        yield FrameBoxes(frame, tuple(_figures(entry["figures"], objects, index)))


def _figures(entries: Any, objects: Mapping[str, Any], index: int) -> Iterator[Figure]:
    for entry in entries:
        key, place = str(entry["objectKey"]), entry["geometry"]
        name, kind = str(objects[key]["classTitle"]), entry.get("geometryType", "cuboid_3d")
        if kind == "point_cloud":
            yield PointFigure(name, key, np.array(place["indices"], np.int64))
        elif kind == "cuboid_3d":
            tool = "supervisely-cvat" if _HYPHENATED.fullmatch(key) else "supervisely"
            parts = (vector(place[field]) for field in CUBOID)
            yield box_by(tool, name, key, *parts, attributes=_tags(objects[key], index))


def _tags(entry: Mapping[str, Any], index: int) -> dict[str, AttributeValue]:
    """Read the tags that an object has in a frame; one without a value is true."""
    tags: dict[str, AttributeValue] = {}
    for tag in entry.get("tags") or []:
        first, last = tag.get("frameRange") or (index, index)
        if first <= index <= last:
            value = tag.get("value")
            tags[str(tag["name"])] = True if value is None else value_of(str(value))
    return tags


def read_datumaro(path: Path) -> Iterator[FrameBoxes]:
    """Read the cuboids of Datumaro's items; an item is the frame of its name."""
    content = document(path)
    labels = [str(entry["name"]) for entry in content["categories"]["label"]["labels"]]
    for item in content["items"]:
        boxes = []
        for entry in item["annotations"]:
            if entry["type"] != "cuboid_3d":
                continue
            parts = (vector(entry[key], range(3)) for key in ("position", "scale", "rotation"))
            attributes = dict(entry.get("attributes", {}))
            key, name = str(attributes.pop("track_id", "")), labels[int(entry["label_id"])]
            boxes.append(box_by("datumaro", name, key, *parts, attributes=_stated(attributes)))
        yield FrameBoxes(str(item["id"]), tuple(boxes))


def _stated(attributes: Mapping[str, Any]) -> dict[str, AttributeValue]:
    """Keep the attributes that differ from the defaults, numbers as float."""
    stated = {
        name: value if isinstance(value, str | bool) else float(value)
        for name, value in attributes.items()
        if isinstance(value, str | bool | int | float)
    }
    return {name: value for name, value in stated.items() if SILENT.get(name) is not value}


def read_segments(path: Path) -> Iterator[FrameBoxes]:
    """Read cuboids and labels of points of a release of Segments.ai: sequences, and samples of one
    frame.

    Without a quaternion a box turns about z by its yaw.  Samples without labels are skipped.
    Raises BadInputError for a sequence among other samples.
    """
    dataset = document(path)["dataset"]
    categories = {int(each["id"]): each for each in dataset["task_attributes"]["categories"]}
    samples = dataset["samples"]
    for sample in samples:
        label = next(iter((sample.get("labels") or {}).values()), None)
        if not label or not label.get("attributes"):
            continue
        name, attributes = str(sample["name"]), _of_lidar(path.name, label["attributes"])
        if "frames" not in attributes:
            alone = "" if len(samples) == 1 else f"{name} "
            yield FrameBoxes(name, _annotated(path.name, attributes, categories, alone))
            continue
        if len(samples) > 1:
            raise BadInputError(
                f"{path.name}: expected one sequence, got {len(samples)} samples, of which "
                f"{name[:40]!r} is one"
            )
        files = _of_lidar(path.name, sample["attributes"])["frames"]
        for index, (entry, file) in enumerate(zip(attributes["frames"], files, strict=True)):
            frame = str(file["name"]) if file.get("name") else index
            yield FrameBoxes(frame, _annotated(path.name, entry or {}, categories, f"{index} "))


def _of_lidar(file: str, attributes: Any) -> Any:
    """Return the attributes of the only sensor of points if several sensors have attributes."""
    if "sensors" not in attributes:
        return attributes
    found = [s for s in attributes["sensors"] if str(s["task_type"]).startswith("pointcloud")]
    if len(found) != 1:
        raise BadInputError(f"{file}: expected one sensor of point clouds, got {len(found)}")
    return found[0]["attributes"]


def _annotated(
    file: str, label: Mapping[str, Any], categories: Mapping[int, Any], place: str
) -> tuple[Figure, ...]:
    """Read the cuboids of a frame, and the points of its other annotations."""
    boxes = (
        _cuboid(entry, str(categories[int(entry["category_id"])]["name"]))
        for entry in label.get("annotations", [])
        if entry.get("type") == "cuboid"
    )
    return (*boxes, *_marked(file, label, categories, place))


def _marked(
    file: str, label: Mapping[str, Any], categories: Mapping[int, Any], place: str
) -> Iterator[PointFigure]:
    """Read the points of each annotation; ``point_annotations`` has an annotation's id per point.

    An annotation without a track is an object of this frame alone; ``place`` names the frame.
    """
    if "point_annotations" not in label:
        return
    entries = label.get("annotations", [])
    ids = np.array(label["point_annotations"])
    if ids.ndim != 1 or (len(ids) and ids.dtype.kind not in "ui"):
        raise BadInputError(
            f"{file}: expected point_annotations of Segments.ai as a list of whole numbers, one a "
            f"point, got {ids.shape} {ids.dtype}"
        )
    unknown = set(np.unique(ids).tolist()) - {0, *(int(entry["id"]) for entry in entries)}
    if unknown:
        raise BadInputError(
            f"{file}: expected point_annotations with ids of annotations, got {min(unknown)}"
        )
    order = np.argsort(ids, kind="stable")
    in_order = ids[order]
    for entry in entries:
        category, number = categories[int(entry["category_id"])], int(entry["id"])
        key = str(entry.get("track_id") or f"{place}{number}")
        key = "" if category.get("has_instances") is False else key
        first, end = np.searchsorted(in_order, [number, number + 1])
        if first < end:
            yield PointFigure(str(category["name"]), key, order[first:end], total=len(ids))


def _cuboid(entry: Mapping[str, Any], name: str) -> Figure:
    tool, turn = "waymo", np.array([float(entry["yaw"])])
    if entry.get("rotation"):
        tool, turn = "segments", vector(entry["rotation"], ("qx", "qy", "qz", "qw"))
    place, size = vector(entry["position"]), vector(entry["dimensions"])
    stated = _stated(entry.get("attributes") or {})
    return box_by(
        tool, name, str(entry.get("track_id") or ""), place, size, turn, attributes=stated
    )
