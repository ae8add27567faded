"""Rigid transforms (4, 4), named for their direction: ``T_target_source``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]


def translation(offset: Matrix) -> Matrix:
    """Return the transform that adds ``offset`` (3,)."""
    T = np.eye(4)
    T[:3, 3] = offset
    return T


def inverse(T: Matrix) -> Matrix:
    """Return the inverse of a rigid transform; exact for a translation."""
    inverted = np.eye(4)
    turn = T[:3, :3].T
    inverted[:3, :3] = turn
    inverted[:3, 3] = -(turn @ T[:3, 3])
    return inverted


def transformed(T: Matrix, points: Matrix) -> Matrix:
    """Return points (N, 3) moved by ``T``."""
    return np.asarray(points @ T[:3, :3].T + T[:3, 3])
