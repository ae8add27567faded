"""Nearest points: a grid of columns over the two directions in which a cloud is widest.

Points measured on surfaces fill few cells of a grid in space, and few lie behind each other, so
that columns hold a handful each.  A search goes outward from the column of the wanted point, ring
by ring, and ends where nothing nearer can come.  Source: Bentley, Weide and Yao 1980, with colour
as part of the distance.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled, innermost
from pointbrush.tracking.interface import F32, F64, I64, Mask

Triple = tuple[float, float, float]
PER_COLUMN = 3.0
"""Points of a column, if they were spread evenly over the whole width."""


NONE: F32 = np.empty((0, 3), np.float32)
"""Tints of points without."""


class Columns(NamedTuple):
    """Points (N, 3), in metres, sorted by column, for searches in place and colour.

    ``tint`` (N, 3) their colours times ``weight``, metres per unit of colour; (0, 3), and 0.0,
    where colour does not count.  ``order`` (N,) the points' numbers as they were given.  There are
    ``along`` x ``across`` square columns, ``size`` metres wide: column (i, j) has the points sorted
    from ``start[i * across + j]`` up to the next entry.  ``axes`` are the two axes that they lie
    over, ``low`` (2,) the least coordinate on each.
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
    """Return the slot, of ``count``, that holds ``at``; the first or the last for values outside.

    Compiled loops do not check what they index with: what is no number goes to the first.
    """
    return int(min(at, count - 1.0)) if at > 0.0 else 0


@compiled
def _extent(xyz: F64) -> tuple[F64, F64]:
    """Lowest corner (3,) and size (3,) of the box around the finite points (N, 3)."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for i in range(len(xyz)):
        for a in range(3):
            if abs(xyz[i, a]) < np.inf:
                low[a], high[a] = min(low[a], xyz[i, a]), max(high[a], xyz[i, a])
    return low, np.maximum(high - low, 0.0)


@compiled
def columns(xyz: F64, tint: F32, weight: float) -> Columns:
    """Sort points (N, 3) with ``tint`` (N, 3), times ``weight``, where that is not zero."""
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
    """Room for what a search has to look through at a time."""
    return np.empty((4 * max(grid.along, grid.across) + 4, 2), np.int64)


@innermost
def _ring(grid: Columns, u: float, v: float, ring: int, best: float, room: I64) -> int:
    """Number of stretches of sorted points, now in ``room``, that a ring of columns holds.

    It lies around (u, v); columns ``best`` square metres away or farther are left out.  -1 where
    they all are, and so are those of larger rings.
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
    """Square of the distance to the point that is sorted ``at``."""
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
    """Square of the distance to the nearest point, and where it is sorted; -1 for none.

    ``point`` and ``tint`` in metres; nearer than ``most`` metres; ``room`` as of ``spans``;
    ``likely`` where a point is sorted beyond which there is nothing to look for.
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
    """One of the colours (M, 3), in metres as the grid's; zeros where it has none."""
    if not len(grid.tint):
        return 0.0, 0.0, 0.0
    weight = grid.weight
    return weight * colour[i, 0], weight * colour[i, 1], weight * colour[i, 2]


@compiled
def nearest(grid: Columns, xyz: F64, colour: F32, most: float) -> tuple[F64, I64]:
    """Distances (M,) below ``most`` metres, and indices (M,), of the nearest to points (M, 3).

    ``colour`` (M, 3) counts where the grid has any.  Where nothing is so near the distance is
    ``most`` and the index -1.
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
    """Whether a point is less than ``most`` metres away; see ``nearest_one``."""
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
    """Mark the points (M, 3) with one less than ``most`` metres away; see ``nearest``."""
    found = np.empty(len(xyz), np.bool_)
    for i in range(len(xyz)):
        point = (xyz[i, 0], xyz[i, 1], xyz[i, 2])
        found[i] = any_near(grid, point, toned(grid, colour, i), most)
    return found


@compiled
def nearer_than(grid: Columns, xyz: F64, colour: F32, most: F64) -> Mask:
    """Mark the points (M, 3) with one less than ``most`` (M,) metres away; see ``nearest``."""
    found = np.empty(len(xyz), np.bool_)
    for i in range(len(xyz)):
        point = (xyz[i, 0], xyz[i, 1], xyz[i, 2])
        found[i] = any_near(grid, point, toned(grid, colour, i), most[i])
    return found


@compiled
def nearest_three(grid: Columns, xyz: F64, most: float) -> tuple[F64, I64]:
    """Distances (M, 3) below ``most`` metres, and indices (M, 3), of the three nearest in place.

    Nearest first; infinite, and -1, where there are no more.
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
    """Squares of the distances to the three nearest, and where they are sorted; -1 for none."""
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
    """(P, 2) all pairs of points (N, 3) at most ``most`` metres apart, the lesser number first."""
    grid = columns(xyz, np.empty((0, 3), np.float32), 0.0)
    found, count = np.empty((8 * len(xyz) + 8, 2), np.int64), 0
    steps, start = int(most / grid.size) + 1, grid.start
    for row in range(grid.along):
        for column in range(grid.across):
            here = row * grid.across + column
            low, high = max(column - steps, 0), min(column + steps, grid.across - 1)
            for one in range(start[here], start[here + 1]):
                # Each pair is met once: from the point that is sorted first.
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
    """Write to ``free`` (F, 2) the pairs of a point and those of a stretch of sorted ones; how
    many there are."""
    count = 0
    x, y, z = grid.xyz[one, 0], grid.xyz[one, 1], grid.xyz[one, 2]
    for other in range(*others):
        dx, dy, dz = x - grid.xyz[other, 0], y - grid.xyz[other, 1], z - grid.xyz[other, 2]
        if dx * dx + dy * dy + dz * dz <= most * most:
            i, j = grid.order[one], grid.order[other]
            free[count, 0], free[count, 1] = min(i, j), max(i, j)
            count += 1
    return count
