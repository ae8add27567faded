"""Rotations of boxes: Euler angles both ways, and the axes of the level."""

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


def euler_angles(rotation: Floats, order: Order) -> Floats:
    """Compute the angles (3,) about x, y and z that give ``rotation`` (3, 3) by ``euler_matrix``.

    If y is a quarter turn, only the sum of the others is known: the last one to turn is 0.
    """
    # The transpose has the inverse factors in reverse order.
    R = rotation if order == "zyx" else rotation.T
    across = float(np.hypot(R[2, 1], R[2, 2]))
    y = np.arctan2(-R[2, 0], across)
    if across > 1e-9:
        angles = np.array([np.arctan2(R[2, 1], R[2, 2]), y, np.arctan2(R[1, 0], R[0, 0])])
    else:
        angles = np.array([0.0, y, np.arctan2(-R[0, 1], R[1, 1])])
    return angles if order == "zyx" else -angles


def upright_axes(up: NDArray[np.floating]) -> Floats:
    """Make ``R_upright_source`` (3, 3): rows forward, left, up; the identity for z up.

    If z is not vertical, it is forward, as for a camera (x right, y down, z ahead).
    """
    vertical = np.asarray(up, np.float64) / np.linalg.norm(up)
    aside = np.eye(3)[2 if abs(vertical[2]) < 0.9 else 0]
    forward = aside - vertical * (aside @ vertical)
    forward /= np.linalg.norm(forward)
    return np.stack([forward, np.cross(vertical, forward), vertical])
