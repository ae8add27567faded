"""Stored frames as input of classifiers: whole, piece by piece, or around a place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.features import ExampleFrame
from pointbrush.ranges import ranges
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences import StoredFrame
from pointbrush.sequences.storage.manifest import Manifest
from pointbrush.work.objects.frames import part_of, sensor_of

Numbers = NDArray[np.int64]
Floats = NDArray[np.float64]
RETURNS = ("return_number", "number_of_returns")
LEVEL_FROM_ROOM = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
"""Rotation from room coordinates, y up, to level coordinates, z up."""


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """Points of a frame by their stored numbers.

    ``members`` (n,): ascending, including the margin; ``inside`` (n,): False in the margin.
    """

    members: Numbers
    inside: NDArray[np.bool_]


def level_rotation(manifest: Manifest) -> Floats:
    """Return the rotation (3, 3) from local coordinates to level coordinates, z up."""
    return np.asarray(LEVEL_FROM_ROOM @ manifest.T_room_local[:3, :3])


def example_frame(recording: Recording, frame: int, members: Numbers | None = None) -> ExampleFrame:
    """Return a frame, or its points ``members``, as input of features."""
    stored = recording[frame]

    level = level_rotation(recording.manifest)
    # A guessed kind may be wrong: an aerial scan can look like a rotation of a lidar.
    known = stored.viewpoint is not None or stored.pose is not None
    sensor = sensor_of(stored, recording.manifest) if known else None
    xyz = np.asarray(stored.coordinates[slice(None) if members is None else members], np.float64)
    return ExampleFrame(
        np.ascontiguousarray(xyz @ level.T),
        part_of(stored.rgb, members),
        part_of(stored.intensity, members),
        _returns(recording, stored, members),
        None if sensor is None or sensor.place is None else level @ sensor.place,
        "room" if sensor is None else sensor.kind,
    )


def _returns(
    recording: Recording, stored: StoredFrame, members: Numbers | None
) -> NDArray[np.float32] | None:
    """Return the return number and number of returns (n, 2), or None if the source has none."""
    found = recording.other_of(stored.index, 0, stored.count)
    if not all(name in found for name in RETURNS):
        return None
    wanted = stored.source_index if members is None else stored.source_index[members]
    return np.stack([found[name][wanted] for name in RETURNS], axis=1).astype(np.float32)


def pieces(recording: Recording, frame: int, most: int, margin: float) -> Iterator[Piece]:
    """Yield pieces of a frame of about ``most`` points, each with a margin of ``margin`` metres.

    Only horizontal coordinates are split, so that upright objects stay in one piece.
    """
    stored = recording[frame]
    blocks = stored.blocks
    level = level_rotation(recording.manifest)
    axes = np.argsort(np.abs(level[2]))[:2]
    middle = (blocks.lo + blocks.hi)[:, axes].astype(np.float64) / 2
    held = np.diff(blocks.first)
    lo, hi = blocks.lo[:, axes], blocks.hi[:, axes]
    for low, high in _boxes(middle, held, np.full(2, -np.inf), np.full(2, np.inf), most):
        touched = np.flatnonzero(((hi >= low - margin) & (lo <= high + margin)).all(axis=1))
        numbers = ranges(blocks.first[touched], blocks.first[touched + 1])
        place = np.asarray(stored.coordinates[numbers], np.float64)[:, axes]
        near = ((place >= low - margin) & (place < high + margin)).all(axis=1)
        own = (place >= low) & (place < high)
        inside = np.asarray(own.all(axis=1))[near]
        if inside.any():
            yield Piece(numbers[near], inside)
        if stored.large:
            stored.release()


def _boxes(
    middle: Floats, held: Numbers, low: Floats, high: Floats, most: int
) -> Iterator[tuple[Floats, Floats]]:
    """Bisect the plane until each part has at most ``most`` points, by the centres of blocks."""
    inside = ((middle >= low) & (middle < high)).all(axis=1)
    centers, counts = middle[inside], held[inside]
    if counts.sum() <= most or len(centers) < 2:
        yield low, high
        return
    axis = int(np.ptp(centers, axis=0).argmax())
    order = np.argsort(centers[:, axis])
    half = int(np.searchsorted(np.cumsum(counts[order]), counts.sum() / 2))
    cut = float(centers[order[min(half, len(order) - 1)], axis])
    if not centers[:, axis].min() < cut:
        yield low, high
        return
    below, above = high.copy(), low.copy()
    below[axis] = above[axis] = cut
    yield from _boxes(middle, held, low, below, most)
    yield from _boxes(middle, held, above, high, most)
