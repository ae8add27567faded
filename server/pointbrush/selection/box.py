"""The box between two hands: every point inside an oriented box."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.points import Points


def box(
    points: Points,
    center: NDArray[np.float64],
    size: NDArray[np.float64],
    rotation: NDArray[np.float64],
) -> Iterator[NDArray[np.int64]]:
    """Numbers of the points in the box; sorted, in parts.

    ``center`` (3,) local metres, ``size`` (3,) full edges, ``rotation`` (3, 3) box axes as columns.
    """
    reach = np.abs(rotation) @ (size / 2)
    for blocks in points.groups(points.blocks_in_box(center - reach, center + reach)):
        numbers = points.numbers(blocks)
        inside = np.abs((points.xyz[numbers].astype(np.float64) - center) @ rotation) <= size / 2
        yield numbers[inside.all(axis=1)]
