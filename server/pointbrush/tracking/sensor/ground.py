"""What lies on the ground around a lidar: it shows other rings of it in every frame.

Such points seem to move as the sensor does, and are no help in finding what stands on them.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import minimum_filter

from pointbrush.tracking.interface import F32, Mask
from pointbrush.tracking.options import GroundOptions, TrackerOptions
from pointbrush.tracking.sensor.range_image import axis_up


def on_ground(xyz: F32, options: TrackerOptions) -> Mask:
    """Which points (N, 3) of a frame are hardly higher than the ground there."""
    none = np.zeros(len(xyz), np.bool_)
    if len(xyz) < options.ground.min_points:
        return none
    up = axis_up(xyz, options=options.range_image)
    scale = options.ground.length_share * float(np.median(np.linalg.norm(xyz, axis=1)))
    flat = np.delete(xyz, up, axis=1)
    cell = np.floor((flat - flat.min(axis=0)) / max(options.ground.cell * scale, 1e-6)).astype(
        np.int64
    )
    shape = cell.max(axis=0) + 1
    if float(np.prod(shape, dtype=np.float64)) > options.ground.max_cells:
        return none
    number = cell[:, 0] * shape[1] + cell[:, 1]
    height = xyz[:, up] * (1.0 if _stands(xyz[:, up], options=options.ground) else -1.0)
    lowest = np.full(int(np.prod(shape)), np.inf, np.float32)
    np.minimum.at(lowest, number, height)
    around = minimum_filter(lowest.reshape(shape), 3, mode="nearest").ravel()
    ground = np.where(lowest < around + options.ground.kerb * scale, lowest, around)
    return np.asarray(height < ground[number] + options.ground.thickness * scale)


def _stands(height: F32, options: GroundOptions) -> bool:
    """Whether the axis points up: most of what is measured densely lies below."""
    low, middle, high = np.quantile(height, [options.stray_share, 0.5, 1 - options.stray_share])
    return bool(middle - low < high - middle)
