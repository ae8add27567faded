"""Numbers that describe one region by its sums: shared by merging and by valuing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import innermost
from pointbrush.selection.objects import sums
from pointbrush.selection.objects.eigen import eigenvalues

Floats = NDArray[np.float64]


@innermost
def extents(row: Floats, out: Floats) -> None:
    """Write the root eigenvalues, metres, least first, of a region's spread to ``out`` (3,)."""
    n, x, s = row[sums.COUNT], sums.XYZ, sums.SQUARES
    mx, my, mz = row[x] / n, row[x + 1] / n, row[x + 2] / n
    low, middle, high = eigenvalues(
        row[s] / n - mx * mx,
        row[s + 1] / n - mx * my,
        row[s + 2] / n - mx * mz,
        row[s + 3] / n - my * my,
        row[s + 4] / n - my * mz,
        row[s + 5] / n - mz * mz,
    )
    out[0], out[1], out[2] = np.sqrt(max(low, 0)), np.sqrt(max(middle, 0)), np.sqrt(max(high, 0))


@innermost
def colour_spread(row: Floats) -> float:
    """Return the standard deviation of a region's Lab colours."""
    n, total = row[sums.COUNT], 0.0
    for k in range(3):
        mean = row[sums.LAB + k] / n
        total += max(row[sums.LAB_SQUARES + k] / n - mean * mean, 0.0)
    return float(np.sqrt(total))


@innermost
def normal_length(row: Floats) -> float:
    """Return the length of the mean normal: 1 flat, 0 closed."""
    x, y, z = row[sums.NORMAL], row[sums.NORMAL + 1], row[sums.NORMAL + 2]
    return float(np.sqrt(x * x + y * y + z * z) / row[sums.COUNT])


@innermost
def box(row: Floats, out: Floats) -> None:
    """Write height, longer and shorter side of the upright box, metres, to ``out`` (3,)."""
    a = row[sums.HIGH] - row[sums.LOW]
    b = row[sums.HIGH + 1] - row[sums.LOW + 1]
    out[0], out[1], out[2] = row[sums.HIGH + 2] - row[sums.LOW + 2], max(a, b), min(a, b)
