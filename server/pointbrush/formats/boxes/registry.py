"""Formats of boxes: recognition of their files, and their readers."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from pointbrush.errors import BadInputError
from pointbrush.formats.boxes.drives import read_argoverse, read_nuscenes_boxes, read_waymo
from pointbrush.formats.boxes.editors import read_labelcloud, read_sustechpoints, read_xtreme1
from pointbrush.formats.boxes.figures import FrameBoxes
from pointbrush.formats.boxes.kitti_boxes import (
    read_kitti_object,
    read_kitti_tracking,
    read_kitti_tracklets,
)
from pointbrush.formats.boxes.openpcdet import read_openpcdet
from pointbrush.formats.boxes.own import read_own
from pointbrush.formats.boxes.projects import read_datumaro, read_segments, read_supervisely

START = 1 << 16
"""Bytes of a file that are searched for marks of its format."""
_NUMBER = r"-?[\d.]+(?:[eE][-+]?\d+)?"
_OBJECT = rf"\S+(?: {_NUMBER}){{14}}(?: \S+){{0,2}}"


@dataclass(frozen=True, slots=True)
class BoxFormat:
    """``ending`` of the file names; ``marks`` are patterns that all occur in the first bytes."""

    read: Callable[[Path], Iterator[FrameBoxes]]
    ending: str
    marks: tuple[str, ...]


BOX_READERS: Mapping[str, BoxFormat] = MappingProxyType({
    "labelcloud": BoxFormat(read_labelcloud, ".json", ('"objects"', '"(centroid|vertices)"')),
    "sustechpoints": BoxFormat(read_sustechpoints, ".json", ('"psr"', '"obj_type"')),
    "supervisely": BoxFormat(read_supervisely, ".json", ('"figures"', '"objects"')),
    "datumaro": BoxFormat(read_datumaro, ".json", ('"categories"', '"items"', '"annotations"')),
    "xtreme1": BoxFormat(read_xtreme1, ".json", ('"contour"', '"center3D"')),
    "argoverse": BoxFormat(read_argoverse, ".feather", ("track_uuid", "length_m")),
    "waymo": BoxFormat(read_waymo, ".parquet", (r"\APAR1",)),
    "segments": BoxFormat(read_segments, ".json", ('"dataset"', '"samples"', '"task_attributes"')),
    "nuscenes-boxes": BoxFormat(
        read_nuscenes_boxes, ".json", ('"sample_token"', '"instance_token"', '"size"')
    ),
    "kitti-object": BoxFormat(read_kitti_object, ".txt", (rf"\A\s*{_OBJECT}\s*(\n|\Z)",)),
    "kitti-tracking": BoxFormat(
        read_kitti_tracking, ".txt", (rf"\A\s*\d+ -?\d+ {_OBJECT}\s*(\n|\Z)",)
    ),
    "kitti-tracklets": BoxFormat(read_kitti_tracklets, ".xml", ("<tracklets",)),
    "openpcdet": BoxFormat(
        read_openpcdet, ".txt", (rf"\A\s*(?:{_NUMBER} ){{7}}(?!{_NUMBER}\s)\S+\s*(\n|\Z)",)
    ),
    "boxes": BoxFormat(read_own, ".json", ('"boxes"', '"upright"')),
})  # fmt: skip


def read_boxes(path: Path, format: str) -> list[FrameBoxes]:
    """Read the boxes of one file.  Raises BadInputError naming it."""
    try:
        return list(BOX_READERS[format].read(path))
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
        if isinstance(error, BadInputError):
            raise
        raise BadInputError(f"{path.name}: expected {format} boxes, got another file") from None


def is_box_file(path: Path, format: str) -> bool:
    """Return whether a file is of a format of boxes, by its name and its first bytes."""
    known = BOX_READERS[format]
    if not path.name.lower().endswith(known.ending):
        return False
    with path.open("rb") as file:
        start = file.read(START).decode("utf-8", "replace")
    return all(re.search(mark, start) for mark in known.marks)
