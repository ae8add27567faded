"""The sensors of a frame: the position of each, and its part of the depth image or a range image.

A recording has one sensor or several.  Several depth cameras share one depth image with their
images one below the other, so that a pixel belongs to one camera.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pointbrush.tracking.interface import F32, F64, ArrayFrame, Mask, SensorPart, TrackFrame
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import Lens, Projection, find_lens, imported_lens
from pointbrush.tracking.sensors.scanner import RangeImage

GAP = 8
"""Unmeasured rows between the images of two cameras, so that no pixel has a neighbour in both."""


@dataclass(frozen=True, eq=False)
class Lenses:
    """Pixel grids of several depth cameras in one depth image of ``shape``, ``of`` each sensor."""

    of: Mapping[int, Lens]
    shape: tuple[int, int]

    @property
    def lattice(self) -> bool:
        """Whether all pixels are the sensors' own, with one point each."""
        return all(lens.lattice for lens in self.of.values())

    def cells(self, xyz: F32, frame: TrackFrame, options: TrackerOptions) -> Projection:
        """Project the points (N, 3) of a frame, each into the image of its own camera."""
        cell, depth = np.full(len(xyz), -1, np.int32), np.zeros(len(xyz), np.float32)
        for number, lens in self.of.items():
            own = np.flatnonzero(frame.sensor == number)
            cell[own], depth[own] = lens.cells(xyz[own], options=options.lens)
        return Projection(cell, depth)


@dataclass(frozen=True, eq=False)
class Sight:
    """A sensor of a frame: its position ``eye`` (3,) in the world, None if unknown.

    ``lens``: pixel grid of a depth camera; ``shade``: range image of another sensor; or neither.
    """

    eye: F64 | None
    lens: Lens | None = None
    shade: RangeImage | None = None


def stacked(lenses: Mapping[int, Lens]) -> Lenses:
    """Return the lenses of several sensors with their images one below the other."""
    width = max(lens.shape[1] for lens in lenses.values())
    placed, rows = {}, 0
    for number, lens in sorted(lenses.items()):
        placed[number] = replace(lens, start=rows * width, stride=width)
        rows += lens.shape[0] + GAP
    return Lenses(placed, (rows, width))


def find_lenses(frames: Iterable[TrackFrame], options: TrackerOptions) -> Lenses | None:
    """Return the pixel grids of all sensors of some frames; None: a sensor has none.

    Each is that of the first frame with the sensor's points.
    """
    found: dict[int, Lens] = {}
    for frame in frames:
        for part in frame.parts:
            if part.sensor not in found:
                lens = _lens_of(frame, part, options=options)
                if lens is None:
                    return None
                found[part.sensor] = lens
    return stacked(found) if found else None


def _lens_of(frame: TrackFrame, part: SensorPart, options: TrackerOptions) -> Lens | None:
    """Return the pixel grid of one sensor in the frame's coordinates; None: it has none."""
    if part.lattice is None:
        own = np.asarray(frame.xyz)[np.asarray(frame.sensor) == part.sensor]
        return find_lens(ArrayFrame(own, part.T_frame_sensor[:3, 3]), moves=True, options=options)
    lens, turn = imported_lens(part.lattice, options=options.lens), part.T_frame_sensor[:3, :3]
    eye = turn @ lens.eye + part.T_frame_sensor[:3, 3]
    return replace(lens, eye=eye.astype(np.float32), turn=turn.T.astype(np.float32))


def mounted_alike(one: TrackFrame, others: Iterable[TrackFrame], least: float) -> bool:
    """Return whether the sensors have the same mounts in all frames, within ``least``."""
    mounts = {part.sensor: part.T_frame_sensor for part in one.parts}
    return all(
        np.abs(part.T_frame_sensor - mounts.get(part.sensor, part.T_frame_sensor)).max() <= least
        for frame in others
        for part in frame.parts
    )


def any_of(masks: Iterable[Mask]) -> Mask:
    """Return the elementwise disjunction of the sensors' masks."""
    first, *others = masks
    for other in others:
        first = first | other
    return first


def all_of(masks: Iterable[Mask]) -> Mask:
    """Return the elementwise conjunction of the sensors' masks."""
    first, *others = masks
    for other in others:
        first = first & other
    return first
