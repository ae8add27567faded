"""A stored frame in its source's order, block by block, in memory that does not grow with it.

Stored order is spatial, so that any run of source points lies scattered over the files.  Each
block is gathered in one pass through them; pieces that hold none of its points are skipped once
their span of source numbers is known.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences.stored_frame import StoredFrame

BLOCK_POINTS = 4_000_000
"""Points of a block; a frame that is no octree is one block."""
PIECE_POINTS = 1_000_000

Columns = dict[str, NDArray[Any]]
Reader = Callable[[int, int], Mapping[str, NDArray[Any]]]


def source_blocks(frame: StoredFrame, read: Reader) -> Iterator[Columns]:
    """Yield the values of ``read`` in source order: consecutive blocks, at least one.

    ``read(first, stop)`` returns columns of the points ``first`` to before ``stop``, stored order.
    """
    most = BLOCK_POINTS if frame.large else max(frame.count, 1)
    pieces = [
        (first, min(first + PIECE_POINTS, frame.count))
        for first in range(0, max(frame.count, 1), PIECE_POINTS)
    ]
    spans: dict[int, tuple[int, int]] = {}
    for start in range(0, max(frame.count, 1), most):
        size = min(most, frame.count - start)
        block: Columns = {}
        for first, stop in pieces:
            low, high = spans.get(first, (start, start))
            if high < start or low >= start + size > start:
                continue
            numbers = frame.read("source_index", first, stop)
            if len(numbers):
                spans[first] = int(numbers.min()), int(numbers.max())
            _gather(block, size, numbers.astype(np.int64) - start, first, read)
        yield block


def _gather(block: Columns, size: int, place: NDArray[np.int64], first: int, read: Reader) -> None:
    """Copy the points of a piece, from stored number ``first`` on, that belong to the block."""
    mine = np.flatnonzero((place >= 0) & (place < size))
    begin, end = (int(mine[0]), int(mine[-1]) + 1) if len(mine) else (0, 0)
    if begin == end and block:
        return
    for name, values in read(first + begin, first + end).items():
        if name not in block:
            block[name] = np.empty((size, *values.shape[1:]), values.dtype)
        block[name][place[mine]] = values[mine - begin]
