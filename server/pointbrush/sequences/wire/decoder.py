"""Decoding the vertex codec in Python: for scripts and checks; the page has its own decoder.

Both versions of the bitstream are read (``codec`` describes it); version 0, which older imports
hold, has no control bits and no words: each group is nothing, 2, 4 or 8 bits a value.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.sequences.wire.codec import (
    GROUP,
    PLAIN,
    TAIL_MIN,
    ZERO,
    Bytes,
    block_size,
    check_stride,
)
from pointbrush.sequences.wire.vertices import plain_colors

_HEADER = {0xA0: 0, 0xA1: 1}
_TAIL_MIN = (32, TAIL_MIN)
_BITS = {(0, 0): (0, 2, 4, 8), (1, 0): (0, 1, 2, 4), (1, 1): (1, 2, 4, 8)}
"""Bits a value of a group, by version and control, for each of its two header bits' values."""
_CODES = [(byte & 3, (byte >> 2) & 3, (byte >> 4) & 3, byte >> 6) for byte in range(256)]
_END = "vertex stream: expected more bytes, got its end"


def decode_vertices(data: bytes | memoryview, count: int, stride: int = 12) -> Bytes:
    """Decode ``count`` vertices (count, stride) uint8.

    Raises BadInputError when the stream is not a vertex stream of that many vertices.
    """
    check_stride(stride)
    stream = np.frombuffer(data, np.uint8)
    version = _HEADER.get(int(stream[0])) if len(stream) else None
    if version is None:
        raise BadInputError("vertex stream: expected header 0xa0 or 0xa1, got something else")
    modes = stride // 4 if version else 0
    tail = max(stride + modes, _TAIL_MIN[version])
    if len(stream) < 1 + tail:
        raise BadInputError(_END)
    channels = stream[len(stream) - modes :] & 15
    if (channels > 1).any():
        raise BadInputError("vertex stream: expected differences of bytes or words, got XOR")
    body = stream[: len(stream) - tail]
    values = _Walk(body, version).run(count, stride)
    first = stream[len(stream) - modes - stride : len(stream) - modes]
    words = np.repeat(channels == 1, 4) if modes else np.zeros(stride, np.bool_)
    return _integrate(values, words, first)[:count]


def decode_points(data: bytes | memoryview, count: int) -> Bytes:
    """Vertices (count, 12) of a chunk (``vertices.py``) with plain colours, as the page holds them.

    Raises BadInputError as ``decode_vertices``.
    """
    vertices = decode_vertices(data, count)
    plain_colors(vertices)
    return vertices


class _Walk:
    """Finds the groups of a stream by reading it from the start; the lengths depend on the data."""

    def __init__(self, body: Bytes, version: int) -> None:
        self._body, self._version = body, version
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
        if self._at != len(self._raw):
            raise BadInputError(
                f"vertex stream: expected {self._at} bytes before the tail, got {len(self._raw)}"
            )
        return self._gather(stride * groups).reshape(stride, groups * GROUP)

    def _control(self, stride: int) -> list[int]:
        if self._version == 0:
            return [0] * stride
        controls = [code for byte in self._take(stride // 4) for code in _CODES[byte]]
        return controls[:stride]

    def _take(self, length: int) -> bytes:
        taken = self._raw[self._at : self._at + length]
        if len(taken) < length:
            raise BadInputError(_END)
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
        choice = _BITS[self._version, control]
        codes = [code for byte in self._take(-(-count // 4)) for code in _CODES[byte]]
        for group in range(count):
            bits = choice[codes[group]]
            if bits:
                if self._at >= len(self._raw):
                    raise BadInputError(_END)
                self._found[bits].append((place + group, self._at))
                self._at += self._lengths[bits][self._at]

    def _gather(self, groups: int) -> Bytes:
        values = np.zeros((groups, GROUP), np.uint8)
        # A malformed stream may point past its end: zeros there, the walk has checked the total.
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
