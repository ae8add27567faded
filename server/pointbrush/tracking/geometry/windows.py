"""Neighbourhoods in images, by whole rows and columns at a time: each some NumPy calls."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from pointbrush.tracking.interface import F32, Mask

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


def blocks(image: F32, shape: tuple[int, int], size: int) -> F32:
    """(B, size ** 2) values of the blocks of an image (H * W,), row by row, NaN beyond it."""
    height, width = shape
    rows, columns = -(-height // size), -(-width // size)
    padded = np.full((rows * size, columns * size), np.nan, np.float32)
    padded[:height, :width] = image.reshape(shape)
    return padded.reshape(rows, size, columns, size).transpose(0, 2, 1, 3).reshape(-1, size**2)
