"""A decoder of the vertex codec in Python, for tests; ``sequences/wire/codec.py`` describes it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences.wire.codec import (
    GROUP,
    HEADER,
    PLAIN,
    TAIL_MIN,
    ZERO,
    Bytes,
    block_size,
)
from pointbrush.sequences.wire.vertices import DROPPED_SHIFT, MOST_DROPPED, PACKED, RELATIVE

_BITS = ((0, 1, 2, 4), (1, 2, 4, 8))
"""Bits a value of a group, by control, for each of its two header bits' values."""
_CODES = [(byte & 3, (byte >> 2) & 3, (byte >> 4) & 3, byte >> 6) for byte in range(256)]
_FLAGS = 10
"""Place of a vertex's flags."""


def decode_vertices(data: bytes | memoryview, count: int, stride: int = 12) -> Bytes:
    """Decode ``count`` vertices (count, stride) uint8."""
    stream = np.frombuffer(data, np.uint8)
    assert stream[0] == HEADER
    modes = stride // 4
    channels = stream[len(stream) - modes :] & 15
    body = stream[: len(stream) - max(stride + modes, TAIL_MIN)]
    values = _Walk(body).run(count, stride)
    first = stream[len(stream) - modes - stride : len(stream) - modes]
    return _integrate(values, np.repeat(channels == 1, 4), first)[:count]


def decode_points(data: bytes | memoryview, count: int) -> Bytes:
    """Vertices (count, 12) of a chunk with plain colours, as the page holds them."""
    vertices = decode_vertices(data, count)
    _plain_colors(vertices)
    return vertices


def dequantise(
    q: NDArray[np.uint16], origin: NDArray[np.float64], scale: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Positions (N, 3) as the page computes them, in float32."""
    grid = q.astype(np.float32) * scale.astype(np.float32)
    positions: NDArray[np.float32] = grid + origin.astype(np.float32)
    return positions


def _plain_colors(vertices: Bytes) -> None:
    """Replace the colours of decoded vertices (N, 12) by plain ones in place, as the page does."""
    related = (vertices[:, _FLAGS] & RELATIVE).astype(np.bool_)
    vertices[related, 6] += vertices[related, 7]
    vertices[related, 8] += vertices[related, 7]
    kind = vertices[:, _FLAGS] >> DROPPED_SHIFT
    for dropped in range(1, MOST_DROPPED + 1):
        values = vertices[kind == dropped, 6:9]
        vertices[kind == dropped, 6:9] = (values << dropped) | (values >> (8 - 2 * dropped))
    rows = kind == PACKED
    low, high = vertices[rows, 6], vertices[rows, 7]
    red, green, blue = low & 31, (low >> 5) | ((high & 7) << 3), high >> 3
    vertices[rows, 6] = (red << 3) | (red >> 2)
    vertices[rows, 7] = (green << 2) | (green >> 4)
    vertices[rows, 8] = (blue << 3) | (blue >> 2)
    vertices[:, _FLAGS] = 0


class _Walk:
    """Finds the groups of a stream by reading it from the start; the lengths depend on the data."""

    def __init__(self, body: Bytes) -> None:
        self._body = body
        self._raw = body.tobytes()
        self._at = 1
        self._lengths = {0: bytes(len(body)), 8: bytes([GROUP]) * len(body)}
        for bits in (1, 2, 4):
            self._lengths[bits] = _group_lengths(body, bits)
        self._found: dict[int, list[tuple[int, int]]] = {bits: [] for bits in self._lengths}

    def run(self, count: int, stride: int) -> Bytes:
        """Differences (stride, N), N being ``count`` in whole groups."""
        size = block_size(stride)
        groups = -(-count // GROUP)
        for first in range(0, count, size):
            points = min(size, count - first)
            for lane, control in enumerate(self._control(stride)):
                self._lane(control, points, lane * groups + first // GROUP)
        assert self._at == len(self._raw)
        return self._gather(stride * groups).reshape(stride, groups * GROUP)

    def _control(self, stride: int) -> list[int]:
        controls = [code for byte in self._take(stride // 4) for code in _CODES[byte]]
        return controls[:stride]

    def _take(self, length: int) -> bytes:
        taken = self._raw[self._at : self._at + length]
        assert len(taken) == length
        self._at += length
        return taken

    def _lane(self, control: int, points: int, place: int) -> None:
        """One byte of a block's vertices; its groups are numbered from ``place``."""
        if control == ZERO:
            return
        count = -(-points // GROUP)
        if control == PLAIN:
            found = ((place + group, self._at + group * GROUP) for group in range(count))
            self._found[8].extend(found)
            self._take(points)
            return
        choice = _BITS[control]
        codes = [code for byte in self._take(-(-count // 4)) for code in _CODES[byte]]
        for group in range(count):
            bits = choice[codes[group]]
            if bits:
                self._found[bits].append((place + group, self._at))
                self._at += self._lengths[bits][self._at]

    def _gather(self, groups: int) -> Bytes:
        values = np.zeros((groups, GROUP), np.uint8)
        padded = np.concatenate([self._body, np.zeros(2 * GROUP, np.uint8)])
        for bits, found in self._found.items():
            if found:
                place, at = np.array(found, np.int64).T
                values[place] = _unpack(padded, at, bits)
        return values


def _group_lengths(data: Bytes, bits: int) -> bytes:
    """For each offset, the length of a group packed with ``bits`` that would start there."""
    fixed = GROUP * bits // 8
    sentinel = (1 << bits) - 1
    escapes = np.zeros(len(data), np.uint8)
    for shift in range(0, 8, bits):
        escapes += ((data >> shift) & sentinel) == sentinel
    total = np.concatenate([[0], np.cumsum(escapes, dtype=np.int64)])
    ends = np.minimum(np.arange(len(data)) + fixed, len(data))
    lengths: Bytes = (fixed + total[ends] - total[:-1]).astype(np.uint8)
    return lengths.tobytes()


def _unpack(data: Bytes, offsets: NDArray[np.int64], bits: int) -> Bytes:
    """Groups (n, 16) packed with ``bits`` a value at these offsets."""
    fixed = GROUP * bits // 8
    packed: Bytes = data[offsets[:, None] + np.arange(fixed)]
    if bits == 8:
        return packed
    sentinel = (1 << bits) - 1
    shifts = np.arange(0, 8, bits, dtype=np.uint8)
    if bits > 1:  # single bits lie lowest first, wider ones highest first
        shifts = shifts[::-1].copy()
    values: Bytes = np.asarray((packed[..., None] >> shifts) & sentinel, np.uint8).reshape(
        -1, GROUP
    )
    escaped = values == sentinel
    rank = np.cumsum(escaped, axis=1) - 1
    at = (offsets[:, None] + fixed + rank)[escaped]
    values[escaped] = data[at]
    return values


def _integrate(zigzag: Bytes, words: NDArray[np.bool_], first: Bytes) -> Bytes:
    """Undo the zigzag and the differences of (stride, N): vertices (N, stride).

    ``words`` (stride,) marks the bytes that are halves of 16-bit values.
    """
    steps = (zigzag >> 1) ^ (0 - (zigzag & 1)).astype(np.uint8)
    vertices: Bytes = np.cumsum(steps, axis=1, dtype=np.uint8) + first[:, None]
    for lane in np.flatnonzero(words)[::2]:
        wide = zigzag[lane].astype(np.uint16) | (zigzag[lane + 1].astype(np.uint16) << 8)
        wide = (wide >> 1) ^ (0 - (wide & 1)).astype(np.uint16)
        start = np.uint16(int(first[lane]) | int(first[lane + 1]) << 8)
        values = np.cumsum(wide, dtype=np.uint16) + start
        vertices[lane], vertices[lane + 1] = values & 0xFF, values >> 8
    return np.ascontiguousarray(vertices.T)
