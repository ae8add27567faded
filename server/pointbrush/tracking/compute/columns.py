"""Nearest neighbours in a grid of columns over the two widest axes of a cloud.

Points on surfaces fill few cells of a grid in space, and few lie behind each other, so that a
column has a handful of points.  A search proceeds from the column of the query point outward, ring
by ring, until no nearer point is possible.  Source: Bentley, Weide and Yao 1980, with colour as
part of the distance.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled, innermost
from pointbrush.tracking.interface import F32, F64, I64, Mask

Triple = tuple[float, float, float]
PER_COLUMN = 3.0
"""Mean number of points of a column, for points spread uniformly."""


NONE: F32 = np.empty((0, 3), np.float32)
"""Tints of points without colour."""


class Columns(NamedTuple):
    """Points (N, 3), in metres, sorted by column, for searches in place and colour.

    ``tint`` (N, 3): their colours times ``weight``, metres per unit of colour; (0, 3), and 0.0,
    if colour does not count.  ``order`` (N,): original indices of the points.  There are
    ``along`` x ``across`` square columns, ``size`` metres wide: column (i, j) has the sorted points
    from ``start[i * across + j]`` up to the next entry.  ``axes``: the two axes of the grid;
    ``low`` (2,): the minimum coordinate on each.
    """

    xyz: F64
    tint: F64
    weight: float
    order: I64
    start: I64
    axes: tuple[int, int]
    low: tuple[float, float]
    size: float
    along: int
    across: int


@innermost
def _slot(at: float, count: int) -> int:
    """Return the slot, of ``count``, that contains ``at``; values outside are clipped.

    Compiled loops do not check indices, so NaN maps to the first slot.
    """
    return int(min(at, count - 1.0)) if at > 0.0 else 0


@compiled
def _extent(xyz: F64) -> tuple[F64, F64]:
    """Return the lowest corner (3,) and size (3,) of the box around finite points (N, 3)."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for i in range(len(xyz)):
        for a in range(3):
            if abs(xyz[i, a]) < np.inf:
                low[a], high[a] = min(low[a], xyz[i, a]), max(high[a], xyz[i, a])
    return low, np.maximum(high - low, 0.0)


@compiled
def columns(xyz: F64, tint: F32, weight: float) -> Columns:
    """Return the columns of points (N, 3), with ``weight`` times ``tint`` (N, 3) if not zero."""
    count = len(xyz)
    low, extent = _extent(xyz)
    thin = 0
    for a in range(1, 3):
        if extent[a] <= extent[thin]:
            thin = a
    one, other = (1 if thin == 0 else 0), (1 if thin == 2 else 2)
    wide, tall = extent[one], extent[other]
    size = max(
        np.sqrt(wide * tall * PER_COLUMN / max(count, 1)),
        max(wide, tall) * PER_COLUMN / max(count, 1),
        1e-9,
    )
    along, across = int(wide / size) + 1, int(tall / size) + 1
    cell = np.empty(count, np.int64)
    start = np.zeros(along * across + 1, np.int64)
    for i in range(count):
        row = _slot((xyz[i, one] - low[one]) / size, along)
        cell[i] = row * across + _slot((xyz[i, other] - low[other]) / size, across)
        start[cell[i] + 1] += 1
    for c in range(along * across):
        start[c + 1] += start[c]
    free = start[:-1].copy()
    order = np.empty(count, np.int64)
    coloured = weight != 0.0
    sorted_xyz, tinted = np.empty((count, 3)), np.empty((count if coloured else 0, 3))
    for i in range(count):
        at = free[cell[i]]
        free[cell[i]] += 1
        order[at] = i
        for a in range(3):
            sorted_xyz[at, a] = xyz[i, a]
            if coloured:
                tinted[at, a] = weight * tint[i, a]
    lows = (low[one], low[other])
    axes = (one, other)
    return Columns(sorted_xyz, tinted, weight, order, start, axes, lows, size, along, across)


@compiled
def spans(grid: Columns) -> I64:
    """Return a buffer for the ranges of sorted points in a ring of columns."""
    return np.empty((4 * max(grid.along, grid.across) + 4, 2), np.int64)


@innermost
def _ring(grid: Columns, u: float, v: float, ring: int, best: float, room: I64) -> int:
    """Write the ranges of sorted points in a ring of columns to ``room``; return their number.

    The ring is around (u, v).  Columns at a squared distance of ``best`` or more are left out; -1
    if this applies to all, also of larger rings.
    """
    size, along, across = grid.size, grid.along, grid.across
    row, column = _slot(u / size, along), _slot(v / size, across)
    if ring == 0:
        room[0, 0] = grid.start[row * across + column]
        room[0, 1] = grid.start[row * across + column + 1]
        return 1
    first, last, low, high = row - ring, row + ring, column - ring, column + ring
    before = first >= 0 and (u - (first + 1) * size) ** 2 < best
    after = last < along and (last * size - u) ** 2 < best
    below = low >= 0 and (v - (low + 1) * size) ** 2 < best
    above = high < across and (high * size - v) ** 2 < best
    if not (before or after or below or above):
        return -1
    count = 0
    for wanted, at in ((before, first), (after, last)):
        if wanted:
            room[count, 0] = grid.start[at * across + max(low, 0)]
            room[count, 1] = grid.start[at * across + min(high, across - 1) + 1]
            count += 1
    for wanted, at in ((below, low), (above, high)):
        if wanted:
            for between in range(max(first + 1, 0), min(last, along)):
                room[count, 0] = grid.start[between * across + at]
                room[count, 1] = grid.start[between * across + at + 1]
                count += 1
    return count


@innermost
def _square(grid: Columns, at: int, point: Triple, tint: Triple) -> float:
    """Return the squared distance to the point at the sorted position ``at``."""
    (x, y, z), (r, g, b) = point, tint
    dx, dy, dz = grid.xyz[at, 0] - x, grid.xyz[at, 1] - y, grid.xyz[at, 2] - z
    square = float(dx * dx + dy * dy + dz * dz)
    if len(grid.tint):
        dr, dg, db = grid.tint[at, 0] - r, grid.tint[at, 1] - g, grid.tint[at, 2] - b
        square += dr * dr + dg * dg + db * db
    return square


@innermost
def nearest_one(
    grid: Columns, point: Triple, tint: Triple, most: float, room: I64, likely: int = -1
) -> tuple[float, int]:
    """Return the squared distance and sorted position of the nearest point; -1: none.

    ``point`` and ``tint`` in metres; ``most``: maximum distance (m); ``room``: see ``spans``;
    ``likely``: sorted position of a point that bounds the search.
    """
    x, y, z = point
    r, g, b = tint
    coloured = len(grid.tint) > 0
    u, v = point[grid.axes[0]] - grid.low[0], point[grid.axes[1]] - grid.low[1]
    best, nearest_at, ring = most * most, -1, 0
    if likely >= 0:
        square = _square(grid, likely, point, tint)
        if square < best:
            best, nearest_at = square, likely
    while True:
        count = _ring(grid, u, v, ring, best, room)
        if count < 0:
            return best, nearest_at
        for k in range(count):
            for at in range(room[k, 0], room[k, 1]):
                dx, dy, dz = grid.xyz[at, 0] - x, grid.xyz[at, 1] - y, grid.xyz[at, 2] - z
                square = dx * dx + dy * dy + dz * dz
                if coloured and square < best:
                    dr, dg, db = grid.tint[at, 0] - r, grid.tint[at, 1] - g, grid.tint[at, 2] - b
                    square += dr * dr + dg * dg + db * db
                if square < best:
                    best, nearest_at = square, at
        ring += 1


@innermost
def toned(grid: Columns, colour: F32, i: int) -> Triple:
    """Return one of the colours (M, 3) in the grid's metres; zeros if the grid has none."""
    if not len(grid.tint):
        return 0.0, 0.0, 0.0
    weight = grid.weight
    return weight * colour[i, 0], weight * colour[i, 1], weight * colour[i, 2]


@compiled
def nearest(grid: Columns, xyz: F64, colour: F32, most: float) -> tuple[F64, I64]:
    """Return distances (M,) below ``most`` metres and indices (M,) of neighbours of (M, 3).

    ``colour`` (M, 3) counts if the grid has colours.  Without a neighbour the distance is ``most``
    and the index -1.
    """
    count, room = len(xyz), spans(grid)
    distance, index = np.full(count, most), np.full(count, -1)
    for i in range(count):
        point = (xyz[i, 0], xyz[i, 1], xyz[i, 2])
        square, at = nearest_one(grid, point, toned(grid, colour, i), most, room)
        if at >= 0:
            distance[i], index[i] = np.sqrt(square), grid.order[at]
    return distance, index


@innermost
def any_near(grid: Columns, point: Triple, tint: Triple, most: float) -> bool:
    """Return whether a point is closer than ``most`` metres; see ``nearest_one``."""
    x, y, z = point
    r, g, b = tint
    size, along, across = grid.size, grid.along, grid.across
    u, v = point[grid.axes[0]] - grid.low[0], point[grid.axes[1]] - grid.low[1]
    left, right = _slot((v - most) / size, across), _slot((v + most) / size, across)
    for row in range(_slot((u - most) / size, along), _slot((u + most) / size, along) + 1):
        for at in range(grid.start[row * across + left], grid.start[row * across + right + 1]):
            dx, dy, dz = grid.xyz[at, 0] - x, grid.xyz[at, 1] - y, grid.xyz[at, 2] - z
            square = dx * dx + dy * dy + dz * dz
            if len(grid.tint) and square < most * most:
                dr, dg, db = grid.tint[at, 0] - r, grid.tint[at, 1] - g, grid.tint[at, 2] - b
                square += dr * dr + dg * dg + db * db
            if square < most * most:
                return True
    return False


@compiled
def any_near_each(grid: Columns, xyz: F64, colour: F32, most: float) -> Mask:
    """Mark the points (M, 3) with a neighbour closer than ``most`` metres; see ``nearest``."""
    found = np.empty(len(xyz), np.bool_)
    for i in range(len(xyz)):
        point = (xyz[i, 0], xyz[i, 1], xyz[i, 2])
        found[i] = any_near(grid, point, toned(grid, colour, i), most)
    return found


@compiled
def nearer_than(grid: Columns, xyz: F64, colour: F32, most: F64) -> Mask:
    """Mark the points (M, 3) with a neighbour closer than ``most`` (M,) metres; see ``nearest``."""
    found = np.empty(len(xyz), np.bool_)
    for i in range(len(xyz)):
        point = (xyz[i, 0], xyz[i, 1], xyz[i, 2])
        found[i] = any_near(grid, point, toned(grid, colour, i), most[i])
    return found


@compiled
def nearest_three(grid: Columns, xyz: F64, most: float) -> tuple[F64, I64]:
    """Return distances (M, 3) below ``most`` metres and indices (M, 3) of three neighbours.

    They are in ascending order, without colour; missing ones are infinite with index -1.
    """
    distance, index = np.full((len(xyz), 3), np.inf), np.full((len(xyz), 3), -1)
    order, room = grid.order, spans(grid)
    for i in range(len(xyz)):
        squares, slots = _three(grid, (xyz[i, 0], xyz[i, 1], xyz[i, 2]), most, room)
        for k in range(3):
            if slots[k] >= 0:
                distance[i, k], index[i, k] = np.sqrt(squares[k]), order[slots[k]]
    return distance, index


@innermost
def _three(
    grid: Columns, point: Triple, most: float, room: I64
) -> tuple[Triple, tuple[int, int, int]]:
    """Return squared distances and sorted positions of the three nearest points; -1: none."""
    x, y, z = point
    u, v = point[grid.axes[0]] - grid.low[0], point[grid.axes[1]] - grid.low[1]
    first, second, third = most * most, most * most, most * most
    one, two, three, ring = -1, -1, -1, 0
    while True:
        count = _ring(grid, u, v, ring, third, room)
        if count < 0:
            return (first, second, third), (one, two, three)
        for k in range(count):
            for at in range(room[k, 0], room[k, 1]):
                dx, dy, dz = grid.xyz[at, 0] - x, grid.xyz[at, 1] - y, grid.xyz[at, 2] - z
                square = dx * dx + dy * dy + dz * dz
                if square < first:
                    third, second, first = second, first, square
                    three, two, one = two, one, at
                elif square < second:
                    third, second = second, square
                    three, two = two, at
                elif square < third:
                    third, three = square, at
        ring += 1


@compiled
def pairs(xyz: F64, most: float) -> I64:
    """Return (P, 2) all pairs of points (N, 3) within ``most`` metres, the lesser index first."""
    grid = columns(xyz, np.empty((0, 3), np.float32), 0.0)
    found, count = np.empty((8 * len(xyz) + 8, 2), np.int64), 0
    steps, start = int(most / grid.size) + 1, grid.start
    for row in range(grid.along):
        for column in range(grid.across):
            cell = row * grid.across + column
            low, high = max(column - steps, 0), min(column + steps, grid.across - 1)
            for one in range(start[cell], start[cell + 1]):
                # Each pair occurs once, at its first point in sorted order.
                for other_row in range(row, min(row + steps, grid.along - 1) + 1):
                    first = max(start[other_row * grid.across + low], one + 1)
                    end = start[other_row * grid.across + high + 1]
                    if count + end - first > len(found):
                        more = np.empty((2 * len(found) + end - first, 2), np.int64)
                        more[:count] = found[:count]
                        found = more
                    count += _pairs_of(grid, one, (first, end), most, found[count:])
    return found[:count]


@innermost
def _pairs_of(grid: Columns, one: int, others: tuple[int, int], most: float, free: I64) -> int:
    """Write the pairs of a point with a range of sorted points to ``free`` (F, 2).

    Returns their number.
    """
    count = 0
    x, y, z = grid.xyz[one, 0], grid.xyz[one, 1], grid.xyz[one, 2]
    for other in range(*others):
        dx, dy, dz = x - grid.xyz[other, 0], y - grid.xyz[other, 1], z - grid.xyz[other, 2]
        if dx * dx + dy * dy + dz * dz <= most * most:
            i, j = grid.order[one], grid.order[other]
            free[count, 0], free[count, 1] = min(i, j), max(i, j)
            count += 1
    return count
