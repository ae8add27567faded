"""Runs of integers, many at once: how points are gathered from blocks without a Python loop."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def ranges(start: NDArray[np.int64], stop: NDArray[np.int64]) -> NDArray[np.int64]:
    """The integers of all ranges ``start[i]:stop[i]`` (n,), one range after the other."""
    length = stop - start
    begin = np.cumsum(length) - length
    offset = np.repeat(start - begin, length)
    return np.asarray(np.arange(len(offset), dtype=np.int64) + offset)
