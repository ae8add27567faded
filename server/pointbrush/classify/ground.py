"""Heights over the ground without the objects on it, by morphological opening."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.options import FeatureOptions

Floats = NDArray[np.float64]
MOST_COLUMNS = 1_000_000
"""Columns of the plan; wider frames get larger ones."""
PIT = 3
"""Columns; points below the ground that fill less than this are outliers."""


def heights_over_opened(center: Floats, size: float, options: FeatureOptions) -> Iterator[Floats]:
    """Yield heights (C,) of cells (C, 3) over the lowest surface, opened at each scale.

    An opening removes objects narrower than its window.  It keeps slopes, which the lowest point
    around a cell does not, so that the heights hold on other terrain (Zhang et al., 2003).
    """
    from scipy.ndimage import maximum_filter, minimum_filter  # loads much that no other call needs

    if not len(center):
        yield from (np.zeros(0) for _ in options.openings)
        return
    plan = center[:, :2] - center[:, :2].min(axis=0)
    extent = np.ptp(plan, axis=0)
    column = max(options.opening_column * size, float(np.sqrt(extent.prod() / MOST_COLUMNS)))
    at = (plan / column).astype(np.int64)
    shape = at.max(axis=0) + 1
    key = at[:, 0] * shape[1] + at[:, 1]
    lowest = np.full(int(shape.prod()), np.inf)
    np.minimum.at(lowest, key, center[:, 2])
    lowest = lowest.reshape(shape)
    peaks = maximum_filter(_filled(lowest, -1), PIT)
    closed = minimum_filter(_filled(peaks, 1), PIT)
    lowest = np.where(np.isfinite(lowest), np.maximum(lowest, closed), np.inf)
    for window in options.openings:
        opened = maximum_filter(_filled(minimum_filter(lowest, window), -1), window)
        yield center[:, 2] - opened.ravel()[key]


def _filled(surface: Floats, sign: int) -> Floats:
    """Replace values that are not finite by an infinity of this sign, which a filter ignores."""
    return np.where(np.isfinite(surface), surface, sign * np.inf)
