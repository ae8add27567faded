"""The meshoptimizer vertex codec, version 1 of its bitstream, encoded with numpy.

The format is that of ``meshopt_encodeVertexBuffer`` (zeux/meshoptimizer, ``src/vertexcodec.cpp``;
specified in glTF's KHR_meshopt_compression), which the page decodes with the project's own
WebAssembly.  A stream is a header byte 0xA1, blocks of at most 256 vertices, and a tail with the
first vertex and a mode for each four bytes of a vertex: whether they are four bytes or two words.

A block holds, for each byte of the vertex, the zigzag differences to the vertex before in groups
of 16.  Two control bits in front of the block tell how each byte's groups are packed: the block is
all zero, it is plain, or two bits for each group choose between no bits, 1, 2 and 4 bits a value
(first choice of widths) or 1, 2, 4 and 8 (second).  The greatest value of 1, 2 or 4 bits announces
a whole byte behind the group.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError

HEADER = 0xA1
GROUP = 16
TAIL_MIN = 24
ZERO, PLAIN = 2, 3
"""Control values of a block's byte without groups; 0 and 1 choose the groups' widths."""

_BLOCK_BYTES = 8192
_MAX_BLOCK = 256
_NEVER = 1 << 14
_ROW = np.dtype((np.void, GROUP))
"""A group as one element: rows of bytes are moved one by one otherwise."""

Bytes = NDArray[np.uint8]


def block_size(stride: int) -> int:
    """Most vertices in a block."""
    return min(_MAX_BLOCK, (_BLOCK_BYTES // stride) & ~(GROUP - 1))


def check_stride(stride: int) -> None:
    """Raise BadInputError for a vertex size that the codec does not have."""
    if not 4 <= stride <= 256 or stride % 4:
        raise BadInputError(f"stride: expected a multiple of 4 from 4 to 256, got {stride}")


def encode_vertices(vertices: Bytes, words: int = 0) -> bytes:
    """Encode (N, stride) uint8 vertices; ``stride`` is a multiple of 4.

    The first ``words`` times four bytes are little-endian 16-bit values, whose differences are
    taken whole.  Raises BadInputError for another shape or type.
    """
    if vertices.ndim != 2 or vertices.dtype != np.uint8:
        raise BadInputError(
            f"vertices: expected (N, stride) uint8, got {vertices.shape} {vertices.dtype}"
        )
    n, stride = vertices.shape
    check_stride(stride)
    channels = stride // 4
    tail = np.zeros(max(stride + channels, TAIL_MIN), np.uint8)
    tail[len(tail) - channels :][:words] = 1
    if n == 0:
        return bytes([HEADER]) + tail.tobytes()
    tail[-stride - channels : -channels] = vertices[0]
    blocks = _Blocks.of(_differences(vertices, 4 * words), n)
    return bytes([HEADER]) + _assemble(blocks, n).tobytes() + tail.tobytes()


def _differences(vertices: Bytes, words: int) -> Bytes:
    """Zigzag differences (blocks, stride, groups, 16) of (N, stride), zero-padded.

    The first ``words`` bytes of a vertex are 16-bit values.
    """
    n, stride = vertices.shape
    size = block_size(stride)
    groups = min(size, -(-n // GROUP) * GROUP) // GROUP
    blocks = -(-n // size)
    columns = np.zeros((stride, blocks * groups * GROUP), np.uint8)
    if words:
        values = np.ascontiguousarray(vertices[:, :words]).view("<u2").T
        step = values[:, 1:] - values[:, :-1]
        step = (step << 1) ^ (step.view(np.int16) >> 15).view(np.uint16)
        columns[0:words:2, 1:n] = step  # the low byte
        columns[1:words:2, 1:n] = step >> 8
    part = columns[words:]
    np.subtract(vertices[1:, words:].T, vertices[:-1, words:].T, out=part[:, 1:n])
    part[:] = (part << 1) ^ (part.view(np.int8) >> 7).view(np.uint8)
    return np.ascontiguousarray(columns.reshape(stride, blocks, groups, GROUP).swapaxes(0, 1))


def _count_ones(flags: NDArray[np.bool_]) -> Bytes:
    """Number of true values in each row of 16."""
    # Eight flags lie in one word; a multiplication adds its bytes into the top one.
    words = flags.view(np.uint64)
    total = (words[..., 0] + words[..., 1]) * np.uint64(0x0101010101010101)
    return (total >> np.uint64(56)).astype(np.uint8)


@dataclass(frozen=True, slots=True, eq=False)
class _Blocks:
    """Differences (B, stride, G, 16) and how they are packed.

    ``control`` (B, stride); ``code`` (B, stride, G) is each group's two bits, ``size`` (B, stride,
    G) its packed bytes.
    """

    values: Bytes
    control: Bytes
    code: Bytes
    size: Bytes

    @classmethod
    def of(cls, values: Bytes, count: int) -> _Blocks:
        """Choose the smallest packing for the differences of ``count`` vertices."""
        escapes = [_count_ones(values >= least) for least in (1, 3, 15)]
        size = escapes[0] + np.uint8(2)
        code = np.zeros_like(size)
        for number, fixed in ((1, 4), (2, 8)):
            other = escapes[number] + np.uint8(fixed)
            better = other < size
            code[better] = number
            np.minimum(size, other, out=size)
        empty = escapes[0] == 0
        control = _choose_control(size, empty, count)

        first = (control == 0)[..., None]
        second = (control == 1)[..., None]
        long = second & (size >= GROUP)
        code += first & ~empty  # the first choice begins with no bits at all
        code[long] = 3
        size[(first & empty) | (control == ZERO)[..., None]] = 0
        size[long | (control == PLAIN)[..., None]] = GROUP
        return cls(values, control, code, size)


def _choose_control(size: Bytes, empty: NDArray[np.bool_], count: int) -> Bytes:
    """Control (B, stride) of least bytes, given the groups' sizes (B, stride, G) when packed."""
    blocks, _, groups = size.shape
    points = np.full((blocks, 1), groups * GROUP)
    points[-1] = count - (blocks - 1) * groups * GROUP
    present = np.arange(groups) * GROUP < points[..., None]
    packed = present & ~empty
    header = -(-points // (4 * GROUP))
    first = np.where(packed, size, 0).sum(axis=2) + header
    # A group of more than 16 bytes would be legal in the first choice, but never pays.
    first[(packed & (size > GROUP)).any(axis=2)] = _NEVER
    second = np.where(present, np.minimum(size, GROUP), 0).sum(axis=2) + header
    control: Bytes = (second < first).astype(np.uint8)
    control[np.minimum(first, second) >= points] = PLAIN
    control[~packed.any(axis=2)] = ZERO
    return control


def _pack(values: Bytes, bits: int) -> Bytes:
    """Slots (n, 16) with groups (n, 16) packed with ``bits`` a value."""
    sentinel = (1 << bits) - 1
    fixed = GROUP * bits // 8
    slots = np.empty_like(values)
    low = np.minimum(values, sentinel)
    if bits == 1:
        slots[:, :fixed] = np.packbits(low, axis=1, bitorder="little")
    else:
        per_byte = 8 // bits
        low = low.reshape(len(values), fixed, per_byte)
        packed = low[..., 0]
        for column in range(1, per_byte):
            packed = (packed << bits) | low[..., column]
        slots[:, :fixed] = packed
    escaped = values >= sentinel
    room = np.arange(GROUP - fixed) < _count_ones(escaped)[:, None]
    slots[:, fixed:][room] = values[escaped]  # both run group by group
    return slots


def _assemble(blocks: _Blocks, count: int) -> Bytes:
    """The body of the stream: control bits, then headers and groups byte by byte."""
    slots = blocks.values.copy()
    rows = slots.reshape(-1, GROUP).view(_ROW)[:, 0]
    grouped = (blocks.control < ZERO)[..., None] & (blocks.size > 0)
    width = (blocks.code + (blocks.control == 1)[..., None]) * grouped  # 1, 2, 4 bits: 1, 2, 3
    for number, bits in ((1, 1), (2, 2), (3, 4)):
        chosen = np.flatnonzero(width == number)
        values = rows.take(chosen).view(np.uint8).reshape(-1, GROUP)
        rows[chosen] = _pack(values, bits).view(_ROW)[:, 0]

    total, stride, groups, _ = slots.shape
    head, body = stride // 4, -(-groups // 4)
    last = count - (total - 1) * groups * GROUP
    out = np.empty((total, head + stride * (body + groups * GROUP)), np.uint8)
    used = np.ones(out.shape, np.bool_)
    out[:, :head] = _two_bits(blocks.control)
    lanes = out[:, head:].reshape(total, stride, -1)
    keep = used[:, head:].reshape(total, stride, -1)
    lanes[..., :body] = _two_bits(blocks.code)
    lanes[..., body:] = slots.reshape(total, stride, -1)
    keep[..., :body] = (blocks.control < ZERO)[..., None]
    keep[-1, :, -(-last // (4 * GROUP)) : body] = False
    packed = keep[..., body:].reshape(total, stride, groups, GROUP)
    packed[:] = np.arange(GROUP) < blocks.size[..., None]
    packed[-1, :, -(-last // GROUP) :] = False
    plain = packed[-1].reshape(stride, -1)  # a plain block ends with its last vertex
    plain[blocks.control[-1] == PLAIN, last:] = False
    return out[used]


def _two_bits(values: Bytes) -> Bytes:
    """Values 0..3 (…, n) four to a byte, the first lowest."""
    spare = -values.shape[-1] % 4
    if spare:
        padding = np.zeros((*values.shape[:-1], spare), np.uint8)
        values = np.concatenate([values, padding], axis=-1)
    four: Bytes = values.reshape(*values.shape[:-1], -1, 4)
    shifts = np.array([0, 2, 4, 6], np.uint8)
    packed: Bytes = np.bitwise_or.reduce(four << shifts, axis=-1)
    return packed
