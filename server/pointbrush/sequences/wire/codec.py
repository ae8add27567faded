"""The meshoptimizer vertex codec, version 1 of its bitstream, encoded by compiled loops.

The format is that of ``meshopt_encodeVertexBuffer`` (zeux/meshoptimizer, ``src/vertexcodec.cpp``;
specified in glTF's KHR_meshopt_compression), which the page decodes with the project's own
WebAssembly.  A stream is a header byte 0xA1, blocks of at most 256 vertices, and a tail with the
first vertex and a mode for each four bytes of a vertex: whether they are four bytes or two words.

A block holds, for each byte of the vertex, the zigzag differences to the vertex before in groups
of 16.  Two control bits in front of the block state how each byte's groups are packed: the block is
all zero, it is plain, or two bits for each group choose between no bits, 1, 2 and 4 bits a value
(first choice of widths) or 1, 2, 4 and 8 (second).  The greatest value of 1, 2 or 4 bits announces
a whole byte behind the group.
"""

from __future__ import annotations

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

Bytes = NDArray[np.uint8]


def block_size(stride: int) -> int:
    """Most vertices in a block."""
    return min(_MAX_BLOCK, (_BLOCK_BYTES // stride) & ~(GROUP - 1))


def check_stride(stride: int) -> None:
    """Raise BadInputError for a vertex size that the codec does not have."""
    if not 4 <= stride <= 256 or stride % 4:
        raise BadInputError(f"stride: expected a multiple of 4 from 4 to 256, got {stride}")
