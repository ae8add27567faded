"""A vote of neighbouring cells, and of the groups they lie in, on their classes."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled

Chances = NDArray[np.float32]
GROUP_SHARE = 0.8
"""Weight of a group's mean beside a cell's own chance."""


@compiled
def smoothed(chance: Chances, near: NDArray[np.int32]) -> Chances:
    """Return the mean chance (C, K) of each cell and its neighbours ``near`` (C, 26)."""
    out = chance.copy()
    for c in range(len(chance)):
        held = np.float32(1)
        for other in near[c]:
            if other >= 0:
                held += np.float32(1)
                for k in range(chance.shape[1]):
                    out[c, k] += chance[other, k]
        for k in range(chance.shape[1]):
            out[c, k] /= held
    return out


def voted(chance: Chances, groups: Iterable[NDArray[np.int32]]) -> Chances:
    """Move the chance (C, K) of each cell towards the mean of its group, by one after the other.

    ``groups``: each (C,) numbers cells from 0, -1 for those in no group.
    """
    for group in groups:
        chance = _voted(chance, group)
    return chance


@compiled
def _voted(chance: Chances, group: NDArray[np.int32]) -> Chances:
    kinds = chance.shape[1]
    total = np.zeros((group.max() + 1, kinds + 1))
    for c in range(len(chance)):
        if group[c] >= 0:
            total[group[c], -1] += 1
            for k in range(kinds):
                total[group[c], k] += chance[c, k]
    out = chance.copy()
    for c in range(len(chance)):
        if group[c] >= 0:
            sums = total[group[c]]
            for k in range(kinds):
                mean = sums[k] / sums[-1]
                out[c, k] = (1 - GROUP_SHARE) * chance[c, k] + GROUP_SHARE * mean
    return out


def decided(chance: Chances) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return the likeliest class (C,), and how much likelier (C,), 0 to 1, than the next one."""
    if not len(chance):
        return np.zeros(0, np.int64), np.zeros(0, np.float32)
    best = chance.argmax(axis=1)
    if chance.shape[1] == 1:
        return best, np.ones(len(chance), np.float32)
    two = np.partition(chance, -2, axis=1)[:, -2:]
    return best, two[:, 1] - two[:, 0]


def answered(
    chance: Chances, of_point: NDArray[np.int32]
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return the class (N,) of each point, from 1, and the confidence (N,) 0 to 255."""
    best, margin = decided(chance)
    sure = np.clip(margin * 255, 0, 255).astype(np.uint8)
    return (best + 1).astype(np.uint8)[of_point], sure[of_point]
