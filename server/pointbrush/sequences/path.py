"""A shorter way through a chunk's points: smaller differences, fewer bytes.

Points in Morton order lie near each other, but neighbours on the curve are often not nearest
neighbours.  Inside runs that never leave a block of the spatial index, each point is followed by
the cheapest one that is left: few of its values change by more than four bits hold, and those
that do change little.  Blocks hold the same points as before, so culling works as before.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences.blocks import BLOCK_POINTS

_FAR = 3900
"""Differences count up to this, so that seven fields together are nearer than a used point."""
_USED = 32767
_FOUR_BITS = 7
_TOO_FAR_SHIFT = 7
"""A value that needs more than four bits costs 128 besides its difference (found by trial)."""


def short_path(values: NDArray[np.integer], runs_per_block: int) -> NDArray[np.int64]:
    """Numbers (N,) that put points with ``values`` (N, F ≤ 7), in Morton order, on a short way.

    The time is inversely proportional to ``runs_per_block``; longer runs have shorter ways.
    """
    count = len(values)
    if count == 0:
        return np.empty(0, np.int64)
    runs = runs_per_block * -(-count // BLOCK_POINTS)
    first = np.arange(runs + 1, dtype=np.int64) * count // runs
    lengths = np.diff(first)[:, None]
    place = np.arange(lengths.max())
    left = _left(values, np.minimum(first[:-1, None] + place, count - 1))
    present = place < lengths
    left[0][~present] = _USED
    return (first[:-1, None] + _walk(left))[present]


def _left(values: NDArray[np.integer], numbers: NDArray[np.int64]) -> NDArray[np.int16]:
    """Values (F, runs, size) within 0.._FAR, relative to each run's least."""
    runs = values.T.astype(np.int32)[:, numbers]
    runs -= runs.min(axis=2, keepdims=True)
    return np.minimum(runs, _FAR).astype(np.int16)


def _walk(left: NDArray[np.int16]) -> NDArray[np.int64]:
    """Greedy ways (runs, size) through ``left`` (F, runs, size), all runs at once.

    Points that are used have ``_USED`` as their first value; they come last.
    """
    fields, runs, size = left.shape
    every = np.arange(runs)
    here = np.zeros(runs, np.int64)
    way = np.empty((runs, size), np.int64)
    for step in range(size):
        way[:, step] = here
        place = left[:, every, here][..., None]
        left[0, every, here] = _USED
        distance = np.zeros((runs, size), np.uint16)
        for field in range(fields):
            change = np.abs(left[field] - place[field])
            distance += change.view(np.uint16)
            distance += np.left_shift(change > _FOUR_BITS, _TOO_FAR_SHIFT, dtype=np.uint16)
        here = distance.argmin(axis=1)
    return way
