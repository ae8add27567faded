"""Compiled loops: bounds, the grid, short paths through a chunk, k-d trees.

They take long to load; therefore modules import them on first use.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost

_FAR = 3900
"""Limit of a difference, so that the sum over seven fields fits in 16 bits."""
_FIELDS = 7
"""Most values of a point; a constant number lets the compiler add all in one pass."""
_FOUR_BITS = 7
_TOO_FAR = 128
"""Additional cost of a value that needs more than four bits (chosen by experiment)."""


@compiled
def bound_runs(
    xyz: NDArray[np.float32], first: NDArray[np.int64]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Bounds (R, 3) of the runs ``first[r]:first[r + 1]`` of points (N, 3), none empty."""
    lo = np.empty((len(first) - 1, 3), np.float32)
    hi = np.empty_like(lo)
    for run in range(len(lo)):
        for axis in range(3):
            least = most = xyz[first[run], axis]
            for n in range(first[run] + 1, first[run + 1]):
                value = xyz[n, axis]
                least = value if value < least else least
                most = value if value > most else most
            lo[run, axis], hi[run, axis] = least, most
    return lo, hi


@compiled
def round_to_grid(
    xyz: NDArray[np.float32], origin: NDArray[np.float64], scale: NDArray[np.float64]
) -> NDArray[np.uint16]:
    """The nearest places of points (N, 3) on a grid that reaches as far as they do."""
    q, per_metre = np.empty(xyz.shape, np.uint16), 1 / scale
    for n in range(len(xyz)):
        for axis in range(3):
            q[n, axis] = np.int64(np.rint((xyz[n, axis] - origin[axis]) * per_metre[axis]))
    return q


@compiled
def walk(values: NDArray[np.int32], first: NDArray[np.int64], way: NDArray[np.int64]) -> None:
    """Write greedy paths through the runs ``first[r]:first[r + 1]`` of ``values`` (F ≤ 7, N)."""
    fields = values.shape[0]
    longest = 0
    for run in range(len(first) - 1):
        longest = max(longest, first[run + 1] - first[run])
    left, now = np.zeros((_FIELDS, longest), np.int16), np.zeros(_FIELDS, np.int16)
    distance = np.empty(longest, np.uint16)
    points, places = np.empty(longest, np.uint32), np.empty(longest, np.int64)
    for run in range(len(first) - 1):
        start, size = first[run], first[run + 1] - first[run]
        for field in range(fields):
            least = values[field, start]
            for place in range(size):
                least = min(least, values[field, start + place])
            for place in range(size):
                left[field, place] = np.int16(min(values[field, start + place] - least, _FAR))
        for place in range(size):
            points[place] = places[place] = place
        position = np.int64(0)
        for step in range(size):
            way[start + step] = start + position
            # The last remaining point takes its place.
            place, last = places[position], size - step - 1
            points[place] = points[last]
            places[points[last]] = place
            for field in range(fields):
                now[field], left[field, place] = left[field, place], left[field, last]
            _measure(left, last, now, distance)
            position = _nearest(distance, points, last)


@innermost
def _nearest(distance: NDArray[np.uint16], points: NDArray[np.uint32], size: int) -> np.int64:
    """The first of the nearest points, fewer than 2**16."""
    least = np.uint32(0xFFFFFFFF)
    for place in range(size):
        least = min(least, np.uint32(np.uint32(distance[place]) << np.uint32(16)) | points[place])
    return np.int64(least & np.uint32(0xFFFF))


@innermost
def _measure(
    left: NDArray[np.int16], size: int, now: NDArray[np.int16], distance: NDArray[np.uint16]
) -> None:
    """Write the cost of the change of all values from ``now`` to each of the first points left."""
    for place in range(size):
        total = np.int16(0)
        for field in range(_FIELDS):
            change = np.int16(abs(np.int16(left[field, place] - now[field])))
            total = np.int16(total + change + np.int16(_TOO_FAR if change > _FOUR_BITS else 0))
        distance[place] = np.uint16(total)


@compiled
def split_points(
    xyz: NDArray[np.float32], leaf: int
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.int64]]:
    """Split points (N, 3), N > 0, at sliding midpoints until ``leaf`` or fewer are together.

    Returns nodes (M, 5): axis, -1 for a leaf, first and behind the last of its points, the nodes
    below and above the split; the splits (M,); and the points' numbers (N,) in the nodes' order.
    """
    count = len(xyz)
    points, numbers = xyz.copy(), np.arange(count)
    nodes, splits = np.empty((count // 8 + 64, 5), np.int64), np.empty(count // 8 + 64, np.float64)
    nodes[0, 1], nodes[0, 2] = 0, count
    made = 1
    node, nodes[0, 0] = 0, -1
    while node >= 0:
        # Waiting nodes are linked by their first column; the nodes of a subtree are contiguous.
        waiting, first, stop = nodes[node, 0], nodes[node, 1], nodes[node, 2]
        axis, low, high = _longest_side(points, first, stop)
        nodes[node, 0] = -1
        nodes[node, 3] = nodes[node, 4] = -1
        splits[node] = 0.0
        # Points at one position stay together.
        if stop - first > leaf and high > low:
            split = np.float32((np.float64(low) + np.float64(high)) / 2)
            split = split if split > low else high
            middle = _part(points, numbers, first, stop, axis, split)
            if made + 2 > len(nodes):
                nodes = np.concatenate((nodes, np.empty_like(nodes)))
                splits = np.concatenate((splits, np.empty_like(splits)))
            nodes[made, 1], nodes[made, 2] = first, middle
            nodes[made + 1, 1], nodes[made + 1, 2] = middle, stop
            nodes[node, 0], splits[node] = axis, split
            nodes[node, 3], nodes[node, 4] = made, made + 1
            nodes[made, 0], nodes[made + 1, 0] = made + 1, waiting
            waiting = made
            made += 2
        node = waiting
    return nodes[:made].copy(), splits[:made].copy(), numbers


@innermost
def _longest_side(
    points: NDArray[np.float32], first: int, stop: int
) -> tuple[int, np.float32, np.float32]:
    """Axis along which points reach farthest, and from where to where."""
    axis, low, high = 0, points[first, 0], points[first, 0]
    for other in range(3):
        least = most = points[first, other]
        for place in range(first + 1, stop):
            value = points[place, other]
            least = value if value < least else least
            most = value if value > most else most
        if np.float64(most) - least > np.float64(high) - low:
            axis, low, high = other, least, most
    return axis, low, high


@innermost
def _part(
    points: NDArray[np.float32],
    numbers: NDArray[np.int64],
    first: int,
    stop: int,
    axis: int,
    split: np.float32,
) -> int:
    """Bring the points below ``split`` to the front; returns where the others begin."""
    low, high = first, stop - 1
    while True:
        while low <= high and points[low, axis] < split:
            low += 1
        while low <= high and points[high, axis] >= split:
            high -= 1
        if low > high:
            return low
        for other in range(3):
            points[low, other], points[high, other] = points[high, other], points[low, other]
        numbers[low], numbers[high] = numbers[high], numbers[low]
        low += 1
        high -= 1
