"""Packed coordinates of an octree's points, as a frame keeps them.

The points of a block lie close together: each axis is kept as differences to its least value, in
as many bits as the greatest one takes.  Values are whole numbers where these give the source's
floats bit for bit: as ``whole × scale + offset`` of a LAS file, or as decimals of a text.
Elsewhere they are the floats' bit patterns in the order of the floats.  A block begins with a word
of 64 bits; its points follow one another, x, y, z, lowest bits first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

WIDTH = 127
"""Part of a block's byte for an axis that counts the bits of a value."""
FLOATS = 128
"""The rest of it: values are bit patterns of floats, not whole numbers."""
PACKED = ("coordinates", "block_base", "block_bits")
"""Names of the arrays of a frame that are a ``Packed``."""


@dataclass(frozen=True, slots=True, eq=False)
class Packed:
    """Coordinates of blocks: ``words`` (W,), and ``base`` and ``bits`` (B, 3) of each block."""

    words: NDArray[np.uint64]
    base: NDArray[np.int64]
    bits: NDArray[np.uint8]
