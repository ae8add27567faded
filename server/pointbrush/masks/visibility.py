"""Visibility of points in a picture, by a depth buffer of the points themselves.

A sensor beside the camera measures points that nearer surfaces hide from the camera.  In the
picture, points of the surface in front then lie on both sides of the hidden point.  On one surface,
even a slanted one, the depth increases to one side and decreases to the other.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pointbrush.masks.options import VisibilityOptions
from pointbrush.masks.views import View


def visible(view: View, options: VisibilityOptions) -> NDArray[np.int64]:
    """Return the numbers of the points that the camera sees, increasing."""
    seen = view.seen
    if view.exact or not len(seen):
        return seen
    depth, pixel = view.depth[seen], view.pixel[seen]
    spacing = point_spacing(view, seen)
    cell = max(1, round(spacing / 2))
    row, column = (at // cell for at in np.divmod(pixel, view.width))
    buffer = np.zeros((-(-view.height // cell), -(-view.width // cell)), np.float32)
    np.maximum.at(buffer, (row, column), 1 / depth)
    reach = min(max(options.reach * spacing, options.least_reach), options.most_reach)
    front = _front(buffer, max(1, round(reach / cell)))[row, column]
    nearest = np.zeros(view.height * view.width, np.float32)
    np.maximum.at(nearest, pixel, 1 / depth)
    np.maximum(front, nearest[pixel], out=front)
    gap = np.maximum(depth * options.depth_tolerance, options.least_gap)
    return np.asarray(seen[depth - 1 / front <= gap])


def point_spacing(view: View, seen: NDArray[np.int64]) -> float:
    """Return the mean distance of points in the part of the picture that they cover, pixels."""
    row, column = np.divmod(view.pixel[seen], view.width)
    area = (int(np.ptp(row)) + 1) * (int(np.ptp(column)) + 1)
    return math.sqrt(area / len(np.unique(view.pixel[seen])))


def _front(buffer: NDArray[np.float32], reach: int) -> NDArray[np.float32]:
    """Return the inverse depth (h, w) of a surface on two opposite sides of each cell, 0 for none.

    ``buffer`` (h, w): inverse depths of the nearest points, 0 without one; ``reach``: cells to each
    side.  On an axis, the farther side counts; of both axes, the nearer surface.
    """
    from scipy.ndimage import maximum_filter1d  # slow to import

    front = np.zeros_like(buffer)
    for grid, out in ((buffer, front), (buffer.T, front.T)):
        margin = reach + 1
        padded = np.pad(grid, ((0, 0), (margin, margin)))
        greatest = maximum_filter1d(padded, reach, axis=1, mode="constant")
        # The window of cell i begins at i - reach // 2 and has ``reach`` cells.
        first = margin + reach // 2
        before = greatest[:, first - reach :][:, : grid.shape[1]]
        after = greatest[:, first + 1 :][:, : grid.shape[1]]
        np.maximum(out, np.minimum(before, after), out=out)
    return front
