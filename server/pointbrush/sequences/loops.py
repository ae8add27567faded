"""Compiled loops: bounds, the grid, packing of the vertex codec, short ways, k-d trees.

They take long to load, so that modules import them where they are needed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost
from pointbrush.sequences.codec import GROUP, PLAIN, ZERO, Bytes

_ONES = np.uint64(0x0101010101010101)
_LOW_BITS = np.uint64(0x7F7F7F7F7F7F7F7F)
"""Eight bytes of 1, and of 127."""
_CHANGE_BITS = np.log2(1.0 + np.abs(np.arange(256, dtype=np.uint8).view(np.int8).astype(float)))
"""Bits of a change of a byte, modulo 256."""
_FAR = 3900
"""Differences count up to this, so that those of seven fields together fit 16 bits."""
_FIELDS = 7
"""Values of a point at most; a number known beforehand lets all be added in one pass."""
_FOUR_BITS = 7
_TOO_FAR = 128
"""Cost of a value that needs more than four bits, besides its difference (found by trial)."""


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
def change_bits(colors: Bytes, runs: NDArray[np.int64]) -> tuple[float, float]:
    """Bits of the changes of r and b along runs (R, P) of points, as they are and less g's."""
    alone = relative = 0.0
    for run in range(len(runs)):
        for place in range(1, runs.shape[1]):
            old, new = colors[runs[run, place - 1]], colors[runs[run, place]]
            green = np.uint8(new[1] - old[1])
            for part in (0, 2):
                change = np.uint8(new[part] - old[part])
                alone += _CHANGE_BITS[change]
                relative += _CHANGE_BITS[np.uint8(change - green)]
    return alone, relative


@compiled
def lay_out(q: NDArray[np.uint16], colors: Bytes, flags: int, related: bool) -> Bytes:
    """Each byte (12, N) of the vertices of positions (N, 3) and colours (N, 4).

    ``related``: r and b less g.
    """
    out = np.empty((12, len(q)), np.uint8)
    for n in range(len(q)):
        x, y, z = q[n, 0], q[n, 1], q[n, 2]
        out[0, n], out[1, n] = x & 255, x >> 8
        out[2, n], out[3, n] = y & 255, y >> 8
        out[4, n], out[5, n] = z & 255, z >> 8
        green = colors[n, 1] if related else np.uint8(0)
        out[6, n], out[7, n] = np.uint8(colors[n, 0] - green), colors[n, 1]
        out[8, n], out[9, n] = np.uint8(colors[n, 2] - green), colors[n, 3]
    out[10], out[11] = flags, 0
    return out


@compiled
def pack_blocks(lanes: Bytes, words: int, size: int, out: Bytes) -> int:
    """Write the blocks of a vertex stream, ``size`` vertices each, into ``out``.

    ``lanes`` (stride, N) are the vertices, byte by byte.  The first ``words`` bytes of a vertex are
    16-bit values.  Returns the bytes written; ``out`` holds for each block its control bytes and,
    for each byte of a vertex, one more for every four groups than its vertices; and one byte in
    all.
    """
    stride, count = lanes.shape
    values = np.zeros((stride, size // GROUP, GROUP), np.uint8)
    eights = values.view(np.uint64)
    packed = np.empty(size // GROUP, np.int64)
    codes = np.empty(size // GROUP, np.int64)
    at = 0
    for start in range(0, count, size):
        points = min(size, count - start)
        _differences(lanes, start, points, words, values.reshape(stride, size))
        head = at
        at += stride // 4
        out[head:at] = 0
        for lane in range(stride):
            control = _choose(eights[lane], points, packed, codes)
            out[head + lane // 4] |= np.uint8(control << (2 * (lane % 4)))
            at = _write_lane(values[lane], points, control, codes, out, at)
    return at


@innermost
def _differences(lanes: Bytes, start: int, points: int, words: int, values: Bytes) -> None:
    """Zigzag differences of a block's vertices to those before them, zeros behind the last."""
    for lane in range(len(lanes)):
        for place in range(points, -(-points // GROUP) * GROUP):
            values[lane, place] = 0
    first = 0 if start else 1  # the very first has none before it
    for lane in range(0, words, 2):
        low, high = lanes[lane, start : start + points], lanes[lane + 1, start : start + points]
        low_before = lanes[lane, start - 1 + first : start + points - 1]
        high_before = lanes[lane + 1, start - 1 + first : start + points - 1]
        values[lane, 0] = values[lane + 1, 0] = 0
        for place in range(points - first):
            now = place + first
            new = np.int32(low[now]) | np.int32(high[now]) << 8
            old = np.int32(low_before[place]) | np.int32(high_before[place]) << 8
            step = np.int32(np.int16(new - old))
            zigzag = (step << 1) ^ (step >> 15)
            values[lane, now] = np.uint8(zigzag & 255)
            values[lane + 1, now] = np.uint8((zigzag >> 8) & 255)
    for lane in range(words, len(lanes)):
        byte = lanes[lane, start : start + points]
        before = lanes[lane, start - 1 + first : start + points - 1]
        values[lane, 0] = 0
        for place in range(points - first):
            now = place + first
            change = np.int8(np.uint8(byte[now] - before[place]))
            values[lane, now] = np.uint8(np.uint8(change << 1) ^ np.uint8(change >> 7))


@innermost
def _at_least(eight: np.uint64, least: int) -> int:
    """Count those of eight bytes that are ``least``, at most 128, or more."""
    below = (eight & _LOW_BITS) + np.uint64(128 - least) * _ONES
    return int((((below | eight) >> np.uint64(7) & _ONES) * _ONES) >> np.uint64(56))


@innermost
def _choose(
    eights: NDArray[np.uint64], points: int, packed: NDArray[np.int64], codes: NDArray[np.int64]
) -> int:
    """Fill in each group's two bits for the packing of least bytes; returns the control value.

    ``eights`` (groups, 2) are the values, eight at once.
    """
    groups = -(-points // GROUP)
    first = second = -(-points // (4 * GROUP))
    fits, zero = True, True
    for group in range(groups):
        low, high = eights[group, 0], eights[group, 1]
        if low | high == 0:
            packed[group] = codes[group] = 0
            second += 2
            continue
        zero = False
        least, code = 2 + _at_least(low, 1) + _at_least(high, 1), 0
        three = 4 + _at_least(low, 3) + _at_least(high, 3)
        if three < least:
            least, code = three, 1
        fifteen = 8 + _at_least(low, 15) + _at_least(high, 15)
        if fifteen < least:
            least, code = fifteen, 2
        first += least
        # A group of more than 16 bytes would be legal in the first choice, but never pays.
        fits = fits and least <= GROUP
        second += min(least, GROUP)
        packed[group], codes[group] = least, code
    if zero:
        return ZERO
    control = 1 if second < first or not fits else 0
    if (second if control == 1 else first) >= points:
        return PLAIN
    for group in range(groups):
        if control == 0:
            codes[group] = codes[group] + 1 if packed[group] > 0 else 0
        elif packed[group] >= GROUP:
            codes[group] = 3
    return control


@innermost
def _write_lane(
    values: Bytes, points: int, control: int, codes: NDArray[np.int64], out: Bytes, at: int
) -> int:
    """Write one byte of a block's vertices (groups, 16) at ``at``; returns where it ends."""
    if control == ZERO:
        return at
    groups = -(-points // GROUP)
    if control == PLAIN:
        for group in range(groups):
            for place in range(min(GROUP, points - group * GROUP)):
                out[at + place] = values[group, place]
            at += min(GROUP, points - group * GROUP)
        return at
    header = at
    at += -(-groups // 4)
    for place in range(header, at):
        out[place] = 0
    for group in range(groups):
        code = codes[group]
        out[header + group // 4] |= np.uint8(code << (2 * (group % 4)))
        width = code + control  # 1, 2, 4 bits: 1, 2, 3
        if width == 1:
            at = _write_group(values[group], 1, out, at)
        elif width == 2:
            at = _write_group(values[group], 2, out, at)
        elif width == 3:
            at = _write_group(values[group], 4, out, at)
        elif width:
            for place in range(GROUP):
                out[at + place] = values[group, place]
            at += GROUP
    return at


@innermost
def _write_group(values: Bytes, bits: int, out: Bytes, at: int) -> int:
    """Write a group (16,) at ``at``, ``bits`` a value and whole those that have not enough.

    Returns where it ends; the byte behind may have been written to, too.
    """
    most = (1 << bits) - 1
    per_byte = 8 // bits
    for place in range(GROUP // per_byte):
        byte = 0
        for part in range(per_byte):
            low = min(int(values[place * per_byte + part]), most)
            # Single bits count from the lowest, wider values from the highest.
            byte |= low << (part if bits == 1 else bits * (per_byte - 1 - part))
        out[at + place] = np.uint8(byte)
    at += GROUP // per_byte
    for place in range(GROUP):
        # Without a branch, which would be foreseen badly.
        out[at] = values[place]
        at += values[place] >= most
    return at


@compiled
def walk(values: NDArray[np.int32], first: NDArray[np.int64], way: NDArray[np.int64]) -> None:
    """Write greedy ways through the runs ``first[r]:first[r + 1]`` of ``values`` (F ≤ 7, N)."""
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
        here = np.int64(0)
        for step in range(size):
            way[start + step] = start + here
            # The last of those that are left takes its place.
            place, last = places[here], size - step - 1
            points[place] = points[last]
            places[points[last]] = place
            for field in range(fields):
                now[field], left[field, place] = left[field, place], left[field, last]
            _measure(left, last, now, distance)
            here = _nearest(distance, points, last)


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
    """Write what the change of all values costs from ``now`` to each of the first points left."""
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
        # Nodes that wait are linked by their first column; a subtree lies together in the end.
        waiting, first, stop = nodes[node, 0], nodes[node, 1], nodes[node, 2]
        axis, low, high = _longest_side(points, first, stop)
        nodes[node, 0] = -1
        nodes[node, 3] = nodes[node, 4] = -1
        splits[node] = 0.0
        # Points that are all at one place stay together.
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
