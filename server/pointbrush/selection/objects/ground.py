"""Ground under a lidar: a lower envelope over columns of the plan."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.selection.objects.options import GroundOptions

Floats = NDArray[np.float64]
LOW_SHARE = 0.005
"""Share of a room's cells that may lie below its floor."""


def height_over_floor(center: Floats) -> Floats:
    """Heights (C,) over the lowest cells, stray ones left out; z up, metres."""
    if len(center) == 0:
        return np.zeros(0)
    return np.asarray(center[:, 2] - np.quantile(center[:, 2], LOW_SHARE))


def height_over_ground(center: Floats, options: GroundOptions) -> Floats:
    """Heights (C,) of cells (C, 3) over the ground under them; z up, metres."""
    if len(center) == 0:
        return np.zeros(0)
    low = center[:, :2].min(axis=0)
    extent = np.ptp(center[:, :2], axis=0)
    column = max(options.column, float(np.sqrt(extent.prod() / options.most_columns)))
    shape = (extent / column).astype(np.int64) + 1
    at = np.minimum(((center[:, :2] - low) / column).astype(np.int64), shape - 1)
    key = at[:, 0] * shape[1] + at[:, 1]
    lowest = _deciles(key, center[:, 2], int(shape.prod()), options).reshape(shape)
    lowest = _without_ghosts(lowest, options)
    if not np.isfinite(lowest).any():
        return height_over_floor(center)
    ground = _envelope(lowest, options.slope * column, options.sweeps)
    below = ground.ravel()[key]
    fallback = float(np.median(lowest[np.isfinite(lowest)]))
    return np.asarray(center[:, 2] - np.where(np.isfinite(below), below, fallback))


def _deciles(key: NDArray[np.int64], z: Floats, columns: int, options: GroundOptions) -> Floats:
    """Low decile (columns,) of the heights in each column, inf where there are few."""
    order = np.lexsort((z, key))
    counts = np.bincount(key, minlength=columns)
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    enough = np.flatnonzero(counts >= options.fewest_points)
    result = np.full(columns, np.inf)
    result[enough] = z[order[first[enough] + (options.decile * counts[enough]).astype(np.int64)]]
    return result


def _without_ghosts(lowest: Floats, options: GroundOptions) -> Floats:
    """The same without columns far under the median of the 5 x 5 round them."""
    ranked = np.where(np.isfinite(lowest), lowest, np.nan)
    padded = np.pad(ranked, 2, constant_values=np.nan)
    around = np.lib.stride_tricks.sliding_window_view(padded, (5, 5))
    known = np.isfinite(lowest)
    median = np.nanmedian(around[known].reshape(-1, 25), axis=1)
    kept = lowest.copy()
    kept[known] = np.where(lowest[known] < median - options.ghost_depth, np.inf, lowest[known])
    return kept


@compiled
def _envelope(lowest: Floats, step: float, sweeps: int) -> Floats:
    """Greatest surface under ``lowest`` that rises by at most ``step`` from column to column."""
    ground = lowest.copy()
    rows, columns = ground.shape
    for sweep in range(sweeps):
        changed = False
        forward = sweep % 2 == 0
        for r0 in range(rows):
            r = r0 if forward else rows - 1 - r0
            for c0 in range(columns):
                c = c0 if forward else columns - 1 - c0
                for dr in range(-1, 2):
                    for dc in range(-1, 2):
                        y, x = r + dr, c + dc
                        if 0 <= y < rows and 0 <= x < columns:
                            way = ground[y, x] + step * np.sqrt(float(dr * dr + dc * dc))
                            if way < ground[r, c] - 1e-9:
                                ground[r, c] = way
                                changed = True
        if not changed:
            break
    return ground
