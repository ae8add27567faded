"""Depth images of the scene: their noise, the farthest depth, and its continuation."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

from pointbrush.tracking.compute.grid import blocks, widened
from pointbrush.tracking.interface import F32, Mask
from pointbrush.tracking.options.sensors import BackgroundOptions, DepthNoiseOptions

DEVIATION = 1.05
"""Ratio of the standard deviation to the median difference of two values: 1.4826 / sqrt(2)."""


class DepthNoise(NamedTuple):
    """Depth noise: standard deviation ``still + growing * depth**2`` metres.

    It grows with the square of the distance, as that of triangulated depth does (Khoshelham and
    Elberink 2012).
    """

    still: float
    growing: float

    def __call__(self, depth: F32) -> F32:
        """Return (M,) standard deviations at (M,) depths."""
        return np.asarray(self.still + self.growing * depth * depth, np.float32)


def default_noise(options: DepthNoiseOptions) -> DepthNoise:
    """Return the noise of an unknown sensor."""
    return DepthNoise(options.default_m, options.default_per_m2)


def measure_noise(one: F32, other: F32, options: DepthNoiseOptions) -> DepthNoise:
    """Fit the noise to the differences of two depth images of a sensor at rest.

    Source of the fit, which is robust to a third of outliers: Theil 1950, Sen 1968.
    """
    both = np.flatnonzero(np.isfinite(one) & np.isfinite(other))
    if len(both) < options.min_pixels:
        return default_noise(options)
    change = np.abs(one[both] - other[both])
    square = one[both].astype(np.float64) ** 2
    parts = np.array_split(np.argsort(square, kind="stable"), options.depth_bins)
    x = np.array([float(np.median(square[p])) for p in parts])
    y = np.array([_spread(change[p], options=options) for p in parts])
    # The median of pairwise slopes is robust: moving objects spoil a bin or two.
    one_part, other_part = np.triu_indices(len(x), 1)
    run = x[other_part] - x[one_part]
    slopes = ((y[other_part] - y[one_part])[run > 1e-6]) / run[run > 1e-6]
    growing = max(0.0, float(np.median(slopes))) if len(slopes) else 0.0
    still = float(np.median(y - growing * x))
    return DepthNoise(max(still, options.floor_m), growing)


def _spread(change: F32, options: DepthNoiseOptions) -> float:
    """Return the standard deviation of depths that differ by ``change`` (M,) between two images.

    Quantised depths, such as a first Kinect's, are mostly equal or one step apart.
    """
    gaussian = float(np.median(change)) * DEVIATION
    other = change[change > options.same_depth_m]
    if len(other) > (1.0 - options.stepped_share) * len(change) or not len(other):
        return gaussian
    return max(gaussian, options.step_sigma * float(np.median(other)))


def drawn_on(depth: F32, shape: tuple[int, int], hidden: Mask, options: BackgroundOptions) -> F32:
    """Return the scene's depth (H * W,) where it is ``hidden`` or unmeasured, NaN elsewhere.

    Surfaces are continued by Laplace's equation in inverse depth.  A plane is linear in it, so that
    floors and walls are continued exactly.  Regions without a measurement for many pixels around
    are infinitely far.
    """
    height, width = shape
    hidden = widened(hidden.reshape(shape), 2).ravel()
    open_ = np.where(hidden, np.nan, 1.0 / depth)
    rows, columns = (-(-height // options.fill_cell_px), -(-width // options.fill_cell_px))
    cells = blocks(open_, shape, options.fill_cell_px)
    known = np.isfinite(cells).sum(axis=1) > options.fill_cell_px
    coarse = np.full(len(cells), np.nan)
    coarse[known] = np.nanmean(cells[known], axis=1)
    scene = np.isfinite(cells).any(axis=1)
    scene |= np.nanmax(blocks(hidden.astype(np.float32), shape, options.fill_cell_px), axis=1) > 0
    coarse[~widened(scene.reshape(rows, columns), options.empty_cells).ravel()] = 0.0
    filled = _laplace(coarse, (rows, columns))
    if filled is None:
        return np.full(len(depth), np.nan, np.float32)
    v, u = np.divmod(np.flatnonzero(~np.isfinite(open_)), width)
    at = [(v + 0.5) / options.fill_cell_px - 0.5, (u + 0.5) / options.fill_cell_px - 0.5]
    result = np.full(len(depth), np.nan, np.float32)
    inverse = map_coordinates(filled.reshape(rows, columns), at, order=1, mode="nearest")
    result[v * width + u] = 1.0 / np.maximum(inverse, 1 / options.far_m)
    return result


def _laplace(values: NDArray[np.float64], shape: tuple[int, int]) -> NDArray[np.float64] | None:
    """Return ``values`` (R * C,) with each NaN the mean of its neighbours; None: all are NaN."""
    unknown = np.isnan(values)
    if unknown.all():
        return None
    if not unknown.any():
        return values
    number = np.arange(len(values)).reshape(shape)
    pairs = np.concatenate(
        [
            np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1),
            np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1),
        ]
    )
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    pairs = pairs[unknown[pairs[:, 0]]]
    position = np.cumsum(unknown) - 1
    count = int(unknown.sum())
    row, other = position[pairs[:, 0]], pairs[:, 1]
    degree = np.bincount(row, minlength=count).astype(np.float64)
    inner = unknown[other]
    right = np.bincount(row[~inner], weights=values[other[~inner]], minlength=count)
    entries = np.concatenate([degree, np.full(int(inner.sum()), -1.0)])
    rows = np.concatenate([np.arange(count), row[inner]])
    columns = np.concatenate([np.arange(count), position[other[inner]]])
    matrix = coo_matrix((entries, (rows, columns)), shape=(count, count)).tocsc()
    result = values.copy()
    result[unknown] = spsolve(matrix, right)
    return result


def farthest(
    images: Iterable[F32], noise: DepthNoise, options: BackgroundOptions
) -> tuple[F32, F32]:
    """Return (H * W,) the farthest depth of each pixel, and the number of images that show it.

    ``images``: depths (H * W,) of frames across a recording, so that the scene behind passing
    objects is known from the first frame on.
    """
    best = count = None
    for image in images:
        if best is None or count is None:
            best, count = image.copy(), np.isfinite(image).astype(np.float32)
            continue
        limit = options.near_sigmas * noise(image)
        change = image - best
        farther = np.isfinite(image) & ~(change <= limit)
        same = np.flatnonzero(np.abs(change) <= limit)
        count[same] += 1
        best[same] += change[same] / count[same]
        np.copyto(best, image, where=farther)
        count[farther] = 1
    if best is None or count is None:
        return np.empty(0, np.float32), np.empty(0, np.float32)
    return best, count


def continued(depth: F32, known: Mask, shape: tuple[int, int], options: BackgroundOptions) -> Mask:
    """Return a mask (H * W,) of surfaces that continue to ``known`` cells in the same row.

    Furniture continues beside the person in front of it; a person ends on all sides except at the
    floor.
    """
    image = depth.reshape(shape)
    start = np.ones(shape, np.bool_)
    with np.errstate(invalid="ignore"):
        start[:, 1:] = ~(np.abs(np.diff(image, axis=1)) < options.surface_jump_share * image[:, 1:])
    surface = np.cumsum(start.ravel()) - 1
    enough = np.bincount(surface, weights=known) >= options.min_known_beside
    return np.asarray(enough[surface], np.bool_)
