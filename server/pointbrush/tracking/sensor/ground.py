"""What lies on the ground around a lidar: it shows other rings of it in every frame.

Such points seem to move as the sensor does, and are no help in finding what stands on them.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import minimum_filter

from pointbrush.tracking.interface import F32, Mask
from pointbrush.tracking.sensor.range_image import axis_up

SCALE = 0.02
"""Share of the median distance from the origin that lengths are counted in."""
CELL, THICK, STEP = 6.0, 0.5, 1.0
"""Size of a cell, height above the ground up to which something lies there, and height above the
lowest point around up to which a cell's own lowest is ground, as on a kerb."""
FEWEST, MOST = 2000, 4_000_000
"""Points of a frame from which ground is looked for, and cells of the grid at most."""
ENDS = 0.05
"""Share of the points that are the lowest, or the highest: stray ones are among them."""


def on_ground(xyz: F32) -> Mask:
    """Which points (N, 3) of a frame are hardly higher than the ground there."""
    none = np.zeros(len(xyz), np.bool_)
    if len(xyz) < FEWEST:
        return none
    up = axis_up(xyz)
    scale = SCALE * float(np.median(np.linalg.norm(xyz, axis=1)))
    flat = np.delete(xyz, up, axis=1)
    cell = np.floor((flat - flat.min(axis=0)) / max(CELL * scale, 1e-6)).astype(np.int64)
    shape = cell.max(axis=0) + 1
    if float(np.prod(shape, dtype=np.float64)) > MOST:
        return none
    number = cell[:, 0] * shape[1] + cell[:, 1]
    height = xyz[:, up] * (1.0 if _stands(xyz[:, up]) else -1.0)
    lowest = np.full(int(np.prod(shape)), np.inf, np.float32)
    np.minimum.at(lowest, number, height)
    around = minimum_filter(lowest.reshape(shape), 3, mode="nearest").ravel()
    ground = np.where(lowest < around + STEP * scale, lowest, around)
    return np.asarray(height < ground[number] + THICK * scale)


def _stands(height: F32) -> bool:
    """Whether the axis points up: most of what is measured densely lies below."""
    low, middle, high = np.quantile(height, [ENDS, 0.5, 1 - ENDS])
    return bool(middle - low < high - middle)
