"""Run lengths of binary masks as COCO stores them.

Runs go down the columns and begin with zeros.  The compressed text holds each run, minus the run
before the last one, in groups of five bits (``maskApi.c`` of pycocotools).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Runs = NDArray[np.int64]
DIGIT, SIGN, MORE, FIRST = 31, 16, 32, 48
"""Bits of a character: its value, the sign in the last character, another character follows; and
the code of a character without bits."""
MOST_CHARACTERS = 12
"""Most characters of a run: a 64-bit integer has no more."""


def runs_of_mask(mask: NDArray[np.bool_]) -> Runs:
    """Return the run lengths (n,) of a mask (height, width)."""
    flat = mask.ravel(order="F")
    edges = np.flatnonzero(flat[1:] != flat[:-1]) + 1
    first = [0] if flat[:1].any() else []
    ends = np.concatenate([first, edges, [len(flat)]]).astype(np.int64)
    return np.diff(ends, prepend=np.int64(0))


def mask_of_runs(runs: Runs, height: int, width: int) -> NDArray[np.bool_]:
    """Return the mask (height, width) of run lengths (n,).

    Raises ValueError for runs of another number of pixels.
    """
    pixels = height * width
    if ((runs < 0) | (runs > pixels)).any() or int(runs.sum()) != pixels:
        raise ValueError(f"runs of {int(runs.sum()):,} pixels, expected {pixels:,}")
    values = np.arange(len(runs)) % 2 == 1
    return np.repeat(values, runs).reshape(width, height).T


def compress_runs(runs: Runs) -> str:
    """Return the compressed text of run lengths (n,)."""
    rest = runs.copy()
    rest[3:] -= runs[1:-2]
    more = np.ones(len(rest), np.bool_)
    columns = []
    while more.any():
        present, digit = more, rest & DIGIT
        rest >>= 5
        more = present & np.where(digit & SIGN, rest != -1, rest != 0)
        columns.append(np.where(present, FIRST + digit + MORE * more, 0))
    characters = np.stack(columns, axis=1).astype(np.uint8) if columns else np.empty(0, np.uint8)
    return characters[characters > 0].tobytes().decode()


def decompress_runs(text: str) -> Runs:
    """Return the run lengths (n,) of a compressed text; raises ValueError for another text."""
    data = np.frombuffer(text.encode(), np.uint8).astype(np.int64) - FIRST
    if not len(data):
        return data
    if data.min() < 0 or data.max() >= 2 * MORE or data[-1] & MORE:
        raise ValueError("characters that compressed runs do not have")
    last = np.flatnonzero(data < MORE)
    first = np.concatenate([[0], last[:-1] + 1])
    place = np.arange(len(data)) - np.repeat(first, last - first + 1)
    if place.max() >= MOST_CHARACTERS:
        raise ValueError("a run of more than 64 bits")
    runs = np.add.reduceat((data & DIGIT) << 5 * place, first)
    runs -= np.where(data[last] & SIGN, 1 << 5 * (place[last] + 1), 0)
    for start in (1, 2):
        runs[start::2] = np.cumsum(runs[start::2])
    return runs
