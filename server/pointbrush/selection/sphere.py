"""The ball brush: the volume that a ball sweeps from each sample's origin to the next."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pointbrush.ranges import ranges
from pointbrush.selection.points import Points
from pointbrush.selection.shape import RADIUS, Parts, Selecting, Shape

_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])


def swept_ball(points: Points, origins: NDArray[np.float64], radius: float) -> NDArray[np.int64]:
    """Return sorted numbers of the points within ``radius`` of the polyline ``origins`` (S, 3).

    Coordinates are local metres.  One sample is a ball, two are a capsule.
    """
    parts = list(swept_parts(points, origins, radius))
    return parts[0] if len(parts) == 1 else np.concatenate([np.empty(0, np.int64), *parts])


def swept_parts(
    points: Points, origins: NDArray[np.float64], radius: float
) -> Iterator[NDArray[np.int64]]:
    """Yield the numbers of ``swept_ball`` in parts, for balls with most of a scan."""
    if len(origins) == 0:
        return
    starts, stops = _segments(origins)
    lo, hi = np.minimum(starts, stops) - radius, np.maximum(starts, stops) + radius
    for near in points.groups(points.blocks_in_box(lo.min(axis=0), hi.max(axis=0))):
        yield _swept_of(points, near, starts, stops, radius)


def balls(
    points: Points, centers: NDArray[np.float64], radius: float
) -> Iterator[NDArray[np.int64]]:
    """Yield numbers of the points within ``radius`` of ``centers`` (K, 3), in sorted parts."""
    if len(centers) == 0:
        return
    lo, hi = centers - radius, centers + radius

    def touches(a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.bool_]:
        met = np.zeros(len(a), np.bool_)
        for k in range(len(centers)):
            met |= ((a <= hi[k]) & (b >= lo[k])).all(axis=1)
        return met

    for near in points.groups(points.blocks_where(touches)):
        yield _swept_of(points, near, centers, centers, radius)


def _swept_of(
    points: Points,
    near: NDArray[np.int64],
    starts: NDArray[np.float64],
    stops: NDArray[np.float64],
    radius: float,
) -> NDArray[np.int64]:
    """Return the numbers of the points of blocks ``near`` in the swept volume."""
    # 1. The blocks' points, gathered once.
    lo, hi = np.minimum(starts, stops) - radius, np.maximum(starts, stops) + radius
    block_lo, block_hi = points.blocks.lo[near], points.blocks.hi[near]
    first = points.blocks.first[near]
    counts = points.blocks.first[near + 1] - first
    numbers = ranges(first, first + counts)
    xyz = points.xyz[numbers].astype(np.float64)
    borders = np.concatenate([[0], np.cumsum(counts)])
    inside, whole = np.zeros(len(numbers), np.bool_), np.zeros(len(near), np.bool_)
    for k in range(len(starts)):
        # 2. Blocks that this segment can still add points of.
        touched = ((block_lo <= hi[k]) & (block_hi >= lo[k])).all(axis=1) & ~whole
        blocks = np.flatnonzero(touched)
        # 3. A capsule is convex: a box with all corners inside lies inside.
        corners = np.where(_CORNERS, block_hi[blocks, None], block_lo[blocks, None])
        distance = _distance_squared(corners.reshape(-1, 3) - starts[k], stops[k] - starts[k])
        whole[blocks[(distance.reshape(-1, 8) <= radius * radius).all(axis=1)]] = True
        # 4. The other boxes' points, one by one, unless an earlier segment took them.
        blocks = blocks[~whole[blocks]]
        open_ = ranges(borders[blocks], borders[blocks + 1])
        open_ = open_[~inside[open_]]
        distance = _distance_squared(xyz[open_] - starts[k], stops[k] - starts[k])
        inside[open_[distance <= radius * radius]] = True
    return np.asarray(numbers[inside | np.repeat(whole, counts)])


def _segments(
    origins: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return starts and ends (S, 3) of the segments of the path."""
    # A controller at rest repeats its origin; repetitions add no volume.
    moved = np.append(True, (np.diff(origins, axis=0) != 0).any(axis=1))
    line = origins[moved]
    return (line, line) if len(line) == 1 else (line[:-1], line[1:])


def _distance_squared(
    offset: NDArray[np.float64], axis: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return squared distances of ``offset`` (n, 3) from the segment from zero to ``axis`` (3,)."""
    length_squared = float(axis @ axis)
    if length_squared > 0:
        along = np.clip(offset @ axis / length_squared, 0.0, 1.0)
        offset = offset - along[:, None] * axis
    squared: NDArray[np.float64] = np.einsum("ij,ij->i", offset, offset)
    return squared


def _take(at: Selecting) -> Parts:
    return swept_parts(at.points, at.origins, at.radius)


SPHERE = Shape(
    "sphere",
    "The volume that a ball sweeps along the samples' origins.",
    (RADIUS,),
    take=_take,
    sweeps=True,
)
