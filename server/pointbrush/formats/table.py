"""Columns of points on their way to a file, all at once or block by block."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

Columns = Mapping[str, NDArray[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """``count`` rows of named columns; ``blocks`` gives them in order, and again when called again.

    There is at least one block; all have the same columns and types.
    """

    count: int
    blocks: Callable[[], Iterator[Columns]]

    @classmethod
    def of(cls, columns: Columns) -> Table:
        """Columns of equal length that are in memory."""
        return cls(len(next(iter(columns.values()))), lambda: iter([columns]))

    def opened(self) -> tuple[dict[str, np.dtype[Any]], Iterator[Columns]]:
        """The columns' types, and the blocks."""
        blocks = self.blocks()
        first = next(blocks)
        return {name: values.dtype for name, values in first.items()}, chain([first], blocks)

    def rows(self) -> tuple[dict[str, np.dtype[Any]], Iterator[NDArray[Any]]]:
        """The columns' types, and the blocks as packed little-endian rows."""
        types, blocks = self.opened()
        dtype = np.dtype([(name, kind.newbyteorder("<")) for name, kind in types.items()])

        def packed() -> Iterator[NDArray[Any]]:
            for columns in blocks:
                rows = np.empty(len(next(iter(columns.values()))), dtype)
                for name, values in columns.items():
                    rows[name] = values
                yield rows

        return types, packed()
