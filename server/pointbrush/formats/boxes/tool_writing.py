"""Boxes as files of tools: labelCloud, SUSTechPOINTS, Supervisely, Datumaro, Segments.ai.

Each in the coordinates of the source's points.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pointbrush.formats.boxes.attributes import as_text, word_of
from pointbrush.formats.boxes.conventions import numbers_by
from pointbrush.formats.boxes.editors import PSR, SIDES
from pointbrush.formats.boxes.figures import FrameBox
from pointbrush.formats.boxes.projects import CUBOID, FRAME_MAP
from pointbrush.formats.boxes.scene import File, Scene, SceneFrame
from pointbrush.geometry.oriented_box import AttributeValue

Place = tuple[list[float], list[float], list[float]]


def _json(name: str, content: Any) -> File:
    return name, json.dumps(content, indent=1, ensure_ascii=False).encode()


def _axes(values: Iterable[float], names: Iterable[str] = "xyz") -> dict[str, float]:
    return dict(zip(names, values, strict=True))


def _parts(tool: str, box: FrameBox, names: Iterable[str]) -> dict[str, dict[str, float]]:
    """Describe place, size and rotation by their names, each an object of x, y and z."""
    return dict(zip(names, map(_axes, numbers_by(tool, box)), strict=True))


def write_labelcloud(frames: Iterable[SceneFrame], scene: Scene) -> Iterator[File]:
    """Write ``labels/NAME.json`` of each frame, and ``_classes.json``, which states degrees."""
    for frame in frames:
        objects = []
        for box in frame.boxes:
            place, size, angles = numbers_by("labelcloud", box)
            entry = {"centroid": _axes(place), "dimensions": _axes(size, SIDES)}
            turned = _axes(angle % 360 for angle in angles)
            objects.append({"name": box.name, **entry, "rotations": turned})
        content = {"folder": "pointclouds", "filename": frame.name, "path": frame.name}
        yield _json(f"labels/{frame.name}.json", content | {"objects": objects})
    classes = [
        {"name": name, "id": number, "color": color}
        for number, (name, color) in enumerate(scene.classes.items())
    ]
    description = {"type": "object_detection", "format": "centroid_abs", "default": 0}
    yield _json("labels/_classes.json", {"classes": classes, **description})


def write_sustechpoints(frames: Iterable[SceneFrame], _: Scene) -> Iterator[File]:
    """Write ``label/NAME.json`` of each frame."""
    for frame in frames:
        entries = [
            {
                "obj_id": box.key,
                "obj_type": box.name,
                "obj_attr": as_text(box.attributes),
                "psr": _parts("sustechpoints", box, PSR),
            }
            for box in frame.boxes
        ]
        yield _json(f"label/{frame.name}.json", entries)


def write_datumaro(frames: Iterable[SceneFrame], scene: Scene) -> Iterator[File]:
    """Write ``annotations/default.json``: cuboids of items with the names of the frames."""
    names = list(scene.classes)
    items = []
    for frame in frames:
        annotations = []
        for number, box in enumerate(frame.boxes):
            place, size, angles = numbers_by("datumaro", box)
            annotations.append(
                {
                    "id": number,
                    "type": "cuboid_3d",
                    "attributes": {"track_id": box.label, **box.attributes},
                    "group": 0,
                    "label_id": names.index(box.name),
                    "position": place,
                    "rotation": angles,
                    "scale": size,
                }
            )
        cloud = {"path": f"{frame.name}.pcd"}
        items.append({"id": frame.name, "annotations": annotations, "point_cloud": cloud})
    labels = [{"name": name, "parent": "", "attributes": []} for name in names]
    categories = {"label": {"labels": labels, "attributes": []}}
    yield _json("annotations/default.json", {"info": {}, "categories": categories, "items": items})


def write_supervisely(frames: Iterable[SceneFrame], scene: Scene) -> Iterator[File]:
    """Write an episode: ``meta.json``, ``episode/annotation.json`` and the frames' names.

    Attributes are tags of the object over the frames that have them.
    """
    objects: dict[int, dict[str, Any]] = {}
    names: dict[str, str] = {}
    entries = []
    for number, frame in enumerate(frames):
        figures = []
        for box in frame.boxes:
            key = scene.token("object", box.label)
            known = {"key": key, "classTitle": box.name, "tags": []}
            tags = objects.setdefault(box.label, known)["tags"]
            for name, value in box.attributes.items():
                _tag(tags, name, word_of(value), number)
            figures.append(
                {
                    "key": scene.token(f"figure {number}", box.label),
                    "objectKey": key,
                    "geometryType": "cuboid_3d",
                    "geometry": _parts("supervisely", box, CUBOID),
                }
            )
        names[str(number)] = f"{frame.name}.pcd"
        entries.append({"index": number, "figures": figures})
    content: dict[str, Any] = {"description": "", "key": scene.token("episode", 0), "tags": []}
    content |= {"objects": list(objects.values()), "framesCount": len(entries), "frames": entries}
    yield _json("episode/annotation.json", content)
    yield _json(f"episode/{FRAME_MAP}", names)
    yield _json("meta.json", _meta(scene, objects.values()))


def _tag(tags: list[dict[str, Any]], name: str, value: str, number: int) -> None:
    """Add a frame to the tag of this value that ends just before it, or begin another tag."""
    for tag in tags:
        if (tag["name"], tag["value"]) == (name, value) and tag["frameRange"][1] == number - 1:
            tag["frameRange"][1] = number
            return
    tags.append({"name": name, "value": value, "frameRange": [number, number]})


def _meta(scene: Scene, objects: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    classes = [
        {"title": name, "shape": "cuboid_3d", "color": color}
        for name, color in scene.classes.items()
    ]
    names = sorted({tag["name"] for each in objects for tag in each["tags"]})
    tags = [{"name": name, "value_type": "any_string", "color": "#808080"} for name in names]
    return {"classes": classes, "tags": tags, "projectType": "point_cloud_episodes"}


def write_segments(frames: Iterable[SceneFrame], scene: Scene) -> Iterator[File]:
    """Write ``release.json`` like a release of Segments.ai: one sample, a sequence of cuboids."""
    names = list(scene.classes)
    entries, files = [], []
    for index, frame in enumerate(frames):
        annotations = []
        for box in frame.boxes:
            (x, y, z), size, turn = numbers_by("segments", box)
            yaw = numbers_by("waymo", box)[2][0]
            attributes: Mapping[str, AttributeValue] = box.attributes
            annotations.append(
                {
                    "id": box.label,
                    "track_id": box.label,
                    "category_id": names.index(box.name) + 1,
                    "type": "cuboid",
                    "position": {"x": x, "y": y, "z": z},
                    "dimensions": _axes(size),
                    "yaw": yaw,
                    "rotation": _axes(turn, ("qx", "qy", "qz", "qw")),
                    "is_keyframe": True,
                    "index": index,
                    "attributes": dict(attributes),
                }
            )
        entries.append({"format_version": "0.2", "annotations": annotations})
        files.append({"name": frame.name, "timestamp": round(frame.time * 1e9)})
    categories = [
        {"id": number, "name": name, "color": _rgb(color)}
        for number, (name, color) in enumerate(scene.classes.items(), start=1)
    ]
    label = {"label_status": "LABELED", "attributes": {"format_version": "0.2", "frames": entries}}
    sample = {
        "name": scene.recording,
        "attributes": {"frames": files},
        "labels": {"ground-truth": label},
    }
    dataset = {
        "task_type": "pointcloud-cuboid-sequence",
        "task_attributes": {"format_version": "0.1", "categories": categories},
        "samples": [sample],
    }
    yield _json("release.json", {"name": "pointbrush", "dataset": dataset})


def _rgb(color: str) -> list[int]:
    return [int(color[place : place + 2], 16) for place in (1, 3, 5)]
