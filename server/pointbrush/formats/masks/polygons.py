"""Pixels inside polygons."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def fill_polygon(mask: NDArray[np.bool_], corners: NDArray[np.float64]) -> None:
    """Set the pixels of a mask (height, width) with centres inside a polygon (n, 2), x and y.

    The first pixel's centre is at (0.5, 0.5).  Where a polygon crosses itself, the even-odd rule
    decides.
    """
    size = np.array(mask.shape[::-1])
    low = np.floor(corners.min(axis=0)).clip(0, size).astype(np.int64)
    high = np.ceil(corners.max(axis=0)).clip(0, size).astype(np.int64)
    if (low < high).all():
        part = mask[low[1] : high[1], low[0] : high[0]]
        part |= _inside(corners - low, *part.shape)


def _inside(corners: NDArray[np.float64], height: int, width: int) -> NDArray[np.bool_]:
    """Return the pixels (height, width) with an odd number of edges to their left."""
    upper, lower = corners, np.roll(corners, -1, axis=0)
    swapped = (upper[:, 1] > lower[:, 1])[:, None]
    upper, lower = np.where(swapped, lower, upper), np.where(swapped, upper, lower)
    first, stop = (_first(ends[:, 1], height) for ends in (upper, lower))
    count = stop - first
    edge = np.repeat(np.arange(len(count)), count)
    row = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count - first, count)
    slope = (lower[edge, 0] - upper[edge, 0]) / (lower[edge, 1] - upper[edge, 1])
    column = _first(upper[edge, 0] + slope * (row + 0.5 - upper[edge, 1]), width)
    edges = np.bincount(row * (width + 1) + column, minlength=height * (width + 1))
    return np.asarray(np.cumsum(edges.reshape(height, -1)[:, :width], axis=1) % 2 == 1)


def _first(place: NDArray[np.float64], most: int) -> NDArray[np.int64]:
    """Return the first row or column (n,) with a centre at or after a place, up to ``most``."""
    return np.ceil(place - 0.5).clip(0, most).astype(np.int64)
