"""Depths of a lattice's pixels → bytes and back: interlaced prediction, and rANS.

The pixels of a ``Band`` are gone through in the order of its points.  Each is predicted from the
two known ones beside it (their mean), or in level 0 from those left, above and between (the median
that JPEG-LS takes).  What is left is a token, whose frequencies depend on how far the two differ,
and low bits.  docs/streaming.md describes the bytes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost
from pointbrush.errors import BadInputError
from pointbrush.sequences.depth.lattice import STRIP, Band

Bytes = NDArray[np.uint8]
Image = NDArray[np.uint16]

BOTH_CONTEXTS = 9
"""Contexts of pixels with both neighbours, from 0, by the bits of their difference."""
ONE_CONTEXT = BOTH_CONTEXTS
"""Context of pixels with one neighbour."""
NONE_CONTEXT = ONE_CONTEXT + 1
"""Context of pixels without a neighbour."""
CONTEXTS = NONE_CONTEXT + 1
DIRECT = 16
"""Remainders below this are tokens of their own; above, tokens stand for quarters of octaves."""
TOKENS = 1 + DIRECT + 4 * 14
"""Token 0: a pixel without a point."""
SCALE_BITS = 12
SCALE = 1 << SCALE_BITS
LOWEST = 1 << 23
"""The decoder's state is at least this: below it takes another byte."""


@innermost
def _bits(value: int) -> int:
    bits = 0
    while value:
        value >>= 1
        bits += 1
    return bits


@innermost
def _predict(
    image: Image,
    row: int,
    column: int,
    half: int,
    vertical: bool,
    down: int,
    across: int,
    last: int,
) -> tuple[int, int]:
    """The depth that is expected in a pixel, and the context."""
    between = 0
    if half == 0:
        one = int(image[row, column - across]) if column >= across else 0
        other = int(image[row - down, column]) if row >= down else 0
        if one and other:
            between = int(image[row - down, column - across])
    elif vertical:
        one, other = int(image[row - half, column]), int(image[row + half, column])
    else:
        one, other = int(image[row, column - half]), int(image[row, column + half])
    if one and other:
        expected = (one + other) >> 1
        if between:
            expected = min(max(one + other - between, min(one, other)), max(one, other))
        return expected, min(_bits(abs(one - other)), BOTH_CONTEXTS - 1)
    if one or other:
        return one + other, ONE_CONTEXT
    return last, NONE_CONTEXT


@compiled
def _tokens(
    image: Image, band: Band, width: int
) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.uint32], NDArray[np.uint8]]:
    """Token, context, low bits and their number, of each pixel of a band."""
    down, across = band.down, band.across
    most = ((band.stop - band.row - 1) // down + 1) * ((width - band.column - 1) // across + 1)
    token, context = np.empty(most, np.uint8), np.empty(most, np.uint8)
    low, bits = np.zeros(most, np.uint32), np.zeros(most, np.uint8)
    n, last = 0, 0
    for strip in range(band.row, band.stop, STRIP * down):
        end = min(strip + STRIP * down, band.stop)
        for column in range(band.column, width, across):
            for row in range(strip, end, down):
                expected, kind = _predict(
                    image, row, column, band.half, band.vertical, down, across, last
                )
                context[n] = kind
                value = int(image[row, column])
                if value == 0:
                    token[n] = 0
                else:
                    last = value
                    rest = value - expected
                    folded = 2 * rest if rest >= 0 else -2 * rest - 1
                    if folded < DIRECT:
                        token[n] = 1 + folded
                    else:
                        top = _bits(folded) - 1
                        token[n] = 1 + DIRECT + 4 * (top - 4) + ((folded >> (top - 2)) & 3)
                        bits[n] = top - 2
                        low[n] = folded & ((1 << (top - 2)) - 1)
                n += 1
    return token, context, low, bits


@compiled
def _frequencies(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Frequencies of tokens that sum to ``SCALE``, at least 1 for each that occurs."""
    total = counts.sum()
    frequency = np.zeros(len(counts), np.int64)
    if total == 0:
        return frequency
    for token in range(len(counts)):
        if counts[token]:
            frequency[token] = max(1, (counts[token] * SCALE + total // 2) // total)
    # What rounding left over or took too much goes to the most frequent, where it costs least.
    while frequency.sum() != SCALE:
        greatest = np.argmax(frequency)
        rest = SCALE - frequency.sum()
        frequency[greatest] += max(rest, -(frequency[greatest] // 2))
    return frequency


@compiled
def _encode(
    token: NDArray[np.uint8],
    context: NDArray[np.uint8],
    frequency: NDArray[np.int64],
    start: NDArray[np.int64],
) -> Bytes:
    """The tokens as bytes, the decoder's first state ahead of them."""
    out = np.empty(2 * len(token) + 8, np.uint8)
    at = len(out)
    state = LOWEST
    for n in range(len(token) - 1, -1, -1):
        many, first = frequency[context[n], token[n]], start[context[n], token[n]]
        while state >= ((LOWEST >> SCALE_BITS) << 8) * many:
            at -= 1
            out[at] = state & 255
            state >>= 8
        state = (state // many) * SCALE + state % many + first
    for _ in range(4):
        at -= 1
        out[at] = state & 255
        state >>= 8
    return out[at:]


@compiled
def _pack_bits(low: NDArray[np.uint32], bits: NDArray[np.uint8]) -> Bytes:
    """Low bits one after another, from the lowest bit of each byte on."""
    out = np.zeros((int(bits.astype(np.int64).sum()) + 7) // 8, np.uint8)
    at = 0
    for n in range(len(low)):
        for bit in range(bits[n]):
            out[at >> 3] |= ((low[n] >> bit) & 1) << (at & 7)
            at += 1
    return out


@compiled
def _decode(
    image: Image,
    band: Band,
    width: int,
    frequency: NDArray[np.int64],
    start: NDArray[np.int64],
    data: Bytes,
    rest: Bytes,
) -> bool:
    """Fill in a band's pixels; False where the bytes end too early."""
    down, across = band.down, band.across
    if len(data) < 4:
        return False
    token_of = np.zeros((CONTEXTS, SCALE), np.uint8)
    for context in range(CONTEXTS):
        for token in range(TOKENS):
            first = start[context, token]
            token_of[context, first : first + frequency[context, token]] = token
    state, at, bit_at, last = 0, 4, 0, 0
    for n in range(4):
        state = state << 8 | int(data[n])
    for strip in range(band.row, band.stop, STRIP * down):
        end = min(strip + STRIP * down, band.stop)
        for column in range(band.column, width, across):
            for row in range(strip, end, down):
                expected, context = _predict(
                    image, row, column, band.half, band.vertical, down, across, last
                )
                slot = state & (SCALE - 1)
                token = int(token_of[context, slot])
                many = frequency[context, token]
                state = many * (state >> SCALE_BITS) + slot - start[context, token]
                while state < LOWEST:
                    if at >= len(data):
                        return False
                    state = state << 8 | int(data[at])
                    at += 1
                if token == 0:
                    image[row, column] = 0
                    continue
                folded = token - 1
                if folded >= DIRECT:
                    code = folded - DIRECT
                    bits = (code >> 2) + 2
                    if bit_at + bits > 8 * len(rest):
                        return False
                    folded = (4 + (code & 3)) << bits
                    for bit in range(bits):
                        folded |= ((int(rest[bit_at >> 3]) >> (bit_at & 7)) & 1) << bit
                        bit_at += 1
                last = expected + (folded >> 1 if folded & 1 == 0 else -((folded + 1) >> 1))
                image[row, column] = last
    return True


def encode_band(image: Image, band: Band, width: int) -> tuple[bytes, bytes, bytes]:
    """Encode a band of an image with a margin: its frequencies, tokens and low bits."""
    token, context, low, bits = _tokens(image, band, width)
    counts = np.bincount(context.astype(np.int64) * TOKENS + token, minlength=CONTEXTS * TOKENS)
    frequency = np.stack([_frequencies(row) for row in counts.reshape(CONTEXTS, TOKENS)])
    tokens = _encode(token, context, frequency, _starts(frequency))
    tables = b"".join(_pack_table(row.tolist()) for row in frequency)
    return tables, tokens.tobytes(), _pack_bits(low, bits).tobytes()


def decode_band(
    image: Image, band: Band, width: int, tables: bytes, tokens: bytes, rest: bytes
) -> None:
    """Fill in a band of an image with a margin; raises BadInputError for other bytes."""
    frequency = np.zeros((CONTEXTS, TOKENS), np.int64)
    at = 0
    for context in range(CONTEXTS):
        count, at = read_varint(tables, at)
        for token in range(count):
            frequency[context, token], at = read_varint(tables, at)
    if not np.isin(frequency.sum(axis=1), (0, SCALE)).all():
        raise BadInputError(f"depth: expected frequencies of a sum of {SCALE}, got another")
    streams = (np.frombuffer(part, np.uint8) for part in (tokens, rest))
    if not _decode(image, band, width, frequency, _starts(frequency), *streams):
        raise BadInputError("depth: expected more bytes, got their end")


def _starts(frequency: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.cumsum(frequency, axis=1) - frequency


def _pack_table(frequency: list[int]) -> bytes:
    """Number of tokens up to the last that occurs, and the frequencies of these."""
    count = max((token + 1 for token, many in enumerate(frequency) if many), default=0)
    return varint(count) + b"".join(varint(many) for many in frequency[:count])


def varint(value: int) -> bytes:
    """Seven bits a byte, the lowest first; all but the last have their eighth set."""
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    out.append(value)
    return bytes(out)


def read_varint(data: bytes, at: int) -> tuple[int, int]:
    """The number at ``at``, and where the next one is; raises BadInputError at the end."""
    value = shift = 0
    while at < len(data):
        byte = data[at]
        at += 1
        value |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            return value, at
    raise BadInputError("depth: expected a number, got the end of the bytes")
