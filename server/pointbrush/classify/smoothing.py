"""Votes of neighbouring cells, and of the cells of one surface, on their classes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled

Chances = NDArray[np.float32]
LIKENESS_POWER = 16.0
"""Power of the likeness of two cells' chances, 0 to 1, that weighs a neighbour's vote."""
PIECE_SHARE = 0.5
"""Weight of the mean of a piece beside a cell's own chance."""


@compiled
def smoothed(chance: Chances, near: NDArray[np.int32]) -> Chances:
    """Return the weighted mean chance (C, K) of each cell and its neighbours ``near`` (C, 26).

    A neighbour weighs by the Bhattacharyya coefficient of both cells' chances: cells that are as
    large as the objects, as in sparse aerial scans, have neighbours of other classes.
    """
    root, out = np.sqrt(chance), chance.copy()
    kinds = chance.shape[1]
    for c in range(len(chance)):
        held = np.float32(1)
        for other in near[c]:
            if other >= 0:
                likeness = np.float32(0)
                for k in range(kinds):
                    likeness += root[c, k] * root[other, k]
                weight = np.float32(likeness**LIKENESS_POWER)
                held += weight
                for k in range(kinds):
                    out[c, k] += weight * chance[other, k]
        for k in range(kinds):
            out[c, k] /= held
    return out


@compiled
def average_over_pieces(chance: Chances, piece: NDArray[np.int32]) -> Chances:
    """Move the chance (C, K) of each cell towards the mean of its ``piece`` (C,).

    Pieces count from 0; without pieces, ``piece`` is empty.
    """
    if not len(piece):
        return chance
    kinds = chance.shape[1]
    total = np.zeros((piece.max() + 1, kinds + 1))
    for c in range(len(chance)):
        total[piece[c], -1] += 1
        for k in range(kinds):
            total[piece[c], k] += chance[c, k]
    out = chance.copy()
    for c in range(len(chance)):
        sums = total[piece[c]]
        for k in range(kinds):
            out[c, k] = (1 - PIECE_SHARE) * chance[c, k] + PIECE_SHARE * sums[k] / sums[-1]
    return out


def likeliest_classes(chance: Chances) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return the likeliest class (C,), and how much likelier (C,), 0 to 1, than the next one."""
    if not len(chance):
        return np.zeros(0, np.int64), np.zeros(0, np.float32)
    best = chance.argmax(axis=1)
    if chance.shape[1] == 1:
        return best, np.ones(len(chance), np.float32)
    two = np.partition(chance, -2, axis=1)[:, -2:]
    return best, two[:, 1] - two[:, 0]


def point_classes(
    chance: Chances, of_point: NDArray[np.int32]
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return the class (N,) of each point, from 1, and the confidence (N,) 0 to 255."""
    best, margin = likeliest_classes(chance)
    sure = np.clip(margin * 255, 0, 255).astype(np.uint8)
    return (best + 1).astype(np.uint8)[of_point], sure[of_point]
