"""Mounts of sensors: rigid transforms from a sensor's coordinates to a frame's."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.values.kinds import FARTHEST

Matrix = NDArray[np.float64]
MOST_OFF = 1e-3
"""Greatest difference of an element of R Rᵀ from the identity, which rounding causes."""


def rigid_mount(where: str, values: Any) -> Matrix:
    """Return the transform (4, 4) of 16 numbers by rows, or of 4 rows of 4 numbers.

    Raises BadInputError naming ``where`` unless it is a rotation and a translation.
    """
    try:
        matrix = np.array(values, np.float64).reshape(4, 4)
    except (TypeError, ValueError):
        raise BadInputError(
            f"{where}: expected 16 numbers of a 4x4 matrix, got {str(values)[:100]}"
        ) from None
    if not (np.abs(matrix) <= FARTHEST).all():
        raise BadInputError(
            f"{where}: expected numbers up to {FARTHEST:g}, got {matrix.ravel().tolist()}"
        )
    R = matrix[:3, :3]
    if np.abs(matrix[3] - (0, 0, 0, 1)).max() > MOST_OFF:
        raise BadInputError(f"{where}: expected 0 0 0 1 as the last row, got {matrix[3].tolist()}")
    if np.abs(R @ R.T - np.eye(3)).max() > MOST_OFF:
        raise BadInputError(
            f"{where}: expected a rotation and a translation, got a matrix that scales or skews"
        )
    if np.linalg.det(R) < 0:
        raise BadInputError(
            f"{where}: expected a rotation of right-handed axes, got one of left-handed axes"
        )
    matrix[3] = 0, 0, 0, 1
    return matrix
