"""Numbers of points that are added bit by bit: a byte for each point near them, however many."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pointbrush.ranges import by_block

BLOCK = 65_536
PART_POINTS = 1 << 20


class PointSet:
    """A set of stored numbers."""

    def __init__(self) -> None:
        self._blocks: dict[int, NDArray[np.bool_]] = {}
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def add(self, numbers: NDArray[np.int64]) -> NDArray[np.int64]:
        """Take in sorted numbers (n,); returns those that were not here."""
        fresh = np.empty(len(numbers), np.bool_)
        for first, part in by_block(numbers, BLOCK):
            if first not in self._blocks:
                self._blocks[first] = np.zeros(BLOCK, np.bool_)
            inside = self._blocks[first]
            at = numbers[part] - first
            fresh[part] = ~inside[at]
            inside[at] = True
        new = numbers[fresh]
        self._count += len(new)
        return new

    def has_any(self, numbers: NDArray[np.int64]) -> bool:
        """Whether one of sorted numbers (n,) is here."""
        return any(
            first in self._blocks and bool(self._blocks[first][numbers[part] - first].any())
            for first, part in by_block(numbers, BLOCK)
        )

    def parts(self) -> Iterator[NDArray[np.int64]]:
        """All numbers, ascending, about a million at a time."""
        gathered: list[NDArray[np.int64]] = []
        for first in sorted(self._blocks):
            gathered.append(np.flatnonzero(self._blocks[first]) + first)
            if sum(map(len, gathered)) > PART_POINTS - BLOCK:
                yield np.concatenate(gathered)
                gathered.clear()
        if gathered:
            yield np.concatenate(gathered)
