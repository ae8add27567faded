"""A stored frame, or its part around a click, as input of selectors."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection import Points
from pointbrush.sequences import Manifest, StoredFrame

if TYPE_CHECKING:
    from pointbrush.selection.objects import ObjectFrame
    from pointbrush.tracking.interface import ArrayFrame
    from pointbrush.tracking.sensors.kind import Sensing

Floats = NDArray[np.float64]
T = TypeVar("T", bound=np.generic)

SENSED_POINTS = 250_000
"""Number of first points, a uniform sample, used to determine a frame's sensor."""


def object_frame(
    frame: StoredFrame, manifest: Manifest, members: NDArray[np.int64] | None = None
) -> ObjectFrame:
    """Return a frame, or its points ``members``, for ``Selector.prepare``."""

    from pointbrush.selection.objects import ObjectFrame  # imports compiled loops

    sensor = sensor_of(frame, manifest)
    return ObjectFrame(
        xyz=np.ascontiguousarray(frame.coordinates[slice(None) if members is None else members]),
        rgb=part_of(frame.rgb, members),
        intensity=part_of(frame.intensity, members),
        viewpoint=sensor.place,
        sensor=sensor.kind,
        T_room_local=manifest.T_room_local,
    )


def part_of(column: NDArray[T] | None, members: NDArray[np.int64] | None) -> NDArray[T] | None:
    """Return a contiguous column of a frame, or its part for the points ``members``."""
    if column is None:
        return None
    return np.ascontiguousarray(column if members is None else column[members])


def sensor_of(frame: StoredFrame, manifest: Manifest) -> Sensing:
    """Return the kind of a frame's sensor and its position, local metres.

    Several depth cameras are a room: points from many sides, without one position.
    """
    from pointbrush.tracking.sensors.kind import Sensing, sense  # imports compiled loops

    if frame.sensors and any(part.type == "depth" for part in frame.parts):
        return Sensing("room", None)
    return sense(_positions(frame), -np.asarray(manifest.shift, np.float64))


def _positions(frame: StoredFrame) -> ArrayFrame:
    """Return the part of a frame used to determine its sensor."""
    from pointbrush.tracking.interface import ArrayFrame  # not loaded by most commands

    xyz = np.asarray(frame.coordinates[:SENSED_POINTS], np.float32)
    xyz = xyz[np.isfinite(xyz).all(axis=1)]
    return ArrayFrame(xyz, frame.viewpoint, frame.pose, frame.lattice)


def near(points: Points, middle: Floats, reach: float, most: int) -> NDArray[np.int64]:
    """Return numbers of points around a place (3,), in a cube with at most ``most`` of them."""
    first = points.blocks.first
    while reach > 1e-3:
        blocks = points.blocks_in_box(middle - reach, middle + reach)
        if int((first[blocks + 1] - first[blocks]).sum()) <= most:
            break
        reach /= 1.3
    numbers = points.numbers(blocks)
    inside = (np.abs(points.xyz[numbers] - middle) <= reach).all(axis=1)
    return np.asarray(numbers[inside])
