"""Bodies: all that stands on the ground in one piece, and numbers about the whole of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.grid import connected, neighbours, number_cubes
from pointbrush.compiled import compiled

Floats = NDArray[np.float64]
NAMES = ("body cells", "body tall", "body top", "body bottom", "body long", "body wide")
SUMS = 6


def describe_bodies(center: Floats, height: Floats, floor: float, size: float) -> Floats:
    """Return the numbers (C, 6) of the body that each cell belongs to, 0 for ground.

    ``height`` (C,) over the ground, ``floor`` where bodies begin, metres; cells belong together
    that lie in neighbouring cubes of ``size``.
    """
    above = np.flatnonzero(height > floor)
    out = np.zeros((len(center), len(NAMES)))
    if len(above):
        cube, keys, slots = number_cubes(center[above], np.zeros(3), size)
        body = connected(neighbours(keys, slots))
        out[above] = _numbers(center[above], height[above], body[cube], int(body.max()) + 1)
    return out


@compiled
def _numbers(center: Floats, height: Floats, body: NDArray[np.int64], count: int) -> Floats:
    sums, low, high = np.zeros((count, SUMS)), np.full(count, np.inf), np.full(count, -np.inf)
    for c in range(len(center)):
        row, x, y = sums[body[c]], center[c, 0], center[c, 1]
        row[0] += 1
        row[1] += x
        row[2] += y
        row[3] += x * x
        row[4] += x * y
        row[5] += y * y
        low[body[c]] = min(low[body[c]], height[c])
        high[body[c]] = max(high[body[c]], height[c])
    out = np.empty((len(center), 6))
    for c in range(len(center)):
        b = body[c]
        n, x, y, xx, xy, yy = sums[b]
        xx, xy, yy = xx / n - x * x / n / n, xy / n - x * y / n / n, yy / n - y * y / n / n
        half = np.sqrt(max(((xx - yy) / 2) ** 2 + xy * xy, 0.0))
        out[c, 0] = np.log1p(n)
        out[c, 1], out[c, 2], out[c, 3] = high[b] - low[b], high[b], low[b]
        out[c, 4] = np.sqrt(max((xx + yy) / 2 + half, 0.0))
        out[c, 5] = np.sqrt(max((xx + yy) / 2 - half, 0.0))
    return out
