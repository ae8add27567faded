"""A shorter path through a chunk's points: smaller differences, fewer bytes.

Points in Morton order lie near each other, but neighbours on the curve are often not nearest
neighbours.  Inside runs within a block of the spatial index, each point is followed by the cheapest
remaining one: few of its values change by more than four bits can hold, and the others change
little.  Blocks hold the same points as before, so that culling still works.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences.blocks import BLOCK_POINTS

_RUNS_PER_BLOCK = 2
"""The time is inversely proportional to it; longer runs have shorter paths."""


def short_path(values: NDArray[np.int32]) -> NDArray[np.int64]:
    """Return a short path (N,) through points with ``values`` (F ≤ 7, N) in Morton order."""
    from pointbrush.sequences.loops import walk

    count = values.shape[1]
    runs = _RUNS_PER_BLOCK * -(-count // BLOCK_POINTS)
    first = np.arange(runs + 1, dtype=np.int64) * count // max(runs, 1)
    way = np.empty(count, np.int64)
    walk(np.ascontiguousarray(values), first, way)
    return way
