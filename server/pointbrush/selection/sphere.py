"""The ball brush: the volume that a ball sweeps from each sample's origin to the next."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.points import Points


def swept_ball(points: Points, origins: NDArray[np.float64], radius: float) -> NDArray[np.int64]:
    """Numbers of the points within ``radius`` of the polyline ``origins`` (S, 3), local metres.

    One sample is a ball, two are a capsule.  Sorted, each point once.
    """
    if len(origins) == 0:
        return np.empty(0, np.int64)
    # A controller held still repeats its origin; the repeats sweep nothing new.
    moved = np.append(True, (np.diff(origins, axis=0) != 0).any(axis=1))
    line = origins[moved]
    starts, stops = (line, line) if len(line) == 1 else (line[:-1], line[1:])
    lo, hi = np.minimum(starts, stops) - radius, np.maximum(starts, stops) + radius
    near = points.blocks_in_box(lo.min(axis=0), hi.max(axis=0))
    block_lo, block_hi = points.blocks.lo[near], points.blocks.hi[near]
    found = []
    for k in range(len(starts)):
        touched = ((block_lo <= hi[k]) & (block_hi >= lo[k])).all(axis=1)
        numbers = points.numbers(near[touched])
        offset = points.xyz[numbers].astype(np.float64) - starts[k]
        found.append(numbers[_distance_squared(offset, stops[k] - starts[k]) <= radius * radius])
    return np.unique(np.concatenate(found))


def _distance_squared(
    offset: NDArray[np.float64], axis: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Squared distance of ``offset`` (n, 3) to the segment from zero to ``axis`` (3,)."""
    length_squared = float(axis @ axis)
    if length_squared > 0:
        along = np.clip(offset @ axis / length_squared, 0.0, 1.0)
        offset = offset - along[:, None] * axis
    squared: NDArray[np.float64] = np.einsum("ij,ij->i", offset, offset)
    return squared
