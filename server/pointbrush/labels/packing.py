"""A point's state in one 64-bit word, and its form on disk.

Bits 0-15 label, 16-18 provenance, 19-23 confidence, 24 deleted, 25-63 writer: the revision of the
edit that wrote the value, 0 for a point without edits.  Labels (with provenance) and deletion are
separate *layers* of words, so that undoing one never touches the other.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

States = NDArray[np.uint64]

BLOCK = 65_536
"""Points in a block: the unit of loading, of the journal and of snapshots."""
LABELS, DELETION = 0, 1
"""Layers."""
PROVENANCE_SHIFT = np.uint64(16)
PROVENANCE_BITS = np.uint64(0x7 << 16)
CONFIDENCE_SHIFT = np.uint64(19)
CONFIDENCE_BITS = np.uint64(0x1F << 19)
SUREST = 31
"""Number of steps in which the confidence of a point, 0 to 255, is stored."""
DELETED_SHIFT = np.uint64(24)
WRITER_SHIFT = np.uint64(25)
LABEL_BITS = np.uint64(0xFFFF)
VALUE_BITS = np.uint64((1 << 25) - 1)
DELETED_BIT = np.uint64(1 << 24)

_HEAD = struct.Struct("<II")
_LOW_BITS = np.uint64(19)
"""Label and provenance; the other bits are mostly equal within an edit's block."""
_LEVEL = 1  # zlib: the fastest, as an edit waits for this compression


@dataclass(frozen=True, slots=True, eq=False)
class Change:
    """Change of one block of one layer by an edit.

    ``indices`` (n,) sorted point numbers within the block; ``before`` and ``after`` (n,) words.
    """

    indices: NDArray[np.int64]
    before: States
    after: States


def label_of(states: States) -> NDArray[np.uint16]:
    """Return the label of each word."""
    return (states & LABEL_BITS).astype(np.uint16)


def provenance_of(states: States) -> NDArray[np.uint8]:
    """Return the provenance of each word."""
    return ((states & PROVENANCE_BITS) >> PROVENANCE_SHIFT).astype(np.uint8)


def confidence_of(states: States) -> NDArray[np.uint8]:
    """Return the confidence of each word, 0 to 255; 0 if it was not predicted."""
    steps = (states & CONFIDENCE_BITS) >> CONFIDENCE_SHIFT
    return ((steps * np.uint64(255) + np.uint64(SUREST // 2)) // np.uint64(SUREST)).astype(np.uint8)


def confidence_bits(confidence: NDArray[np.uint64]) -> States:
    """Return the bits of confidences 0 to 255."""
    steps = (confidence * np.uint64(SUREST) + np.uint64(127)) // np.uint64(255)
    return steps << CONFIDENCE_SHIFT


def deleted_of(states: States) -> NDArray[np.bool_]:
    """Return the deletion flag of each word."""
    return (states & DELETED_BIT).astype(np.bool_)


def writer_of(states: States) -> NDArray[np.uint64]:
    """Return the revision that wrote each word."""
    return states >> WRITER_SHIFT


def written_by(revision: int) -> np.uint64:
    """Return the writer bits of a word."""
    return np.uint64(revision) << WRITER_SHIFT


def encode_change(change: Change) -> bytes:
    """Return the bytes of a change: a table of its distinct words, gaps between points, codes."""
    before, before_codes = _distinct(change.before)
    after, after_codes = _distinct(change.after)
    words = np.concatenate([before, after])
    codes = np.concatenate([before_codes, after_codes + len(before)])
    gaps = np.diff(change.indices, prepend=0).astype(np.uint16)
    body = (
        _HEAD.pack(len(gaps), len(words)),
        words.tobytes(),
        gaps.tobytes(),
        codes.astype(_code_type(len(words))).tobytes(),
    )
    return zlib.compress(b"".join(body), _LEVEL)


def _distinct(states: States) -> tuple[States, NDArray[np.intp]]:
    """Return the distinct words, and for each word its index among them."""
    if len(states) and (states == states[0]).all():  # true for most edits
        return states[:1], np.zeros(len(states), np.intp)
    high = states >> _LOW_BITS
    if len(states) < BLOCK // 16 or not (high == high[0]).all():
        return np.unique(states, return_inverse=True)
    # One writer: a table of the present values takes an eighth of the time of sorting.
    low = (states & np.uint64((1 << int(_LOW_BITS)) - 1)).astype(np.intp)
    present = np.flatnonzero(np.bincount(low))
    codes = np.empty(present[-1] + 1, np.intp)
    codes[present] = np.arange(len(present))
    return present.astype(np.uint64) | (high[0] << _LOW_BITS), codes[low]


def decode_change(data: bytes) -> Change:
    """Decode the result of ``encode_change``."""
    body = zlib.decompress(data)
    n, distinct = _HEAD.unpack_from(body)
    at = _HEAD.size
    words = np.frombuffer(body, np.uint64, distinct, at)
    at += 8 * distinct
    gaps = np.frombuffer(body, np.uint16, n, at)
    codes = np.frombuffer(body, _code_type(distinct), 2 * n, at + 2 * n)
    states = words[codes]
    return Change(np.cumsum(gaps, dtype=np.int64), states[:n], states[n:])


def encode_states(states: States) -> bytes:
    """Return the bytes of a whole block; transposed byte planes compress fast and well."""
    planes = np.ascontiguousarray(states.view(np.uint8).reshape(-1, 8).T)
    return zlib.compress(planes.tobytes(), _LEVEL)


def decode_states(data: bytes) -> States:
    """Decode the result of ``encode_states`` to writable words."""
    planes = np.frombuffer(zlib.decompress(data), np.uint8).reshape(8, -1)
    return np.ascontiguousarray(planes.T).reshape(-1).view(np.uint64)


def _code_type(distinct: int) -> type[np.unsignedinteger]:
    if distinct <= 1 << 8:
        return np.uint8
    return np.uint16 if distinct <= 1 << 16 else np.uint32
