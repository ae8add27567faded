"""Columns of points to write to a file, all at once or block by block."""

from __future__ import annotations

import tempfile
import unicodedata
from collections.abc import Callable, Container, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import chain, count
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

Columns = Mapping[str, NDArray[Any]]
_MEMORY = 1 << 23
_ROWS = 1 << 20


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """``count`` rows of named columns; each call of ``blocks`` returns them in order.

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


def stored_name(name: str) -> str:
    """Return the unique column name of a source's field with its stored values."""
    return f"/{name}"


def plain_name(name: str, longest: int) -> str:
    """Return a name in ASCII without spaces, of at most ``longest`` characters, for headers."""
    bare = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    return "_".join(bare.split())[:longest] or "field"


def free_name(name: str, taken: Container[str], longest: int) -> str:
    """Return ``name``, with a number appended if ``taken`` contains it in lower case."""
    numbered = (f"{name[: longest - 1 - len(str(n))]}_{n}" for n in count(2))
    return next(each for each in chain([name], numbered) if each.lower() not in taken)


class Spools:
    """Stores blocks of columns, then returns each column as a table that can be read once."""

    def __init__(self, stack: ExitStack) -> None:
        """``stack`` closes the files."""
        self._stack = stack
        self._files: dict[str, IO[bytes]] = {}
        self._like: dict[str, NDArray[Any]] = {}
        self._counts: dict[str, int] = {}

    def add(self, columns: Mapping[str, NDArray[Any]]) -> None:
        """Append a block; all have the same columns."""
        for name, values in columns.items():
            if name not in self._files:
                spool = tempfile.SpooledTemporaryFile(_MEMORY)  # noqa: SIM115 - closed by the stack
                self._files[name] = self._stack.enter_context(spool)
                self._like[name], self._counts[name] = values[:0], 0
            self._files[name].write(np.ascontiguousarray(values).tobytes())
            self._counts[name] += len(values)

    def tables(self) -> dict[str, Table]:
        """A table of one column for each, in the order of the first block."""
        return {
            name: Table(count, lambda name=name: self._blocks(name))  # type: ignore[misc]
            for name, count in self._counts.items()
        }

    def _blocks(self, name: str) -> Iterator[Columns]:
        like, file = self._like[name], self._files[name]
        row = like.dtype.itemsize * int(np.prod(like.shape[1:], dtype=np.int64))
        file.seek(0)
        yield {name: like}
        while data := file.read(row * _ROWS):
            yield {name: np.frombuffer(data, like.dtype).reshape(-1, *like.shape[1:])}
