"""Rotations of boxes by Euler angles and quaternions."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Order = Literal["xyz", "zyx"]
"""Factors of the rotation matrix from left to right: ``zyx`` is Rz Ry Rx (scipy's ``xyz``, angles
about fixed axes), ``xyz`` is Rx Ry Rz (the default of three.js)."""


def euler_matrix(angles: Floats, order: Order) -> Floats:
    """Compute the rotation (3, 3) of angles (3,) about x, y and z, radians, counter-clockwise."""
    x, y, z = angles
    cx, sx, cy, sy, cz, sz = np.cos(x), np.sin(x), np.cos(y), np.sin(y), np.cos(z), np.sin(z)
    about = {
        "x": np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]]),
        "y": np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]]),
        "z": np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]]),
    }
    first, second, third = (about[axis] for axis in order)
    return np.asarray(first @ second @ third)
