"""Encoder of vertices (``codec``), by compiled loops."""

from __future__ import annotations

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.sequences.wire.codec import GROUP, HEADER, TAIL_MIN, Bytes, block_size, check_stride


def encode_vertices(vertices: Bytes, words: int = 0) -> bytes:
    """Encode (N, stride) uint8 vertices; ``stride`` is a multiple of 4.

    The first ``words`` times four bytes are little-endian 16-bit values, differenced as 16-bit
    numbers.  Raises BadInputError for another shape or type.
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
    from pointbrush.sequences.wire.packing import (
        pack_blocks,  # compiled loops, which take long to load
    )

    size = block_size(stride)
    most = stride // 4 + stride * (size + size // (4 * GROUP) + 1)
    out = np.empty(-(-n // size) * most + 1, np.uint8)
    used = pack_blocks(np.ascontiguousarray(vertices.T), 4 * words, size, out)
    return bytes([HEADER]) + out[:used].tobytes() + tail.tobytes()
