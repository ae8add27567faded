"""Connectivity of points by steps of a maximum length from an object."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.compute.columns import NONE, Columns, any_near, columns
from pointbrush.tracking.compute.grid import bounds, close_to, within
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.sensors.view import View


class Limits(NamedTuple):
    """Limits for connected surface to be a whole object.

    It has to end within ``steps`` of ``reach`` metres, with at most ``most`` points, all in the box
    from ``low`` (3,) to ``high`` (3,).
    """

    reach: float
    steps: int
    most: int
    low: F64
    high: F64


def connected(core: F64, rest: F64, reach: float, rounds: int) -> Mask:
    """Mark the points of ``rest`` (N, 3) connected with ``core`` over steps of ``reach`` metres."""
    joined = np.zeros(len(rest), np.bool_)
    front = core
    for _ in range(rounds):
        open_ = np.flatnonzero(~joined)
        if not len(open_) or not len(front):
            break
        new = open_[close_to(rest[open_], front, reach)]
        joined[new] = True
        front = rest[new]
    return joined


def blob(view: View, core: I64, rest: I64, limits: Limits) -> I64 | None:
    """Return all of ``rest`` connected to ``core``; None: it does not end within the ``limits``.

    A component that moves alone in the air is the object, including new surface.  A component that
    does not end within a few steps is connected to a larger object, such as a hand or a body.
    """
    front = view.xyz[core].astype(np.float64)
    lo, hi = bounds(front)
    far = limits.steps * limits.reach
    rest = rest[within(view.xyz.take(rest, axis=0), lo - far, hi + far)]
    joined, ends = flood(front, view.xyz[rest].astype(np.float64), limits)
    return rest[joined] if ends else None


@compiled
def flood(core: F64, rest: F64, limits: Limits) -> tuple[Mask, bool]:
    """Mark the points of ``rest`` (N, 3) connected with ``core`` (M, 3).

    The second result is whether they end within the ``limits``; otherwise they are incomplete.
    """
    reach = limits.reach
    joined, order = np.zeros(len(rest), np.bool_), np.empty(len(rest), np.int64)
    count = _mark_near_core(core, rest, reach, joined, order)
    if count == 0:
        return joined, True
    first, grid = 0, columns(rest, NONE, 0.0)
    # Points of each column that have not joined, so that each is tested until it joins.
    left, ends = np.arange(len(rest)), grid.start[1:].copy()
    for _ in range(limits.steps):
        last = count
        if first == last:
            return joined, True
        if count > limits.most or not _all_inside(rest, order[first:last], limits):
            return joined, False
        for k in range(first, last):
            count = _join_around(rest, order[k], grid, reach, (left, ends), joined, order, count)
        first = last
    return joined, first == count


@compiled
def _all_inside(rest: F64, some: I64, limits: Limits) -> bool:
    """Return whether the points ``some`` (M,) of (N, 3) lie in the box of the ``limits``."""
    for i in some:
        for a in range(3):
            if not limits.low[a] <= rest[i, a] <= limits.high[a]:
                return False
    return True


@compiled
def _join_around(
    rest: F64,
    middle: int,
    grid: Columns,
    reach: float,
    unasked: tuple[I64, I64],
    joined: Mask,
    order: I64,
    count: int,
) -> int:
    """Join the points of ``rest`` (N, 3) closer than ``reach`` to one; return the new ``count``.

    ``unasked``: indices of each column's points, and the end of the points not joined yet.
    """
    left, ends = unasked
    at, steps = rest[middle], int(reach / grid.size) + 1
    row = int((at[grid.axes[0]] - grid.low[0]) / grid.size)
    column = int((at[grid.axes[1]] - grid.low[1]) / grid.size)
    low, high = max(column - steps, 0), min(column + steps, grid.across - 1)
    for other in range(max(row - steps, 0), min(row + steps, grid.along - 1) + 1):
        for cell in range(other * grid.across + low, other * grid.across + high + 1):
            i = grid.start[cell]
            while i < ends[cell]:
                point, square = grid.order[left[i]], 0.0
                for a in range(3):
                    square += (rest[point, a] - at[a]) ** 2
                if not joined[point] and square >= reach * reach:
                    i += 1
                    continue
                if not joined[point]:
                    joined[point] = True
                    order[count] = point
                    count += 1
                ends[cell] -= 1
                left[i] = left[ends[cell]]
    return count


@compiled
def _mark_near_core(core: F64, rest: F64, reach: float, joined: Mask, order: I64) -> int:
    """Mark the points of ``rest`` near the core and write them to ``order``; return the number."""
    lo, hi = bounds(core)
    grid, count = columns(core, NONE, 0.0), 0
    for i in range(len(rest)):
        x, y, z = rest[i, 0], rest[i, 1], rest[i, 2]
        gap = max(lo[0] - x, x - hi[0], lo[1] - y, y - hi[1], lo[2] - z, z - hi[2])
        if gap < reach and any_near(grid, (x, y, z), (0.0, 0.0, 0.0), reach):
            joined[i] = True
            order[count] = i
            count += 1
    return count
