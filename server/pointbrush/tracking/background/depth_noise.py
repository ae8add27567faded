"""How much measured depth wavers where nothing moves, as the recording itself shows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pointbrush.tracking.interface import F32
from pointbrush.tracking.options import DepthNoiseOptions

DEVIATION = 1.05
"""Standard deviation of a depth, over the median difference of two of them: 1.4826 / sqrt(2)."""


class DepthNoise(NamedTuple):
    """Depth noise: standard deviation ``still + growing * depth**2`` metres.

    It grows with the square of the distance, as that of triangulated depth does (Khoshelham and
    Elberink 2012).
    """

    still: float
    growing: float

    def __call__(self, depth: F32) -> F32:
        """(M,) standard deviations at (M,) depths."""
        return np.asarray(self.still + self.growing * depth * depth, np.float32)


def default_noise(options: DepthNoiseOptions) -> DepthNoise:
    """Return the noise of a sensor that is not known."""
    return DepthNoise(options.default_m, options.default_per_m2)


def measure_noise(one: F32, other: F32, options: DepthNoiseOptions) -> DepthNoise:
    """Fit the noise to the differences of two depth images of a sensor that stands still.

    Source of the fit, which a third of wrong values does not touch: Theil 1950, Sen 1968.
    """
    both = np.flatnonzero(np.isfinite(one) & np.isfinite(other))
    if len(both) < options.min_pixels:
        return default_noise(options)
    change = np.abs(one[both] - other[both])
    square = one[both].astype(np.float64) ** 2
    parts = np.array_split(np.argsort(square, kind="stable"), options.depth_bins)
    x = np.array([float(np.median(square[p])) for p in parts])
    y = np.array([_spread(change[p], options=options) for p in parts])
    # Slopes of pairs, and their median: what moved between the images spoils a part or two.
    one_part, other_part = np.triu_indices(len(x), 1)
    run = x[other_part] - x[one_part]
    slopes = ((y[other_part] - y[one_part])[run > 1e-6]) / run[run > 1e-6]
    growing = max(0.0, float(np.median(slopes))) if len(slopes) else 0.0
    still = float(np.median(y - growing * x))
    return DepthNoise(max(still, options.floor_m), growing)


def _spread(change: F32, options: DepthNoiseOptions) -> float:
    """Standard deviation of depths that differ by ``change`` (M,) between two images.

    What comes in steps, as a first Kinect's does, is mostly the same or a step away.
    """
    gaussian = float(np.median(change)) * DEVIATION
    other = change[change > options.same_depth_m]
    if len(other) > (1.0 - options.stepped_share) * len(change) or not len(other):
        return gaussian
    return max(gaussian, options.step_sigma * float(np.median(other)))
