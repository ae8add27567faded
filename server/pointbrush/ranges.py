"""Runs of integers, many at once, and evenly spaced ones."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError


def ranges(start: NDArray[np.int64], stop: NDArray[np.int64]) -> NDArray[np.int64]:
    """The integers of all ranges ``start[i]:stop[i]`` (n,), one range after the other."""
    length = stop - start
    begin = np.cumsum(length) - length
    offset = np.repeat(start - begin, length)
    return np.asarray(np.arange(len(offset), dtype=np.int64) + offset)


def by_block(numbers: NDArray[np.int64], size: int) -> Iterator[tuple[int, slice]]:
    """The first number of each block of ``size`` that sorted ``numbers`` (n,) meet, and where."""
    if not len(numbers):
        return
    blocks = numbers // size
    ends = [*(np.flatnonzero(blocks[1:] != blocks[:-1]) + 1).tolist(), len(numbers)]
    for start, stop in zip([0, *ends], ends, strict=False):
        yield int(blocks[start]) * size, slice(start, stop)


def runs_of(numbers: NDArray[np.integer]) -> NDArray[np.int64]:
    """First number and length (R, 2) of each run of ascending numbers (n,)."""
    if len(numbers) == 0:
        return np.empty((0, 2), np.int64)
    starts = np.flatnonzero(np.diff(numbers, prepend=int(numbers[0]) - 2) != 1)
    lengths = np.diff(starts, append=len(numbers))
    return np.column_stack([numbers[starts], lengths]).astype(np.int64)


def numbers_of(runs: bytes, count: int) -> NDArray[np.int64]:
    """Return ascending numbers below ``count`` from ``runs``: first number and length, uint32 each.

    Raises BadInputError where runs are cut off, overlap or reach too far.
    """
    if len(runs) % 8:
        raise BadInputError(f"runs: expected 8 bytes each, got {len(runs)} bytes")
    start, length = np.frombuffer(runs, "<u4").astype(np.int64).reshape(-1, 2).T
    stop = start + length
    if (start[1:] < stop[:-1]).any() or (len(stop) and stop[-1] > count):
        raise BadInputError(f"runs: expected ascending runs of points 0 to {count - 1}")
    return ranges(start, stop)


def evenly_spaced(count: int, most: int) -> list[int]:
    """Return at most ``most`` of the numbers below ``count``, evenly spaced and ascending."""
    return sorted(set(np.linspace(0, count - 1, min(count, most)).astype(int).tolist()))
