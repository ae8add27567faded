"""Frames with the class of every point, for the evaluation of labelling by example."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.frame import PointFrame
from pointbrush.samples.aerial import CLASSES, aerial_tile
from pointbrush_samples.interior import Interior
from pointbrush_samples.scanning import ScanOptions, scan_of

ROOM = ("floor", "ceiling", "wall", "furniture")


@dataclass(frozen=True, slots=True, eq=False)
class Classified:
    """A frame and its ``truth`` (N,), from 1, of ``classes``."""

    frame: PointFrame
    truth: NDArray[np.uint16]
    classes: tuple[str, ...]


def classified_room(seed: int) -> Classified:
    """Return a furnished room scanned from many views, y up."""
    interior = Interior(seed)
    for number, solid in enumerate(interior.solids):
        kind = ROOM[min(number, 2)] if number < 6 and not solid.label else ROOM[3]
        interior.solids[number] = replace(solid, label=ROOM.index(kind) + 1)
    made = scan_of(interior, seed, ScanOptions())
    return Classified(made.frame, made.instance, ROOM)


def classified_tile(seed: int) -> Classified:
    """Return a tile of land from the air, z up."""
    made = aerial_tile(seed)
    assert made.label is not None  # noqa: S101 – a tile has its classes
    return Classified(replace(made, label=None), made.label, tuple(each.name for each in CLASSES))


def scores(
    truth: NDArray[np.integer], found: NDArray[np.integer], count: int
) -> Mapping[str, float]:
    """Return overall accuracy, and the mean IoU of the present classes of 1..count."""
    table = np.bincount(truth.astype(np.int64) * (count + 1) + found, minlength=(count + 1) ** 2)
    table = table.reshape(count + 1, count + 1)
    hit = np.diag(table)[1:]
    there = table[1:].sum(axis=1)
    union = there + table[:, 1:].sum(axis=0) - hit
    iou = hit[there > 0] / union[there > 0]
    return {"OA": float(hit.sum() / max(there.sum(), 1)), "mIoU": float(iou.mean())}
