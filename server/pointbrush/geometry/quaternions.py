"""Rotations as quaternions x, y, z, w."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError


def rotation_of(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the rotation (3, 3) of a quaternion x, y, z, w.  Raises BadInputError for none."""
    norm = math.hypot(*quaternion)
    if not 1e-9 <= norm < math.inf:
        raise BadInputError(
            f"quaternion: expected a rotation x, y, z, w, got {quaternion.tolist()}"
        )
    x, y, z, w = quaternion / norm
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_of(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the quaternion x, y, z, w of a rotation (3, 3)."""
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
    # The greatest component of the four, squared and times four, divides the others (Shepperd).
    parts = np.array(
        [
            [1 + a - e - i, d + b, c + g, h - f],
            [d + b, 1 - a + e - i, h + f, c - g],
            [c + g, h + f, 1 - a - e + i, d - b],
            [h - f, c - g, d - b, 1 + a + e + i],
        ]
    )
    row = parts[int(np.argmax(np.diag(parts)))]
    return np.asarray(row / math.hypot(*row))
