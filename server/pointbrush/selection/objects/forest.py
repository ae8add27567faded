"""Boosted trees as plain arrays, read by compiled loops."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import innermost


class Forest(NamedTuple):
    """Trees that share their arrays; a node's children follow its tree's numbers.

    ``feature`` (n,) int16, -1 for a leaf; ``threshold`` (n,) float32: left when a value is not
    above it, and a leaf's value; ``left``, ``right`` (n,) int32; ``roots`` (trees,) int32.
    """

    feature: NDArray[np.int16]
    threshold: NDArray[np.float32]
    left: NDArray[np.int32]
    right: NDArray[np.int32]
    roots: NDArray[np.int32]


@innermost
def answer(
    feature: NDArray[np.int16],
    threshold: NDArray[np.float32],
    left: NDArray[np.int32],
    right: NDArray[np.int32],
    roots: NDArray[np.int32],
    row: NDArray[np.float64],
) -> float:
    """Return the sum of the leaves that a row of numbers reaches."""
    total = 0.0
    for at in roots:
        while feature[at] >= 0:
            at = left[at] if row[feature[at]] <= threshold[at] else right[at]
        total += threshold[at]
    return total
