"""Sketch of a frame's labels: as much of their points as the checks need."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.work.reviewing.checks.options import CheckOptions
from pointbrush.work.reviewing.checks.pieces import Stray, find_stray

F64 = NDArray[np.float64]
Place = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Sketch:
    """A label in a frame: its middle in the frame's and the world's coordinates, its far piece."""

    points: int
    center: Place
    world: Place
    stray: Stray | None


def sketch_frame(
    xyz: NDArray[np.floating],
    label: NDArray[np.uint16],
    pose: F64 | None,
    shift: F64,
    options: CheckOptions,
) -> Mapping[int, Sketch]:
    """Return a sketch of each label above 0.

    ``xyz`` (N, 3) local metres in progressive order, so that the first points of a label are an
    even sample of it; ``label`` (N,); ``pose`` ``T_world_frame`` of source coordinates or None;
    ``shift`` (3,) source − local.
    """
    numbers = np.flatnonzero(label)
    order = np.argsort(label[numbers], kind="stable")
    numbers = numbers[order]
    ids, starts = np.unique(label[numbers], return_index=True)
    parts = np.split(numbers, starts[1:]) if len(ids) else []
    found = {}
    for number, part in zip(ids.tolist(), parts, strict=True):
        sample = xyz[part[: options.sample]].astype(np.float64) + shift
        center = np.median(sample, axis=0)
        world = center if pose is None else pose[:3, :3] @ center + pose[:3, 3]
        stray = find_stray(sample, options)
        found[int(number)] = Sketch(len(part), as_place(center), as_place(world), stray)
    return found


def as_place(point: F64) -> Place:
    """Return a point (3,) as plain numbers."""
    x, y, z = (float(value) for value in point)
    return x, y, z
