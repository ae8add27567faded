"""The meshoptimizer vertex codec, version 0 of its bitstream, encoded and decoded with numpy.

The format is that of ``meshopt_encodeVertexBuffer`` (zeux/meshoptimizer, ``src/vertexcodec.cpp``;
specified in glTF's EXT_meshopt_compression), which the page decodes with the project's own
WebAssembly.  A stream is a header byte 0xA0, blocks of at most 256 vertices, and a tail with the
first vertex.  A block holds, for each byte of the vertex, the zigzag differences to the vertex
before in groups of 16; two bits in front of the groups tell how each group is packed: all zero,
2 bits a value, 4 bits a value (the greatest value of those announces a whole byte behind the
group), or 16 plain bytes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError

HEADER = 0xA0
GROUP = 16
_BLOCK_BYTES = 8192
_MAX_BLOCK = 256
_TAIL_MIN = 32

Bytes = NDArray[np.uint8]


def _block_size(stride: int) -> int:
    return min(_MAX_BLOCK, (_BLOCK_BYTES // stride) & ~(GROUP - 1))


def _check_stride(stride: int) -> None:
    if not 4 <= stride <= 256 or stride % 4:
        raise BadInputError(f"stride: expected a multiple of 4 from 4 to 256, got {stride}")


def _count_ones(flags: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Number of true values in each row of 16."""
    # Eight flags lie in one word; a multiplication adds its bytes into the top one.
    words = flags.view(np.uint64)
    total = (words[..., 0] + words[..., 1]) * np.uint64(0x0101010101010101)
    return (total >> np.uint64(56)).astype(np.int64)


def _differences(vertices: Bytes) -> Bytes:
    """Zigzag differences (groups, stride, 16) of the bytes of (N, stride), zero-padded."""
    n, stride = vertices.shape
    groups = -(-n // GROUP)
    columns = np.zeros((stride, groups * GROUP), np.uint8)
    np.subtract(vertices[1:].T, vertices[:-1].T, out=columns[:, 1:n])
    columns = (columns << 1) ^ (columns.view(np.int8) >> 7).view(np.uint8)
    return np.ascontiguousarray(columns.reshape(stride, groups, GROUP).transpose(1, 0, 2))


def _pack(values: Bytes, bits: int, slots: Bytes) -> None:
    """Write groups (n, 16) packed with ``bits`` a value into their slots (n, 16)."""
    sentinel = (1 << bits) - 1
    per_byte = 8 // bits
    low = np.minimum(values, sentinel).reshape(len(values), GROUP // per_byte, per_byte)
    packed = low[..., 0]
    for column in range(1, per_byte):
        packed = (packed << bits) | low[..., column]
    fixed = packed.shape[1]
    slots[:, :fixed] = packed
    row, column_of = np.nonzero(values >= sentinel)
    # Position of each escaped value among those of its group.
    start = np.searchsorted(row, np.arange(len(values)))
    slots[row, fixed + np.arange(len(row)) - start[row]] = values[row, column_of]


def encode_vertices(vertices: Bytes) -> bytes:
    """Encode (N, stride) uint8 vertices; ``stride`` is a multiple of 4.

    Raises BadInputError for another shape or type.
    """
    if vertices.ndim != 2 or vertices.dtype != np.uint8:
        raise BadInputError(
            f"vertices: expected (N, stride) uint8, got {vertices.shape} {vertices.dtype}"
        )
    n, stride = vertices.shape
    _check_stride(stride)
    tail = np.zeros(max(stride, _TAIL_MIN), np.uint8)
    if n == 0:
        return bytes([HEADER]) + tail.tobytes()
    tail[-stride:] = vertices[0]
    body = _encode_groups(_differences(vertices), _block_size(stride) // GROUP)
    return bytes([HEADER]) + body.tobytes() + tail.tobytes()


def _encode_groups(values: Bytes, per_block: int) -> Bytes:
    """Encode groups (G, stride, 16) of differences, ``per_block`` groups to a block."""
    words = values.view(np.uint64)
    # Sizes with 2 bits, 4 bits and 8 bits a value; a packing that exceeds 16 bytes never wins.
    size2 = GROUP // 4 + _count_ones(values >= 3)
    size4 = GROUP // 2 + _count_ones(values >= 15)
    mode = np.where(size2 <= size4, 1, 2)
    size = np.minimum(size2, size4)
    mode[size >= GROUP] = 3
    size[size >= GROUP] = GROUP
    empty = (words[..., 0] | words[..., 1]) == 0
    mode[empty] = 0
    size[empty] = 0

    slots = values.copy()
    for which, bits in ((1, 2), (2, 4)):
        chosen = np.nonzero(mode == which)
        packed = np.empty((len(chosen[0]), GROUP), np.uint8)
        _pack(values[chosen], bits, packed)
        slots[chosen] = packed
    return _assemble(slots, mode.astype(np.uint8), size, per_block)


def _assemble(slots: Bytes, mode: Bytes, size: NDArray[np.int64], per_block: int) -> Bytes:
    """Headers and used slot bytes, block by block, channel by channel."""
    groups, stride, _ = slots.shape
    blocks = -(-groups // per_block)
    spare = blocks * per_block - groups

    def by_channel(array: NDArray[Any]) -> NDArray[Any]:
        if spare:
            array = np.concatenate([array, np.zeros((spare, *array.shape[1:]), array.dtype)])
        array = array.reshape(blocks, per_block, *array.shape[1:])
        return np.swapaxes(array, 1, 2)

    width = -(-per_block // 4)
    modes = np.zeros((blocks, stride, 4 * width), np.uint8)
    modes[..., :per_block] = by_channel(mode)
    modes = modes.reshape(blocks, stride, width, 4)
    header = modes[..., 0] | (modes[..., 1] << 2) | (modes[..., 2] << 4) | (modes[..., 3] << 6)
    out = np.empty((blocks, stride, width + per_block * GROUP), np.uint8)
    used = np.empty(out.shape, np.bool_)
    out[..., :width] = header
    used[..., :width] = True
    if spare:  # the last block is shorter: its headers too
        used[-1, :, -(-(per_block - spare) // 4) : width] = False
    out[..., width:] = by_channel(slots).reshape(blocks, stride, -1)
    used[..., width:] = (np.arange(GROUP) < by_channel(size)[..., None]).reshape(blocks, stride, -1)
    return out[used]


def _mode_table() -> list[tuple[int, int, int, int]]:
    return [(b & 3, (b >> 2) & 3, (b >> 4) & 3, b >> 6) for b in range(256)]


_MODES = _mode_table()


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


def _walk(data: Bytes, groups: int, stride: int, per_block: int) -> tuple[list[int], list[int]]:
    """Offset and mode of every group, in stream order.  The only part that is sequential."""
    raw = data.tobytes()
    lengths = (bytes(len(raw)), _group_lengths(data, 2), _group_lengths(data, 4))
    at, offsets, modes = 1, [], []
    for first in range(0, groups, per_block):
        count = min(per_block, groups - first)
        width = -(-count // 4)
        for _ in range(stride):
            header = raw[at : at + width]
            at += width
            chosen = [mode for byte in header for mode in _MODES[byte]][:count]
            if len(chosen) < count or at > len(raw):
                raise BadInputError("vertex stream: expected more bytes, got its end")
            for mode in chosen:
                offsets.append(at)
                modes.append(mode)
                if mode == 3:
                    at += GROUP
                elif mode:
                    if at >= len(raw):
                        raise BadInputError("vertex stream: expected more bytes, got its end")
                    at += lengths[mode][at]
    if at != len(raw):
        raise BadInputError(f"vertex stream: expected {at} bytes before the tail, got {len(raw)}")
    return offsets, modes


def _unpack(data: Bytes, offsets: NDArray[np.int64], bits: int) -> Bytes:
    """Groups (n, 16) packed with ``bits`` a value at these offsets."""
    fixed = GROUP * bits // 8
    sentinel = (1 << bits) - 1
    packed = data[offsets[:, None] + np.arange(fixed)]
    shifts = np.arange(8 - bits, -1, -bits, dtype=np.uint8)
    values: Bytes = ((packed[..., None] >> shifts) & sentinel).reshape(len(offsets), GROUP)
    escaped = values == sentinel
    rank = np.cumsum(escaped, axis=1) - 1
    at = (offsets[:, None] + fixed + rank)[escaped]
    values[escaped] = data[at]
    return values


def decode_vertices(data: bytes | memoryview, count: int, stride: int = 12) -> Bytes:
    """Decode ``count`` vertices (count, stride) uint8.

    Raises BadInputError when the stream is not a version 0 vertex stream of that many vertices.
    """
    _check_stride(stride)
    stream = np.frombuffer(data, np.uint8)
    tail = max(stride, _TAIL_MIN)
    if len(stream) < 1 + tail or stream[0] != HEADER:
        raise BadInputError("vertex stream: expected header 0xa0 and a tail, got something else")
    groups = -(-count // GROUP)
    per_block = _block_size(stride) // GROUP
    body = stream[: len(stream) - tail]
    offsets, modes = _walk(body, groups, stride, per_block)
    at, mode = np.array(offsets, np.int64), np.array(modes, np.uint8)
    values = np.zeros((len(at), GROUP), np.uint8)
    # A malformed stream may point past its end: zeros there, the walk has checked the total.
    padded = np.concatenate([body, np.zeros(2 * GROUP, np.uint8)])
    for which, bits in ((1, 2), (2, 4)):
        values[mode == which] = _unpack(padded, at[mode == which], bits)
    values[mode == 3] = padded[at[mode == 3][:, None] + np.arange(GROUP)]
    return _integrate(values, groups, stride, per_block, stream[-stride:])[:count]


def _integrate(values: Bytes, groups: int, stride: int, per_block: int, first: Bytes) -> Bytes:
    """Undo the order of the stream, the zigzag and the differences: vertices (16 G, stride)."""
    columns = np.empty((stride, groups, GROUP), np.uint8)
    full = groups // per_block
    cut = full * per_block
    head = values[: cut * stride].reshape(full, stride, per_block, GROUP)
    columns[:, :cut] = head.transpose(1, 0, 2, 3).reshape(stride, cut, GROUP)
    columns[:, cut:] = values[cut * stride :].reshape(stride, groups - cut, GROUP)
    zigzag: Bytes = columns.reshape(stride, -1)
    steps = (zigzag >> 1) ^ (0 - (zigzag & 1)).astype(np.uint8)
    vertices: Bytes = np.cumsum(steps, axis=1, dtype=np.uint8) + first[:, None]
    return np.ascontiguousarray(vertices.T)
