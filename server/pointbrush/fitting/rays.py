"""Free space beside a box, by passing rays, and the ground below it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost
from pointbrush.fitting.options import FitOptions

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
BEFORE_END = 0.06
"""Metres before a ray's end in which it does not count as passing."""


class Steps(NamedTuple):
    """Steps of space beyond a side of a box.

    They go along ``sign`` (1 or -1) times ``axis`` (0 to 2) from ``start``, in metres; ``size``:
    metres of a step; ``number``: of steps.
    """

    axis: int
    sign: float
    start: float
    size: float
    number: int


@innermost
def within(eye: Floats, end: Floats, axis: int, low: Floats, high: Floats) -> tuple[float, float]:
    """Return the part of a ray, from its eye (0) to its end (1), between bounds (3,) of two axes.

    ``axis`` is unbounded.  The second value is less than the first if there is no such part.
    """
    length = 0.0
    for a in range(3):
        length += (end[a] - eye[a]) ** 2
    first, last = 0.0, 1.0 - BEFORE_END / max(np.sqrt(length), BEFORE_END)
    for a in range(3):
        way = end[a] - eye[a]
        if a == axis or (abs(way) < 1e-9 and low[a] <= eye[a] <= high[a]):
            continue
        if abs(way) < 1e-9:
            return 1.0, 0.0
        enter, leave = (low[a] - eye[a]) / way, (high[a] - eye[a]) / way
        first = max(first, min(enter, leave))
        last = min(last, max(enter, leave))
    return first, last


@compiled
def count_passing(eyes: Floats, ends: Floats, steps: Steps, low: Floats, high: Floats) -> Ints:
    """Count the rays ``eyes`` → ``ends`` (N, 3) through each of the ``steps``.

    ``low`` and ``high`` (3,) bound the other axes.
    """
    passing = np.zeros(steps.number, np.int64)
    for ray in range(len(ends)):
        first, last = within(eyes[ray], ends[ray], steps.axis, low, high)
        if last <= first:
            continue
        way = ends[ray, steps.axis] - eyes[ray, steps.axis]
        a0 = steps.sign * (eyes[ray, steps.axis] + first * way - steps.start)
        a1 = steps.sign * (eyes[ray, steps.axis] + last * way - steps.start)
        near, far = min(a0, a1), max(a0, a1)
        if far < 0 or near > steps.size * steps.number:
            continue
        for k in range(
            max(0, int(near / steps.size)), min(steps.number - 1, int(far / steps.size)) + 1
        ):
            passing[k] += 1
    return passing


def ground_height(xyz: Floats, others: Floats, options: FitOptions) -> float | None:
    """Return the height of the ground around points (n, 3) by the lowest of ``others`` in cells.

    The height is in level coordinates; None if there is no ground.
    """
    low, high = xyz.min(axis=0), xyz.max(axis=0)
    reach = options.ground_reach
    near = (
        (others[:, :2] > low[:2] - reach).all(axis=1)
        & (others[:, :2] < high[:2] + reach).all(axis=1)
        & (others[:, 2] < float(np.quantile(xyz[:, 2], 0.03)) + 0.15)
    )
    points = others[near]
    if len(points) < 5:
        return None
    cell = np.floor(points[:, :2] / options.ground_cell).astype(np.int64)
    cells, group = np.unique(cell, axis=0, return_inverse=True)
    lowest = np.full(len(cells), np.inf)
    np.minimum.at(lowest, group.ravel(), points[:, 2])
    if len(lowest) < 3:
        return None
    # The lowest level with a good share of the cells: pavements and walls are above it.
    levels = np.arange(lowest.min(), lowest.max() + 0.1, 0.05)
    shares = (np.abs(lowest[:, None] - levels) < 0.1).sum(axis=0)
    level = levels[int(np.argmax(shares >= 0.5 * shares.max()))]
    on = np.abs(lowest - level) < 0.15
    offset = (cells[on] + 0.5) * options.ground_cell - (low[:2] + high[:2]) / 2
    return _sloping(offset, lowest[on], options)


def _sloping(offset: Floats, height: Floats, options: FitOptions) -> float:
    """Return the height at the origin of a plane through points at ``away`` (n, 2)."""
    middle = np.median(height)
    A = np.column_stack([np.ones(len(offset)), offset])
    ridge = np.diag([0.0, 1, 1]) * (options.ground_noise / options.ground_slope) ** 2
    return float(middle + np.linalg.solve(A.T @ A + ridge, A.T @ (height - middle))[0])
