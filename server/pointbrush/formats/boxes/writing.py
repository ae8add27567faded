"""Formats in which boxes are written: their writers and losses."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from pointbrush.formats.boxes.conventions import CONVENTIONS
from pointbrush.formats.boxes.drive_writing import write_argoverse, write_nuscenes, write_waymo
from pointbrush.formats.boxes.kitti_writing import write_kitti_object, write_kitti_tracking
from pointbrush.formats.boxes.scene import File, Scene, SceneFrame
from pointbrush.formats.boxes.tool_writing import (
    write_datumaro,
    write_labelcloud,
    write_segments,
    write_supervisely,
    write_sustechpoints,
)

OBJECTS = "object identity across frames"
ATTRIBUTES = "box attributes"
NAMES = "spaces in class names"
PRECISE = "provenance and confidence of boxes"
HEADING = "unknown headings (boxes get the likelier one)"
TILT = "roll and pitch of boxes"


@dataclass(frozen=True, slots=True)
class BoxWriting:
    """A format of boxes that is written.

    ``read_as``: the format that reads it, and a pattern of its files; ``convention`` of its
    numbers; ``lost``: properties of boxes that it cannot hold, other than the tilt.  ``level``: its
    boxes are in level axes, forward, left and up, about the source's origin.
    """

    title: str
    content: str
    write: Callable[[Iterable[SceneFrame], Scene], Iterator[File]]
    convention: str
    read_as: tuple[str, str]
    lost: tuple[str, ...] = ()
    level: bool = False

    @property
    def cannot_hold(self) -> tuple[str, ...]:
        """List the parts of boxes that are lost in it."""
        tilt = (TILT,) if CONVENTIONS[self.convention].upright else ()
        return (*tilt, *self.lost, PRECISE)


BOX_WRITERS: Mapping[str, BoxWriting] = MappingProxyType({
    "kitti-object": BoxWriting(
        "KITTI object", "label_2 and calib", write_kitti_object, "kitti",
        ("kitti-object", "label_2/*.txt"),
        (OBJECTS, "attributes other than truncated and occluded", HEADING, NAMES),
    ),
    "kitti-tracking": BoxWriting(
        "KITTI tracking", "label_02 and calib", write_kitti_tracking, "kitti",
        ("kitti-tracking", "label_02/*.txt"),
        ("attributes other than levels of truncated and occluded", HEADING, NAMES),
    ),
    "nuscenes-boxes": BoxWriting(
        "nuScenes", "tables of boxes", write_nuscenes, "nuscenes",
        ("nuscenes-boxes", "sample_annotation.json"),
    ),
    "argoverse2": BoxWriting(
        "Argoverse 2", "annotations.feather", write_argoverse, "argoverse",
        ("argoverse", "annotations.feather"), (ATTRIBUTES, HEADING), level=True,
    ),
    "waymo-boxes": BoxWriting(
        "Waymo 2", "lidar_box.parquet", write_waymo, "waymo",
        ("waymo", "lidar_box/*.parquet"),
        (ATTRIBUTES, HEADING, "classes other than vehicle, pedestrian, sign and cyclist"),
        level=True,
    ),
    "sustechpoints": BoxWriting(
        "SUSTechPOINTS", "one label file per frame", write_sustechpoints, "sustechpoints",
        ("sustechpoints", "label/*.json"),
    ),
    "datumaro": BoxWriting(
        "CVAT", "Datumaro 3D, which CVAT imports", write_datumaro, "datumaro",
        ("datumaro", "annotations/default.json"),
        ("unknown occlusion (CVAT reads it as visible)",),
    ),
    "labelcloud": BoxWriting(
        "labelCloud", "one file per frame", write_labelcloud, "labelcloud",
        ("labelcloud", "labels/*.json"), (OBJECTS, ATTRIBUTES, HEADING),
    ),
    "supervisely": BoxWriting(
        "Supervisely", "an episode with its annotation", write_supervisely, "supervisely",
        ("supervisely", "episode/annotation.json"),
    ),
    "segments": BoxWriting(
        "Segments.ai", "a release file", write_segments, "segments",
        ("segments", "release.json"),
    ),
})  # fmt: skip
"""Whole boxes, by the name of the export."""
