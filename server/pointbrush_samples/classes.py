"""Frames with the class of every point, for the evaluation of labelling by example."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.frame import PointFrame
from pointbrush.samples.aerial import CLASSES, aerial_tile
from pointbrush.samples.geometry import rigid, vec
from pointbrush.samples.sensor import spin
from pointbrush_samples.driving import HEIGHT, LANE, LIDAR, START, DrivenStreet
from pointbrush_samples.interior import Interior
from pointbrush_samples.scanning import ScanOptions, scan_of

STREET = ("ground", "building", "vehicle", "person", "fixture", "vegetation")
ROOM = ("floor", "ceiling", "wall", "furniture")
RATE = 10.0
"""Frames a second of a drive."""


@dataclass(frozen=True, slots=True, eq=False)
class Classified:
    """A frame and its ``truth`` (N,), from 1, of ``classes``."""

    frame: PointFrame
    truth: NDArray[np.uint16]
    classes: tuple[str, ...]


def classified_drive(seed: int, frames: int) -> Iterator[Classified]:
    """Yield frames of a car's drive, y up, as ``driving.drive`` makes them."""
    street = DrivenStreet(seed)
    numbers = {kind: number for number, kind in enumerate(STREET, 1)}
    for i in range(frames):
        moved = street.at(i / RATE)
        solids = [
            replace(solid, label=numbers[kind])
            for solid, kind in zip(moved, street.kinds, strict=True)
        ]
        eye = vec(LANE * street.road, HEIGHT, START + street.own.speed * i / RATE)
        turn = spin(LIDAR, eye, solids, np.random.default_rng([seed, 67, i]))
        frame = PointFrame(
            (turn.xyz - eye).astype(np.float32), intensity=turn.intensity,
            viewpoint=np.zeros(3), pose=rigid(np.eye(3), eye),
        )  # fmt: skip
        yield Classified(frame, turn.label, STREET)


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
