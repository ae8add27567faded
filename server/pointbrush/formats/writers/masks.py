"""Masks of pictures: labels as PNG images, and as COCO's JSON of objects."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.masks.coco import FRAME, HOLES, TRACK
from pointbrush.formats.masks.mask import PictureMask
from pointbrush.formats.masks.png import write_mask
from pointbrush.formats.masks.rle import compress_runs, runs_of_mask
from pointbrush.formats.writers.labeled import ExportFrame, Palette, PaletteEntry, category_of
from pointbrush.formats.writers.output import Output
from pointbrush.formats.writers.points import write_palette
from pointbrush.values.masks import VOID

COCO_FILE = "annotations.json"


def write_png_masks(frames: Iterable[ExportFrame], palette: Palette, output: Output) -> None:
    """Write ``labels/CAMERA/NNNNNN.png`` with ids of labels, ``classes/…`` with numbers of classes.

    The numbers are those of ``palette.json`` and ``classes.json``, in 8 bits if all are below 255,
    otherwise 16; the greatest number marks pixels in which no point is seen.
    """
    of_label = {entry.id: entry.color for entry in palette.entries}
    of_class: dict[int, str] = {}
    for entry in palette.entries:
        of_class.setdefault(palette.categories[category_of(entry)], entry.color)
    for frame in frames:
        for mask in frame.masks:
            name = f"{mask.folder}/{frame.stem}.png"
            with output.file(f"labels/{name}") as file:
                file.write(write_mask(mask.labels, of_label))
            classes = np.where(mask.labels == VOID, VOID, palette.category(mask.labels))
            with output.file(f"classes/{name}") as file:
                file.write(write_mask(classes.astype(np.uint16), of_class))
    write_palette(palette, output)


def write_coco_masks(frames: Iterable[ExportFrame], palette: Palette, output: Output) -> None:
    """Write ``annotations.json``, with an image for each camera and frame.

    ``track_id`` is the id of the label, ``category_id`` the number of its class.  ``holes`` of an
    image are the pixels in which no point is seen.
    """
    entries = {entry.id: entry for entry in palette.entries}
    images: list[dict[str, Any]] = []
    annotations: list[dict[str, Any]] = []
    for frame in frames:
        for mask in frame.masks:
            height, width = mask.labels.shape
            image = {
                "id": len(images) + 1,
                "file_name": f"{mask.folder}/{frame.stem}{mask.ending}",
                "width": width,
                "height": height,
                FRAME: frame.index,
                "camera": mask.camera,
                HOLES: _runs(mask.labels == VOID),
            }
            images.append(image)
            for each in _annotations(mask, entries, palette):
                place = {"id": len(annotations) + 1, "image_id": image["id"]}
                annotations.append(place | each)
    categories = [{"id": number, "name": name} for name, number in palette.categories.items()]
    document = {"images": images, "annotations": annotations, "categories": categories}
    with output.file(COCO_FILE) as file:
        file.write(json.dumps(document, ensure_ascii=False).encode())
    write_palette(palette, output)


def _annotations(
    mask: PictureMask, entries: dict[int, PaletteEntry], palette: Palette
) -> Iterator[dict[str, Any]]:
    """Yield the annotation of each label in a mask."""
    for label in np.unique(mask.labels).tolist():
        if label in (0, VOID) or label not in entries:
            continue
        shape = mask.labels == label
        rows, columns = (np.flatnonzero(shape.any(axis=axis)) for axis in (1, 0))
        low, high = (columns[0], rows[0]), (columns[-1], rows[-1])
        size = [int(end - start) + 1 for start, end in zip(low, high, strict=True)]
        yield {
            "category_id": palette.categories[category_of(entries[label])],
            "segmentation": _runs(shape),
            "area": int(shape.sum()),
            "bbox": [*map(int, low), *size],
            "iscrowd": 0,
            TRACK: label,
            "attributes": {"name": entries[label].name, TRACK: label},
        }


def _runs(shape: NDArray[np.bool_]) -> dict[str, Any]:
    """Return the run lengths of a shape (height, width) as in COCO."""
    return {"size": list(shape.shape), "counts": compress_runs(runs_of_mask(shape))}
