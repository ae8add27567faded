"""Compiled loops of octrees: sort points into cubes, pack blocks of coordinates, unpack some.

They take long to load; therefore modules import them on first use.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost
from pointbrush.sequences.octree.packed import FLOATS, WIDTH

_MOST_WHOLE = 2.0**52

Words = NDArray[np.uint64]


@compiled
def local_bounds(
    source: NDArray[np.floating[Any]], shift: NDArray[np.float64]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the least and greatest local coordinates (3,) of ``source`` (N, 3), N > 0."""
    lo, hi = np.full(3, np.inf, np.float32), np.full(3, -np.inf, np.float32)
    for place in range(len(source)):
        for axis in range(3):
            value = np.float32(np.float64(source[place, axis]) - shift[axis])
            lo[axis], hi[axis] = min(lo[axis], value), max(hi[axis], value)
    return lo, hi


@compiled
def sort_into_cubes(
    source: NDArray[np.floating[Any]],
    shift: NDArray[np.float64],
    edge: float,
    low: NDArray[np.int64],
    size: NDArray[np.int64],
    order: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Fill in the ``order`` (N,) of points by cube; points of one cube keep their order.

    ``low`` is the first cube and ``size`` (3,) the cubes along each axis, fewer than 2**16 in all.
    Returns the start of each cube in ``order``, and the end.
    """
    cubes = np.empty(len(source), np.uint16)
    first = np.zeros(size[0] * size[1] * size[2] + 1, np.int64)
    for place in range(len(source)):
        cube = np.int64(0)
        for axis in range(3):
            value = np.float32(np.float64(source[place, axis]) - shift[axis])
            cube = cube * size[axis] + np.int64(np.floor(value / edge)) - low[axis]
        cubes[place] = cube
        first[cube + 1] += 1
    first = np.cumsum(first)
    free = first.copy()
    for place in range(len(source)):
        order[free[cubes[place]]] = place
        free[cubes[place]] += 1
    return first


@compiled
def pack(
    source: NDArray[np.floating[Any]],
    patterns: NDArray[np.signedinteger[Any]],
    scaling: NDArray[np.float64],
    first: NDArray[np.int64],
    base: NDArray[np.int64],
    bits: NDArray[np.uint8],
    words: Words,
) -> int:
    """Pack the blocks ``first[b]:first[b + 1]`` of ``source`` (N, 3) into zeroed ``words``.

    ``patterns`` are the same floats as integers, ``scaling`` (3, 3) by axis the scale, 0 for none,
    offset and divisor of their whole numbers.  Fills in ``base`` and ``bits`` (B, 3); returns the
    words used.
    """
    longest = 0
    for block in range(len(bits)):
        longest = max(longest, first[block + 1] - first[block])
    values = np.empty((3, longest), np.int64)
    back = np.empty(1, source.dtype)
    word = 0
    for block in range(len(bits)):
        start, stop = first[block], first[block + 1]
        for axis in range(3):
            own = values[axis]
            kind = 0
            floats, integers = source[start:stop, axis], patterns[start:stop, axis]
            if not _whole(floats, integers, scaling[:, axis], own, back):
                _ordinals(integers, own)
                kind = FLOATS
            base[block, axis], width = _span(own, stop - start)
            bits[block, axis] = kind + width
        at = word * 64
        for place in range(stop - start):
            for axis in range(3):
                width = bits[block, axis] & WIDTH
                if width > 0:
                    _put(words, at, width, np.uint64(values[axis, place] - base[block, axis]))
                at += width
        word = (at + 63) // 64
    return word


@innermost
def _whole(
    source: NDArray[np.floating[Any]],
    patterns: NDArray[np.signedinteger[Any]],
    scaling: NDArray[np.float64],
    values: NDArray[np.int64],
    back: NDArray[np.floating[Any]],
) -> bool:
    """Fill in the whole numbers of a block; return whether they restore its floats exactly.

    ``back`` (1,) has the floats' type.
    """
    scale, offset, divisor = scaling
    if scale == 0.0:
        return False
    inverse = divisor / scale
    for place in range(len(source)):
        value = source[place]
        whole = np.rint((value - offset) * inverse)
        if not abs(whole) <= _MOST_WHOLE:
            return False
        back[0] = whole * scale / divisor + offset
        if back[0] != value:
            return False
        if value == 0.0 and patterns[place] != 0:  # of the two zeros the negative one
            return False
        values[place] = np.int64(whole)
    return True


@innermost
def _ordinals(patterns: NDArray[np.signedinteger[Any]], values: NDArray[np.int64]) -> None:
    """Fill in the bit patterns of a block's floats as integers in the floats' order."""
    magnitude = np.int64(2 ** (8 * patterns.itemsize - 1) - 1)
    for place in range(len(patterns)):
        pattern = np.int64(patterns[place])
        values[place] = pattern ^ ((pattern >> 63) & magnitude)


@innermost
def _span(values: NDArray[np.int64], count: int) -> tuple[int, int]:
    """Least value, and the bits of the greatest difference to it."""
    least = most = values[0]
    for place in range(1, count):
        least = min(least, values[place])
        most = max(most, values[place])
    # Modulo 2**64, which the greatest difference fits.
    left, width = np.uint64(most - least), 0
    while left > np.uint64(0):
        left >>= np.uint64(1)
        width += 1
    return least, width


@innermost
def _put(words: Words, at: int, width: int, value: np.uint64) -> None:
    word, shift = at >> 6, at & 63
    words[word] |= value << np.uint64(shift)
    if shift + width > 64:
        words[word + 1] |= value >> np.uint64(64 - shift)


@innermost
def _get(words: Words, at: int, width: int) -> np.uint64:
    word, shift = at >> 6, at & 63
    value = words[word] >> np.uint64(shift)
    if shift + width > 64:
        value |= words[word + 1] << np.uint64(64 - shift)
    return np.uint64(value & (~np.uint64(0) >> np.uint64(64 - width)))


class Blocks(NamedTuple):
    """Packed blocks (B,): starts of their words and points; least values and bits (B, 3).

    ``word`` counts from the first of the given words; ``scaling`` (3, 3): see ``pack``.
    """

    word: NDArray[np.int64]
    first: NDArray[np.int64]
    base: NDArray[np.int64]
    bits: NDArray[np.uint8]
    scaling: NDArray[np.float64]


@compiled
def unpack(
    words: Words,
    blocks: Blocks,
    numbers: NDArray[np.int64],
    out: NDArray[np.floating[Any]],
    patterns: NDArray[np.signedinteger[Any]],
) -> None:
    """Write the source coordinates of points ``numbers`` (K,) into ``out`` (K, 3).

    ``patterns`` is ``out`` as integers.  Points that are adjacent in the order given are found the
    fastest.
    """
    block_word, block_first, base, bits, scaling = blocks
    magnitude = np.int64(2 ** (8 * patterns.itemsize - 1) - 1)
    block = -1
    start = stop = 0
    stride = 0
    for place in range(len(numbers)):
        number = numbers[place]
        if number < start or number >= stop:
            block += 1
            if not (block < len(bits) and block_first[block] <= number < block_first[block + 1]):
                block = np.searchsorted(block_first, number, side="right") - 1
            start, stop = block_first[block], block_first[block + 1]
            stride = 0
            for axis in range(3):
                stride += bits[block, axis] & WIDTH
        at = block_word[block] * 64 + (number - start) * stride
        for axis in range(3):
            width = bits[block, axis] & WIDTH
            value = base[block, axis]
            if width > 0:
                value += np.int64(_get(words, at, width))
            at += width
            if bits[block, axis] >= FLOATS:
                patterns[place, axis] = value ^ ((value >> 63) & magnitude)
            else:
                whole = value * scaling[0, axis] / scaling[2, axis]
                out[place, axis] = whole + scaling[1, axis]


@compiled
def shifted(
    source: NDArray[np.floating[Any]], shift: NDArray[np.float64], out: NDArray[np.float32]
) -> None:
    """Write source coordinates (K, 3) less ``shift`` into ``out``."""
    for place in range(len(source)):
        for axis in range(3):
            out[place, axis] = np.float32(np.float64(source[place, axis]) - shift[axis])
