"""Cells of a frame: one for each occupied cube, independent of the density of points.

Ground in lidar scans is separated first, by a lower envelope over columns of the plan.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.selection.objects.options import CellOptions, GroundOptions
from pointbrush.sensor_kind import SensorKind

Floats = NDArray[np.float64]
LOW_SHARE = 0.005
"""Share of a room's cells that may lie below its floor."""
MOST_SAMPLED = 300_000
"""Maximum sampled points to count the cells of a size."""
TRIES = 5
"""Number of candidate sizes."""
LOWEST_SIZE = 1e-4
"""Metres; the smallest cell."""
REMISSION = 100.0
"""CIE L of the strongest return."""


def height_over_floor(center: Floats) -> Floats:
    """Return heights (C,) above the lowest cells, without outliers; z up, metres."""
    if len(center) == 0:
        return np.zeros(0)
    return np.asarray(center[:, 2] - np.quantile(center[:, 2], LOW_SHARE))


def height_over_ground(center: Floats, options: GroundOptions) -> Floats:
    """Return heights (C,) of cells (C, 3) above the ground below them; z up, metres."""
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
    """Return the low decile (columns,) of the heights in each column, inf if there are few."""
    order = np.lexsort((z, key))
    counts = np.bincount(key, minlength=columns)
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    enough = np.flatnonzero(counts >= options.fewest_points)
    result = np.full(columns, np.inf)
    result[enough] = z[order[first[enough] + (options.decile * counts[enough]).astype(np.int64)]]
    return result


def _without_ghosts(lowest: Floats, options: GroundOptions) -> Floats:
    """Return ``lowest`` without columns far below the median of their 5 x 5 neighbourhood."""
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
    """Return the highest surface below ``lowest`` with slopes of at most ``step`` per column."""
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


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """C cells of ``size`` metres.

    ``of_point`` (N,): int32, cell of each point; ``center`` (C, 3): mean of its points, metres;
    ``lab`` (C, 3): mean colour in CIE Lab.
    """

    size: float
    of_point: NDArray[np.int32]
    center: Floats
    lab: Floats


def make_cells(
    xyz: Floats,
    rgb: NDArray[np.uint8] | None,
    intensity: NDArray[np.floating] | None,
    sensor: SensorKind,
    options: CellOptions,
) -> Cells:
    """Return the cells of points (N, 3), metres; ``intensity`` (N,) stands in for colour."""
    size = cell_size(xyz, sensor, options)
    order, first = _grouped(_keys(xyz, size))
    count = len(first)
    of_point = np.empty(len(xyz), np.int32)
    ends = np.append(first[1:], len(xyz))
    number = np.repeat(np.arange(count, dtype=np.int32), ends - first)
    of_point[order] = number
    share = 1.0 / np.maximum(ends - first, 1)

    def mean(column: NDArray[np.generic]) -> Floats:
        return np.bincount(of_point, column, minlength=count) * share

    center = np.stack([mean(xyz[:, k]) for k in range(3)], axis=1)
    lab = np.zeros((count, 3))
    if rgb is not None:
        lab = lab_of(np.stack([mean(rgb[:, k]) for k in range(3)], axis=1))
    elif intensity is not None:
        strongest = max(float(np.quantile(intensity, 0.995)) if len(intensity) else 0.0, 1e-12)
        lab[:, 0] = REMISSION * mean(np.clip(intensity / strongest, 0.0, 1.0))
    return Cells(size, of_point, center, lab)


def cell_size(xyz: Floats, sensor: SensorKind, options: CellOptions) -> float:
    """Return the size, in metres, for a suitable number of cells."""
    size = options.lidar_size if sensor == "lidar" else options.size
    n = len(xyz)
    if n == 0:
        return size
    step = -(-n // MOST_SAMPLED)
    sample = np.ascontiguousarray(xyz[::step])
    fewest = options.lidar_fewest if sensor == "lidar" else options.fewest
    fewest = min(fewest, int(n / step / options.points_per_cell))
    for _ in range(TRIES):
        count = _occupied(sample, size)
        if count < fewest:
            factor = max(np.sqrt(count / fewest) * 0.95, 0.3)
        elif count > options.most:
            factor = np.sqrt(count / options.most) * 1.05
        else:
            break
        size = max(size * factor, LOWEST_SIZE)
    # The coordinates of a cell must fit into 21 bits each.
    return max(float(size), float(np.ptp(xyz, axis=0).max()) / 2**20)


def _keys(xyz: Floats, size: float) -> NDArray[np.int64]:
    """Return a unique number (N,) of each point's cube."""
    low = xyz.min(axis=0) if len(xyz) else np.zeros(3)
    cube = np.floor((xyz - low) / size).astype(np.int64)
    return np.asarray((cube[:, 0] << 42) | (cube[:, 1] << 21) | cube[:, 2])


def _grouped(keys: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return an order (N,) that groups equal keys, and the start of each group."""
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    starts = np.flatnonzero(np.diff(ordered, prepend=ordered[:1] - 1))
    return order, starts


@compiled
def _occupied(xyz: Floats, size: float) -> int:
    """Return the number of occupied cubes."""
    bits = 1
    while (1 << bits) < 2 * len(xyz):
        bits += 1
    slots = np.full(1 << bits, -1, np.int64)
    low = np.array([xyz[:, 0].min(), xyz[:, 1].min(), xyz[:, 2].min()])
    count = 0
    for i in range(len(xyz)):
        key = 0
        for k in range(3):
            key = (key << 21) | (int((xyz[i, k] - low[k]) / size) & 0x1FFFFF)
        at = ((key * 0x9E3779B97F4A7C1) >> 20) & ((1 << bits) - 1)
        while slots[at] != -1 and slots[at] != key:
            at = (at + 1) & ((1 << bits) - 1)
        if slots[at] == -1:
            slots[at] = key
            count += 1
    return count


def lab_of(rgb: Floats) -> Floats:
    """Return CIE Lab (n, 3) of sRGB 0..255 (n, 3), white D65."""
    part = rgb / 255.0
    light = np.where(part > 0.04045, ((part + 0.055) / 1.055) ** 2.4, part / 12.92)
    matrix = np.array(
        [
            [0.4124564, 0.3575761, 0.1804375],
            [0.2126729, 0.7151522, 0.0721750],
            [0.0193339, 0.1191920, 0.9503041],
        ]
    )
    white = np.array([0.95047, 1.0, 1.08883])
    share = light @ matrix.T / white
    f = np.where(share > 216 / 24389, np.cbrt(share), (24389 / 27 * share + 16) / 116)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], 1)
