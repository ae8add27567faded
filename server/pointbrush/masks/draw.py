"""Masks of pictures from labels of points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.masks.options import VisibilityOptions
from pointbrush.masks.views import View
from pointbrush.masks.visibility import visible
from pointbrush.values.masks import VOID

MOST_GAP = 12
"""Most pixels in a row that are filled between two points of one surface."""
_VISIBILITY = VisibilityOptions()
Image = NDArray[np.uint16]


def draw(view: View, labels: NDArray[np.unsignedinteger]) -> Image:
    """Return a mask (H, W) with the label of the nearest point in each pixel, of ``labels`` (N,).

    A pixel is 0 if its point has no label, and VOID if the camera sees no point there, or several
    points at the same depth with different labels.  Gaps between points of one label and surface
    are filled, except in a lattice, in which each point has its own pixel.
    """
    mask = np.full(view.height * view.width, VOID, np.uint16)
    depth = np.full(view.height * view.width, np.inf, np.float32)
    seen = visible(view, _VISIBILITY)
    far_first = seen[np.argsort(-view.depth[seen], kind="stable")]
    pixel = view.pixel[far_first]
    mask[pixel], depth[pixel] = labels[far_first], view.depth[far_first]
    mask[pixel[mask[pixel] != labels[far_first]]] = VOID
    image = mask.reshape(view.height, view.width)
    if not view.exact:
        depths = depth.reshape(image.shape)
        fill_gaps(image, depths)
        fill_gaps(image.T, depths.T)
    return image


def fill_gaps(mask: Image, depth: NDArray[np.float32]) -> None:
    """Fill gaps along the rows of a mask, in place, between pixels of one value and surface.

    ``depth`` (H, W) metres is infinite without a point; filled pixels get a depth, too.
    """
    measured = np.isfinite(depth)
    column = np.arange(mask.shape[1])
    before = np.maximum.accumulate(np.where(measured, column, -1), axis=1)
    after = np.where(measured, column, mask.shape[1])
    after = np.minimum.accumulate(after[:, ::-1], axis=1)[:, ::-1]
    row, at = np.nonzero(~measured & (before >= 0) & (after - before <= MOST_GAP + 1))
    inside = after[row, at] < mask.shape[1]
    row, at = row[inside], at[inside]
    left, right = before[row, at], after[row, at]
    near, far = depth[row, left], depth[row, right]
    gap = np.maximum(np.minimum(near, far) * _VISIBILITY.depth_tolerance, _VISIBILITY.least_gap)
    same = (mask[row, left] == mask[row, right]) & (np.abs(near - far) <= gap)
    row, at, left, right = row[same], at[same], left[same], right[same]
    mask[row, at] = mask[row, left]
    depth[row, at] = np.maximum(depth[row, left], depth[row, right])
