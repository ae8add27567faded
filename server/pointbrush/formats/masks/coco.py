"""Masks in COCO's JSON of objects: polygons and run lengths of ``annotations``.

https://cocodataset.org/#format-data.  The number of an object through a recording is its
``track_id``, as CVAT (in ``attributes``) and COCO's video formats write it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.masks.mask import (
    Key,
    Mask,
    MaskDrawing,
    MaskFile,
    Size,
    require_size,
)
from pointbrush.formats.masks.polygons import fill_polygon
from pointbrush.formats.masks.rle import decompress_runs, mask_of_runs
from pointbrush.formats.options import read_bytes
from pointbrush.formats.tables.class_maps import GREATEST_CLASS, LONGEST_NAME
from pointbrush.formats.tables.datasets import ClassName
from pointbrush.formats.tables.parsing import parse_json

EDGE = 1 << 16
"""Bytes at both ends of a file that are searched for COCO's keys."""
KEYS = (b'"images"', b'"annotations"', b'"categories"', b'"segmentation"')
FRAME, TRACK = "frame_id", "track_id"
HOLES = "holes"
"""Field of an image in our export: run lengths of its pixels without evidence."""
MOST_TRACK = 1 << 31
"""Upper bound of track ids."""
LONGEST_PATH = 200
"""Most characters of an image's path that are kept."""
FARTHEST = 1e6
"""Greatest coordinate of a polygon, pixels."""

Document = dict[str, Any]


def is_coco(path: Path) -> bool:
    """Return whether a JSON file has most of COCO's keys at its ends."""
    if path.suffix.lower() != ".json":
        return False
    with path.open("rb") as file:
        start = file.read(EDGE)
        file.seek(max(0, path.stat().st_size - EDGE))
        ends = start + file.read()
    return sum(key in ends for key in KEYS) >= 3


def read_coco(path: Path, name: str, *, own: bool) -> tuple[list[MaskFile], dict[int, ClassName]]:
    """Return the masks of a file, and its classes by number.

    ``name``: path that the names of masks begin with; ``own``: an export of pointbrush, in which
    tracks are ids of labels and images state their frames.
    Raises BadInputError naming the file and the entry.
    """
    try:
        document = parse_json(read_bytes(path))
        names = {int(each["id"]): _class(each["name"]) for each in document["categories"]}
        images = {each["id"]: each for each in document["images"]}
        of_image: dict[int, list[Document]] = {number: [] for number in images}
        for each in document["annotations"]:
            if each.get("segmentation"):
                of_image[each["image_id"]].append(each)
        # Tracks of some tools count from 0, which means no object here.
        tracks = {_track(each) for annotations in of_image.values() for each in annotations}
        shift = 1 if 0 in tracks else 0
        masks = [
            _mask_file(name, image, of_image[number], shift, own=own)
            for number, image in images.items()
        ]
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        if isinstance(error, BadInputError):
            raise
        raise BadInputError(
            f"{path.name}: expected COCO's images, annotations and categories, got another file: "
            f"{type(error).__name__} {error}"
        ) from None
    return masks, names


def _class(name: object) -> ClassName:
    if not isinstance(name, str) or not 0 < len(name.strip()) <= LONGEST_NAME:
        raise ValueError(f"category name {str(name)[:40]!r}")
    return ClassName(name.strip())


def _track(annotation: Document) -> int | None:
    """Return the number of an object through the recording, or None."""
    attributes = annotation.get("attributes")
    in_attributes = attributes.get(TRACK) if isinstance(attributes, dict) else None
    track = annotation.get(TRACK, in_attributes)
    if track is not None and not 0 <= int(track) < MOST_TRACK:
        raise ValueError(f"track id {str(track)[:20]}, expected 0 to {MOST_TRACK - 1:,}")
    return None if track is None else int(track)


def _mask_file(
    file: str, image: Document, annotations: Sequence[Document], shift: int, *, own: bool
) -> MaskFile:
    """Return the mask of an image; ``shift`` is added to the numbers of tracks."""
    size = int(image["width"]), int(image["height"])
    name = f"{file.removesuffix('.json')}/{str(image['file_name'])[:LONGEST_PATH]}"
    keyed: list[tuple[bool, float, int, Key | None, Document]] = []
    for number, each in enumerate(annotations, 1):
        track, category = _track(each), int(each["category_id"])
        if not 0 <= category <= GREATEST_CLASS:
            raise ValueError(f"category {category}, expected 0 to {GREATEST_CLASS}")
        instance = -number if track is None else track + shift
        crowd = bool(each.get("iscrowd"))
        key = (instance, 0) if own else (category, 0 if crowd else instance)
        keyed.append((not crowd, -float(each.get("area") or 0), number, key, each))
    if own and HOLES in image:
        keyed.append((False, -np.inf, 0, None, {"id": HOLES, "segmentation": image[HOLES]}))
    # Holes and crowds are drawn first, and small objects last.
    ordered = [(key, each) for *_, key, each in sorted(keyed, key=lambda each: each[:3])]
    frame = int(image[FRAME]) if own and FRAME in image else None
    return MaskFile(name, partial(_read, name, size, ordered), frame)


def _read(
    where: str, size: Size, annotations: Sequence[tuple[Key | None, Document]], expected: Size
) -> Mask:
    """Return the mask of an image: its annotations, each drawn over the ones before."""
    require_size(where, size, expected)
    drawing = MaskDrawing(size)
    for key, each in annotations:
        try:
            drawing.draw(_shape(each["segmentation"], size), key)
        except (ValueError, KeyError, TypeError, OverflowError) as error:
            raise BadInputError(
                f"{where}: expected polygons or runs as segmentation of annotation "
                f"{str(each.get('id'))[:20]}, got {error}"
            ) from None
    return drawing.mask()


def _shape(segmentation: Any, size: Size) -> NDArray[np.bool_]:
    width, height = size
    if isinstance(segmentation, Mapping):
        stated = [int(side) for side in segmentation["size"]]
        if stated != [height, width]:
            raise ValueError(f"runs of height and width {stated}, expected {[height, width]}")
        counts = segmentation["counts"]
        runs = decompress_runs(counts) if isinstance(counts, str) else np.array(counts, np.int64)
        return mask_of_runs(runs, height, width)
    shape = np.zeros((height, width), np.bool_)
    for polygon in segmentation:
        corners = np.array(polygon, np.float64)
        if corners.size < 6 or corners.size % 2 or not (np.abs(corners) < FARTHEST).all():
            raise ValueError(f"a polygon of {corners.size} numbers, expected x, y of 3 corners")
        fill_polygon(shape, corners.reshape(-1, 2))
    return shape
