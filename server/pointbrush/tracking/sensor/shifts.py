"""By how far a scene may have been shifted between two frames, wherever it was.

What stands up is seen as a picture from above, along the direction in which the scene is the
narrowest; the correlation of two such pictures is high where walls' ends, poles and parked cars
lie on each other.  The ground and long walls, which look the same after any shift, count little.
Source: phase correlation, Kuglin and Hines 1975, here with half the whitening.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.tracking.interface import F64
from pointbrush.tracking.options import ScanOdometryOptions


def likely_shifts(
    before: F64, here: F64, cell: float, count: int, options: ScanOdometryOptions
) -> F64:
    """(count, 3) metres, the likeliest first, that bring points (N, 3) near to points (M, 3).

    Both thinned to cells of ``cell`` metres; ``before`` turned as ``here`` is.
    """
    pixel = options.shift_pixel_cells * cell
    middle = np.median(before, axis=0)
    around = before - middle
    around = around[(np.abs(around) < options.shift_side_px * pixel).all(axis=1)]
    _, axes = np.linalg.eigh(np.einsum("ni,nj->ij", around, around))
    wide = axes[:, :0:-1]
    pictures = [
        _upright((xyz - middle) @ axes[:, ::-1], pixel, options=options) for xyz in (before, here)
    ]
    one, other = (np.fft.rfft2(picture) for picture in pictures)
    product = other * np.conj(one)
    product /= np.abs(product) ** options.shift_whitening + 1e-9
    middle_part = slice(
        options.shift_side_px // 2 - options.shift_max_px,
        options.shift_side_px // 2 + options.shift_max_px + 1,
    )
    likeness = np.fft.fftshift(
        np.fft.irfft2(product, s=(options.shift_side_px, options.shift_side_px))
    )[middle_part, middle_part]
    shifts = np.empty((count, 3))
    for number in range(count):
        row, column = (int(i) for i in np.unravel_index(likeness.argmax(), likeness.shape))
        shifts[number] = wide @ (
            np.array(
                [
                    row - options.shift_max_px,
                    column - options.shift_max_px,
                ]
            )
            * pixel
        )
        rows = slice(
            max(0, row - options.shift_same_px),
            row + options.shift_same_px + 1,
        )
        likeness[
            rows,
            max(0, column - options.shift_same_px) : column + options.shift_same_px + 1,
        ] = -np.inf
    return shifts


def _upright(xyz: F64, pixel: float, options: ScanOdometryOptions) -> NDArray[np.float64]:
    """(WIDTH, WIDTH) where points (N, 3) stand up along the last axis, seen along it."""
    xyz = xyz[(np.abs(xyz[:, :2]) < (options.shift_side_px // 2 - 1) * pixel).all(axis=1)]
    at = np.floor(xyz[:, :2] / pixel).astype(np.int64) + options.shift_side_px // 2
    number, height = at[:, 0] * options.shift_side_px + at[:, 1], xyz[:, 2]
    high, low = (
        np.full(options.shift_side_px**2, -np.inf),
        np.full(options.shift_side_px**2, np.inf),
    )
    np.maximum.at(high, number, height)
    np.minimum.at(low, number, height)
    return (
        np.asarray(high > low + options.shift_steep_px * pixel)
        .astype(np.float64)
        .reshape(options.shift_side_px, options.shift_side_px)
    )
