"""A decoder of depth images in Python, for tests; docs/depth-format.md describes the bytes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost
from pointbrush.sequences.depth.codec import (
    CONTEXTS,
    DIRECT,
    LOWEST,
    SCALE,
    SCALE_BITS,
    STATES,
    TOKENS,
    WORD_BITS,
    Bytes,
    Image,
    predict,
    token_starts,
)
from pointbrush.sequences.depth.images import LENGTHS
from pointbrush.sequences.depth.lattice import STRIP, Band, Lattice
from pointbrush.sequences.depth.projection import empty_image, visit


class Pixels(NamedTuple):
    """Row-major pixels (N,) of points and their depths (N,) in units."""

    pixel: NDArray[np.int64]
    depth: NDArray[np.int64]


def decode_depth(lattice: Lattice, chunks: list[bytes]) -> tuple[Pixels, dict[int, bytes]]:
    """The pixels of the points of a frame's first ``chunks``, in stored order, and its pictures.

    The pictures, JPEG, are by the step of their pixels.
    """
    image, listed = empty_image(lattice), np.zeros(0, np.int64)
    size = lattice.height, lattice.width
    row_major = np.arange(lattice.height * lattice.width, dtype=np.int32).reshape(size)
    pixel, count = np.empty(row_major.size, np.int64), 0
    pictures = {}
    for chunk, (band, data) in enumerate(zip(lattice.bands, chunks, strict=False)):
        ends = LENGTHS.size + np.cumsum(LENGTHS.unpack_from(data))
        picture, tables, tokens = (
            data[start:stop] for start, stop in zip((LENGTHS.size, *ends[:-1]), ends, strict=True)
        )
        if picture:
            pictures[lattice.picture_step(band)] = picture
        if chunk == 0:
            listed, at = _read_listed(tables)
            tables = tables[at:]
        _decode_band(image, band, lattice.width, tables, tokens, data[ends[-1] :])
        inside = image[: lattice.height, : lattice.width]
        count = visit(np.where(inside > 0, row_major, -1), band, pixel, count)
    pixel = pixel[:count]
    value = image[pixel // lattice.width, pixel % lattice.width].astype(np.int64)
    return Pixels(pixel, listed[value - 1] if len(listed) else value), pictures


def unproject(
    lattice: Lattice, pixel: NDArray[np.integer], depth: NDArray[np.integer]
) -> NDArray[np.float64]:
    """Points (N, 3), local metres, of row-major pixels (N,) at depths (N,) in units."""
    along = depth * lattice.unit
    xyz = np.empty((len(pixel), 3))
    xyz[:, lattice.axis] = lattice.eye[lattice.axis] + lattice.sign * along
    places = (pixel % lattice.width, pixel // lattice.width)
    for side, place, tangent, pitch in zip(
        lattice.sides, places, lattice.tangent, lattice.pitch, strict=True
    ):
        xyz[:, side] = lattice.eye[side] + along * (tangent + pitch * place)
    return xyz


def _read_listed(data: bytes) -> tuple[NDArray[np.int64], int]:
    count, at = _read_varint(data, 0)
    steps = np.zeros(count, np.int64)
    for n in range(count):
        steps[n], at = _read_varint(data, at)
    return np.cumsum(steps), at


def _decode_band(
    image: Image, band: Band, width: int, tables: bytes, tokens: bytes, rest: bytes
) -> None:
    """Fill in a band of an image with a margin."""
    frequency = np.zeros((CONTEXTS, TOKENS), np.int64)
    at = 0
    for context in range(CONTEXTS):
        count, at = _read_varint(tables, at)
        for token in range(count):
            frequency[context, token], at = _read_varint(tables, at)
    assert np.isin(frequency.sum(axis=1), (0, SCALE)).all()
    words = np.frombuffer(tokens, "<u2")
    low = np.frombuffer(rest, np.uint8)
    _decode(image, band, width, frequency, token_starts(frequency), words, low)


@compiled
def _token_table(frequency: NDArray[np.int64], start: NDArray[np.int64]) -> NDArray[np.uint8]:
    """(CONTEXTS, SCALE) the token of each slot."""
    token_of = np.zeros((CONTEXTS, SCALE), np.uint8)
    for context in range(CONTEXTS):
        for token in range(TOKENS):
            first = start[context, token]
            token_of[context, first : first + frequency[context, token]] = token
    return token_of


@compiled
def _first_states(words: NDArray[np.uint16]) -> NDArray[np.int64]:
    """(STATES,) the states of the coder, two words each."""
    states = np.empty(STATES, np.int64)
    for n in range(STATES):
        states[n] = int(words[2 * n]) | int(words[2 * n + 1]) << WORD_BITS
    return states


@innermost
def _with_low_bits(code: int, rest: Bytes, bit_at: int) -> tuple[int, int]:
    """Value of a ``code`` with its low bits from ``bit_at``, and the place of the next bit."""
    bits = (code >> 2) + 2
    value = (4 + (code & 3)) << bits
    for bit in range(bits):
        value |= ((int(rest[bit_at >> 3]) >> (bit_at & 7)) & 1) << bit
        bit_at += 1
    return value, bit_at


@innermost
def _unfolded(folded: int) -> int:
    """The signed number of an unsigned one: 0, 1, 2, 3 … of 0, -1, 1, -2 …."""
    return folded >> 1 if folded & 1 == 0 else -((folded + 1) >> 1)


@compiled
def _decode(
    image: Image,
    band: Band,
    width: int,
    frequency: NDArray[np.int64],
    start: NDArray[np.int64],
    words: NDArray[np.uint16],
    rest: Bytes,
) -> None:
    """Fill in a band's pixels."""
    down, across = band.down, band.across
    token_of = _token_table(frequency, start)
    states = _first_states(words)
    n, at, bit_at, last = 0, 2 * STATES, 0, 0
    for strip in range(band.row, band.stop, STRIP * down):
        end = min(strip + STRIP * down, band.stop)
        for column in range(band.column, width, across):
            for row in range(strip, end, down):
                expected, context = predict(image, row, column, band, last)
                state = states[n % STATES]
                slot = state & (SCALE - 1)
                token = int(token_of[context, slot])
                many = frequency[context, token]
                state = many * (state >> SCALE_BITS) + slot - start[context, token]
                if state < LOWEST:
                    state = state << WORD_BITS | int(words[at])
                    at += 1
                states[n % STATES] = state
                n += 1
                if token == 0:
                    image[row, column] = 0
                    continue
                folded = token - 1
                if folded >= DIRECT:
                    folded, bit_at = _with_low_bits(folded - DIRECT, rest, bit_at)
                last = expected + _unfolded(folded)
                image[row, column] = last


def _read_varint(data: bytes, at: int) -> tuple[int, int]:
    """Return the number at ``at``, and the place of the next one."""
    value = shift = 0
    while True:
        byte = data[at]
        at += 1
        value |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            return value, at
