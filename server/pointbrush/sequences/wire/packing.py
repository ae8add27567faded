"""Compiled loops of the vertex codec (``codec``): laying vertices out, and packing them.

They take long to load; therefore modules import them on first use.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost
from pointbrush.sequences.wire.codec import GROUP, PLAIN, ZERO, Bytes

_ONES = np.uint64(0x0101010101010101)
_LOW_BITS = np.uint64(0x7F7F7F7F7F7F7F7F)
"""Eight bytes of 1, and of 127."""
_CHANGE_BITS = np.log2(1.0 + np.abs(np.arange(256, dtype=np.uint8).view(np.int8).astype(float)))
"""Bits of a change of a byte, modulo 256."""


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
    """Write zigzag differences of consecutive vertices of a block, zeros after the last."""
    for lane in range(len(lanes)):
        for place in range(points, -(-points // GROUP) * GROUP):
            values[lane, place] = 0
    first = 0 if start else 1  # the first vertex has no predecessor
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
    """Count the bytes of eight that are at least ``least``, which is at most 128."""
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
        # The format allows groups of more than 16 bytes in the first choice; they never save any.
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
            at = _copy_group(values[group], min(GROUP, points - group * GROUP), out, at)
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
            at = _copy_group(values[group], GROUP, out, at)
    return at


@innermost
def _copy_group(values: Bytes, count: int, out: Bytes, at: int) -> int:
    """Write ``count`` bytes of a group (16,) at ``at``; returns where it ends."""
    for place in range(count):
        out[at + place] = values[place]
    return at + count


@innermost
def _write_group(values: Bytes, bits: int, out: Bytes, at: int) -> int:
    """Write a group (16,) at ``at`` with ``bits`` a value, and greater values as whole bytes.

    Returns its end; the byte after the end may have been overwritten.
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
        # Branchless: the branch would be predicted badly.
        out[at] = values[place]
        at += values[place] >= most
    return at
