"""A point on the wire: 12 bytes before they are encoded.

x, y, z uint16; r, g, b, intensity uint8; flags; a free byte.  The flags are the same in all points
of a chunk.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences.octree.quantise import Quantised
from pointbrush.sequences.wire.codec import Bytes
from pointbrush.sequences.wire.encoder import encode_vertices

RELATIVE = 1
"""Flag: r and b are differences to g, modulo 256."""
DROPPED_SHIFT, MOST_DROPPED = 1, 2
"""Places of the flags that count the low bits lost by r, g and b, and the most they lose."""
PACKED = 3
"""Value of these flags for r, g and b in two bytes, 5, 6 and 5 bits from the lowest on."""

_FLAGS = 10
_WORDS = 1
"""Four bytes of x and y are encoded as words; z shares its four with colours."""
_SAMPLE, _RUN = 32, 64
"""Runs, and points of each run, that represent a larger chunk."""


def encode(
    quantised: Quantised,
    colors: Bytes,
    order: NDArray[np.int64] | None = None,
    *,
    related: bool,
    dropped: int = 0,
) -> bytes:
    """Points with colours (N, 4) in an order (N,), None: as they are, as a stream of the codec.

    ``dropped``: low bits that the colours lose, or PACKED; ``related``: send r and b relative to g.
    """
    from pointbrush.sequences.wire.packing import lay_out

    flags = dropped << DROPPED_SHIFT
    q = quantised.q if order is None else quantised.q.take(order, axis=0)
    colors = colors if order is None else colors.take(order, axis=0)
    # Black means no colour: a nearly black colour must not become black.
    if dropped == PACKED:
        colors = np.column_stack((_packed(colors), np.zeros_like(colors[:, :1]), colors[:, 3:]))
    elif dropped:
        less = np.maximum(colors[:, :3] >> dropped, colors[:, :3] > 0)
        colors = np.column_stack((less, colors[:, 3:]))
    related = related and dropped != PACKED
    lanes = lay_out(q, colors, flags | RELATIVE if related else flags, related)
    return encode_vertices(lanes.T, _WORDS)


def _packed(colors: Bytes) -> Bytes:
    red, green, blue = colors[:, :3].T.astype(np.uint16)
    packed = (red >> 3) | (green >> 2 << 5) | (blue >> 3 << 11)
    packed[(packed == 0) & colors[:, :3].any(axis=1)] = 1 << 5
    halves: Bytes = packed.astype("<u2").view(np.uint8).reshape(-1, 2)
    return halves


def are_related(colors: Bytes) -> bool:
    """Whether r and b of colours (N, 4) change less from point to point relative to g.

    Compares the bits of each change along runs spread over the chunk.
    """
    if len(colors) == 0:
        return False
    from pointbrush.sequences.wire.packing import change_bits

    alone, relative = change_bits(colors, runs_of(len(colors)))
    return bool(relative < alone)


def runs_of(count: int) -> NDArray[np.int64]:
    """Return the numbers (runs, points) of runs of points spread over a chunk of ``count``."""
    starts = np.arange(_SAMPLE) * max(count - _RUN, 0) // _SAMPLE
    numbers: NDArray[np.int64] = np.minimum(starts[:, None] + np.arange(_RUN), count - 1)
    return numbers
