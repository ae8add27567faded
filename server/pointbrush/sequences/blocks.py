"""Bounding boxes over runs of adjacent points: selection culls boxes before it tests points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.ranges import ranges

BLOCK_POINTS = 256


@dataclass(frozen=True, slots=True, eq=False)
class Blocks:
    """Block ``b`` is the points ``first[b]:first[b + 1]`` in stored order, inside ``lo``–``hi``.

    ``first`` (B+1,) int64, ``lo`` and ``hi`` (B, 3) float32, local metres.  ``chunk_first``
    (C+1,) int64 numbers each chunk's first block and ``chunk_lo``, ``chunk_hi`` (C, 3) bound it:
    the upper level of the hierarchy.
    """

    first: NDArray[np.int64]
    lo: NDArray[np.float32]
    hi: NDArray[np.float32]
    chunk_first: NDArray[np.int64]
    chunk_lo: NDArray[np.float32]
    chunk_hi: NDArray[np.float32]

    def overlapping(self, lo: NDArray[np.floating], hi: NDArray[np.floating]) -> NDArray[np.int64]:
        """Sorted numbers of the blocks that meet the box ``lo``–``hi`` (3,), local metres."""
        chunks = np.flatnonzero(_meet(self.chunk_lo, self.chunk_hi, lo, hi))
        if len(chunks) == 0:
            return np.empty(0, np.int64)
        blocks = ranges(self.chunk_first[chunks], self.chunk_first[chunks + 1])
        met: NDArray[np.int64] = blocks[_meet(self.lo[blocks], self.hi[blocks], lo, hi)]
        return met


def _meet(
    a_lo: NDArray[np.float32],
    a_hi: NDArray[np.float32],
    lo: NDArray[np.floating],
    hi: NDArray[np.floating],
) -> NDArray[np.bool_]:
    meet = np.ones(len(a_lo), np.bool_)
    for axis in range(3):
        meet &= (a_lo[:, axis] <= hi[axis]) & (a_hi[:, axis] >= lo[axis])
    return meet


def cut(chunk_first: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Cut chunks, given their boundaries (C+1,), into blocks that never straddle two chunks.

    Returns block boundaries (B+1,) and each chunk's first block (C+1,).
    """
    counts = np.diff(chunk_first)
    per_chunk = -(-counts // BLOCK_POINTS)
    block_of_chunk = np.concatenate([[0], np.cumsum(per_chunk)]).astype(np.int64)
    chunk = np.repeat(np.arange(len(counts)), per_chunk)
    number = np.arange(len(chunk)) - block_of_chunk[chunk]
    # Even parts of each chunk, so that no block is left with a single stray point.
    first = chunk_first[chunk] + number * counts[chunk] // per_chunk[chunk]
    return np.append(first, chunk_first[-1]).astype(np.int64), block_of_chunk


def bound(
    xyz: NDArray[np.float32], first: NDArray[np.int64]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Bounds (B, 3) of the runs of points (N, 3) that start at ``first[:-1]``, none empty."""
    if len(first) < 2:
        return np.empty((0, 3), np.float32), np.empty((0, 3), np.float32)
    from pointbrush.sequences.loops import bound_runs

    return bound_runs(xyz, first)
