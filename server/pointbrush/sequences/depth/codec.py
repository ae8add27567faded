"""Depths of a lattice's pixels → bytes: interlaced prediction, and rANS.

The pixels of a ``Band`` are coded in the order of its points.  Each is predicted from the two known
pixels beside it (their mean), or in level 0 from the pixels left, above and above left (the median
of JPEG-LS).  The remainder is low bits and a token; the frequencies of tokens depend on the
difference of the two pixels.  docs/depth-format.md describes the bytes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost
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
SCALE_BITS = 10
SCALE = 1 << SCALE_BITS
STATES = 4
"""States of a coder: pixels take turns, so that a processor decodes several at once."""
WORD_BITS = 16
LOWEST = 1 << WORD_BITS
"""Least state of a decoder; below it, the decoder reads another word of WORD_BITS."""
_BITS = np.array([value.bit_length() for value in range(256)], np.uint8)


@innermost
def _bits(value: int) -> int:
    bits = 0
    while value > 255:
        value >>= 8
        bits += 8
    return bits + int(_BITS[value])


@innermost
def predict(image: Image, row: int, column: int, band: Band, last: int) -> tuple[int, int]:
    """Return the predicted depth of a pixel, and its context."""
    half, between = band.half, 0
    if half == 0:
        one = int(image[row, column - band.across]) if column >= band.across else 0
        other = int(image[row - band.down, column]) if row >= band.down else 0
        if one and other:
            between = int(image[row - band.down, column - band.across])
    elif band.vertical:
        one, other = int(image[row - half, column]), int(image[row + half, column])
    else:
        one, other = int(image[row, column - half]), int(image[row, column + half])
    if one and other:
        expected = (one + other) >> 1
        if between:
            expected = min(max(one + other - between, min(one, other)), max(one, other))
        return expected, int(_BITS[min(abs(one - other), 255)])
    if one or other:
        return one + other, ONE_CONTEXT
    return last, NONE_CONTEXT


@compiled
def _symbols(
    image: Image, band: Band, width: int
) -> tuple[NDArray[np.uint16], NDArray[np.int64], Bytes]:
    """Each pixel's context and token, ``context * TOKENS + token``; their counts; the low bits.

    Low bits lie one after another, from the lowest bit of each byte on.
    """
    down, across = band.down, band.across
    most = ((band.stop - band.row - 1) // down + 1) * ((width - band.column - 1) // across + 1)
    symbols, counts = np.empty(most, np.uint16), np.zeros(CONTEXTS * TOKENS, np.int64)
    low = np.empty(2 * most + 8, np.uint8)
    n, last, at, held, kept = 0, 0, 0, 0, 0
    for strip in range(band.row, band.stop, STRIP * down):
        end = min(strip + STRIP * down, band.stop)
        for column in range(band.column, width, across):
            for row in range(strip, end, down):
                expected, context = predict(image, row, column, band, last)
                value = int(image[row, column])
                token = 0
                if value:
                    last = value
                    rest = value - expected
                    folded = 2 * rest if rest >= 0 else -2 * rest - 1
                    token = 1 + folded
                    if folded >= DIRECT:
                        bits = _bits(folded) - 3
                        token = 1 + DIRECT + 4 * (bits - 2) + ((folded >> bits) & 3)
                        held |= (folded & ((1 << bits) - 1)) << kept
                        kept += bits
                        while kept >= 8:
                            low[at] = held & 255
                            held, kept, at = held >> 8, kept - 8, at + 1
                symbol = context * TOKENS + token
                symbols[n] = symbol
                counts[symbol] += 1
                n += 1
    if kept:
        low[at] = held
        at += 1
    return symbols, counts.reshape(CONTEXTS, TOKENS), low[:at]


@compiled
def _frequencies(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Frequencies of each context's tokens, of sum ``SCALE``, at least 1 for each that occurs."""
    frequency = np.zeros(counts.shape, np.int64)
    for context in range(len(counts)):
        total = counts[context].sum()
        if total == 0:
            continue
        share = frequency[context]
        for token in range(len(share)):
            if counts[context, token]:
                share[token] = max(1, (counts[context, token] * SCALE + total // 2) // total)
        # The most frequent tokens take the rounding error: it costs least there.
        while share.sum() != SCALE:
            greatest = np.argmax(share)
            rest = SCALE - share.sum()
            share[greatest] += max(rest, -(share[greatest] // 2))
    return frequency


@compiled
def _encode(
    symbols: NDArray[np.uint16], frequency: NDArray[np.int64], start: NDArray[np.int64]
) -> NDArray[np.uint16]:
    """The symbols as words, the decoder's first states ahead of them, low words first."""
    many_of, first_of = frequency.ravel(), start.ravel()
    out = np.empty(len(symbols) + 2 * STATES, np.uint16)
    at = len(out)
    states = np.full(STATES, LOWEST, np.int64)
    for n in range(len(symbols) - 1, -1, -1):
        many, first = many_of[symbols[n]], first_of[symbols[n]]
        state = states[n % STATES]
        if state >= many << (2 * WORD_BITS - SCALE_BITS):
            at -= 1
            out[at] = state & 0xFFFF
            state >>= WORD_BITS
        states[n % STATES] = (state // many) * SCALE + state % many + first
    for number in range(STATES - 1, -1, -1):
        at -= 2
        out[at], out[at + 1] = states[number] & 0xFFFF, states[number] >> WORD_BITS
    return out[at:]


@compiled
def _pack_tables(frequency: NDArray[np.int64]) -> Bytes:
    """For each context the number of tokens up to the last that occurs, and their frequencies."""
    out = np.empty(CONTEXTS * (1 + 2 * TOKENS), np.uint8)
    at = 0
    for context in range(CONTEXTS):
        count = TOKENS
        while count and frequency[context, count - 1] == 0:
            count -= 1
        out[at] = count
        at += 1
        for token in range(count):
            many = frequency[context, token]
            if many > 127:
                out[at] = many & 127 | 128
                many >>= 7
                at += 1
            out[at] = many
            at += 1
    return out[:at]


def encode_band(image: Image, band: Band, width: int) -> tuple[bytes, bytes, bytes]:
    """Encode a band of an image with a margin: its frequencies, tokens and low bits."""
    symbols, counts, low = _symbols(image, band, width)
    frequency = _frequencies(counts)
    tokens = _encode(symbols, frequency, token_starts(frequency)).astype("<u2", copy=False)
    return _pack_tables(frequency).tobytes(), tokens.tobytes(), low.tobytes()


def token_starts(frequency: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the first slot (CONTEXTS, TOKENS) of each token, of frequencies of this shape."""
    return np.cumsum(frequency, axis=1) - frequency


def varint(value: int) -> bytes:
    """Seven bits a byte, the lowest first; all but the last have their eighth set."""
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    out.append(value)
    return bytes(out)
