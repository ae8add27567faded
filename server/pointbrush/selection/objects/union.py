"""Union-find over numbered things, with path halving."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import innermost


@innermost
def find(parent: NDArray[np.int64], i: int) -> int:
    """Return the root of ``i`` and shorten the way to it."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i
