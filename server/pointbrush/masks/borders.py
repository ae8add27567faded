"""Borders between the values of a mask."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.values.masks import VOID

Mask = NDArray[np.unsignedinteger]


def border_distance(mask: Mask) -> NDArray[np.float32]:
    """Return the distance (H * W,) of each pixel from the nearest pixel of another value, pixels.

    A void pixel has the value of the nearest pixel that is not void.
    """
    from scipy.ndimage import distance_transform_edt  # slow to import

    void = mask == VOID
    if void.any() and not void.all():
        row, column = distance_transform_edt(void, return_distances=False, return_indices=True)
        mask = mask[row, column]
    border = np.zeros(mask.shape, np.bool_)
    for axis in (0, 1):
        before, after = neighbours(axis)
        differs = mask[before] != mask[after]
        border[before] |= differs
        border[after] |= differs
    if not border.any():
        return np.full(mask.size, np.inf, np.float32)
    return np.asarray(distance_transform_edt(~border) + 1, np.float32).ravel()


def neighbours(axis: int) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """Return the slices of an image that pair each pixel with the next one along an axis."""
    before, after = [slice(None)] * 2, [slice(None)] * 2
    before[axis], after[axis] = slice(None, -1), slice(1, None)
    return tuple(before), tuple(after)
