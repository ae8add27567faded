"""Neighbourhoods in images, by whole rows and columns at a time: each some NumPy calls."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from pointbrush.tracking.interface import Mask

A = TypeVar("A", bound=NDArray[np.generic])


def least_around(image: A) -> A:
    """(H, W) the least of each pixel and its eight neighbours."""
    result = image.copy()
    for axis in (0, 1):
        of, to = result.swapaxes(0, axis).copy(), result.swapaxes(0, axis)
        np.minimum(to[1:], of[:-1], out=to[1:])
        np.minimum(to[:-1], of[1:], out=to[:-1])
    return result


def widened(image: Mask, steps: int) -> Mask:
    """(H, W) the pixels that are ``steps`` or fewer from a set one, up, down and sideways."""
    result = image.copy()
    for _ in range(steps):
        before = result.copy()
        result[1:] |= before[:-1]
        result[:-1] |= before[1:]
        result[:, 1:] |= before[:, :-1]
        result[:, :-1] |= before[:, 1:]
    return result
