"""Writing a large frame's files: columns of known length, filled from the back to the front."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences.octree.ahead import WORKERS
from pointbrush.sequences.octree.segment import Segment
from pointbrush.sequences.storage.files import write_all, write_file

_COPY = 1 << 24
_WORD = np.dtype("<u8")
_DIRTY = 1 << 26
"""Bytes written after which a sync starts while the next segments are encoded."""


def _write_header(out: BinaryIO, shape: tuple[int, ...], dtype: np.dtype[Any]) -> int:
    """Write the header of an ``.npy`` file of this shape; returns its length."""
    header = io.BytesIO()
    descr = np.lib.format.dtype_to_descr(dtype)
    np.lib.format.write_array_header_1_0(
        header, {"descr": descr, "fortran_order": False, "shape": shape}
    )
    return out.write(header.getvalue())


class Column:
    """An array (rows, …) on disk; parts are written in any order, unwritten rows are zero."""

    def __init__(self, path: Path, rows: int, like: NDArray[Any]) -> None:
        """``like`` gives the type and the shape of one row."""
        self.path, self.rows = path, rows
        self.dtype, self._tail = like.dtype, like.shape[1:]
        self._row = int(np.prod(self._tail, dtype=np.int64)) * like.itemsize
        self._file = path.open("w+b")
        self._start = _write_header(self._file, (rows, *self._tail), like.dtype)
        self._file.flush()
        os.truncate(path, self._start + rows * self._row)

    def write(self, first: int, part: NDArray[Any]) -> None:
        """Put ``part`` (n, …) at row ``first``."""
        if len(part) == 0:
            return
        data = np.ascontiguousarray(part, self.dtype)
        write_all(self._file.fileno(), data.data.cast("B"), self._start + first * self._row)

    def sync(self) -> None:
        """Flush all writes so far to the disk."""
        os.fdatasync(self._file.fileno())

    def close(self) -> None:
        """Make the file durable."""
        if not self._file.closed:
            os.fsync(self._file.fileno())
            self._file.close()


class Pile:
    """Bytes in a temporary file, read in another order than written."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("w+b")
        self.size = 0

    def add(self, data: bytes | memoryview) -> slice:
        """Append bytes and return their slice of the file."""
        self._file.write(data)
        start, self.size = self.size, self.size + len(data)
        return slice(start, self.size)

    def copy(self, parts: list[slice], out: BinaryIO) -> None:
        """Write parts one after another into ``out``, durably."""
        for part in parts:
            self._file.seek(part.start)
            left = part.stop - part.start
            while left:
                data = self._file.read(min(left, _COPY))
                out.write(data)
                left -= len(data)
        out.flush()
        os.fsync(out.fileno())

    def close(self) -> None:
        """Close the file."""
        self._file.close()


@dataclass(frozen=True, slots=True, eq=False)
class _Tables:
    """Summary of a written segment in memory; ``parent`` is the segment above, once known."""

    points: int
    base: NDArray[np.int64]
    bits: NDArray[np.uint8]
    chunks: NDArray[Any]
    block_first: NDArray[np.int64]
    block_lo: NDArray[np.float32]
    block_hi: NDArray[np.float32]
    blocks_per_chunk: NDArray[np.int64]
    wire: slice
    words: slice


class LargeWriter:
    """Writes segments into the frame's files, each in front of the earlier ones."""

    def __init__(self, folder: Path, temporary: Path, rows: int) -> None:
        """``folder`` gets the arrays, ``folder``.wire the bytes; both are complete at the end."""
        self._folder, self._rows, self._free = folder, rows, rows
        self._columns: dict[str, Column] = {}
        self._segments: list[_Tables] = []
        self._above: dict[int, int] = {}
        self._wire, self._words = Pile(temporary / "wire"), Pile(temporary / "words")
        self._dirty = 0
        self._disk = ThreadPoolExecutor(WORKERS, "disk")
        self._syncing: Future[None] | None = None
        self.error = 0.0

    def __enter__(self) -> LargeWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self._disk.shutdown(wait=True)
        self._wire.close()
        self._words.close()
        for column in self._columns.values():
            column.close()

    def add(self, segment: Segment) -> int:
        """Write a segment and return its number."""
        self._free -= len(segment)
        for name, part in segment.columns.items():
            self._column(name, part).write(self._free, part)
        self.error = max(self.error, segment.error)
        self._segments.append(
            _Tables(
                len(segment),
                segment.packed.base,
                segment.packed.bits,
                segment.chunks,
                segment.block_first,
                segment.block_lo,
                segment.block_hi,
                segment.blocks_per_chunk,
                self._wire.add(segment.wire),
                self._words.add(segment.packed.words.data.cast("B")),
            )
        )
        self._sync_behind(sum(part.nbytes for part in segment.columns.values()))
        return len(self._segments) - 1

    def _sync_behind(self, written: int) -> None:
        """Sync in the background, so that the sync at the end is short."""
        self._dirty += written
        if self._dirty < _DIRTY or not (self._syncing is None or self._syncing.done()):
            return
        columns, self._dirty = list(self._columns.values()), 0

        def sync() -> None:
            for column in columns:
                column.sync()

        self._wait_for_disk()
        self._syncing = self._disk.submit(sync)

    def _wait_for_disk(self) -> None:
        """Wait for the last sync; raise its error."""
        if self._syncing is not None:
            self._syncing.result()

    def attach(self, segments: list[int], above: int) -> None:
        """Set the first node of segment ``above`` as parent of the first nodes of ``segments``."""
        self._above |= dict.fromkeys(segments, above)

    def _column(self, name: str, part: NDArray[Any]) -> Column:
        column = self._columns.get(name)
        if column is None:
            column = Column(self._folder / f"{name}.npy", self._rows, part)
            self._columns[name] = column
        return column

    def finish(self, meta: Mapping[str, Any]) -> None:
        """Write the tables, and the wire file in the order of the points."""
        if self._free:
            raise ValueError(f"expected {self._rows} points, {self._free} are missing")
        order = list(reversed(range(len(self._segments))))
        tables = [self._segments[number] for number in order]
        self._wait_for_disk()
        written = [
            self._disk.submit(self._write_wire, [table.wire for table in tables]),
            self._disk.submit(self._write_words, [table.words for table in tables]),
            *(self._disk.submit(column.close) for column in self._columns.values()),
        ]
        for name, array in self._block_arrays(tables).items():
            np.save(self._folder / f"{name}.npy", array)
        np.save(self._folder / "chunks.npy", self._chunk_table(order))
        write_file(self._folder / "meta.json", json.dumps(dict(meta)).encode())
        for future in written:
            future.result()

    def _write_wire(self, parts: list[slice]) -> None:
        with self._folder.with_suffix(".wire").open("wb") as out:
            self._wire.copy(parts, out)

    def _write_words(self, parts: list[slice]) -> None:
        with (self._folder / "coordinates.npy").open("wb") as out:
            _write_header(out, (self._words.size // _WORD.itemsize,), _WORD)
            self._words.copy(parts, out)

    def _chunk_table(self, order: list[int]) -> NDArray[Any]:
        rows, first_chunk = [], {}
        points = offset = number = 0
        for segment in order:
            table = self._segments[segment]
            first_chunk[segment] = number
            chunks = table.chunks.copy()
            inner = chunks["parent"] >= 0
            chunks["parent"][inner] += number
            if segment in self._above:  # the segment above is stored before
                chunks["parent"][~inner] = first_chunk[self._above[segment]]
            chunks["first"] += points
            chunks["offset"] += offset
            points, offset = points + table.points, offset + table.wire.stop - table.wire.start
            number += len(chunks)
            rows.append(chunks)
        return np.concatenate(rows)

    @staticmethod
    def _block_arrays(tables: list[_Tables]) -> dict[str, NDArray[Any]]:
        ends = np.cumsum([table.points for table in tables])
        first = [
            table.block_first + end - table.points
            for table, end in zip(tables, ends.tolist(), strict=True)
        ]
        per_chunk = np.concatenate([table.blocks_per_chunk for table in tables])
        return {
            "block_first": np.append(np.concatenate(first), ends[-1]),
            "block_lo": np.concatenate([table.block_lo for table in tables]),
            "block_hi": np.concatenate([table.block_hi for table in tables]),
            "block_base": np.concatenate([table.base for table in tables]),
            "block_bits": np.concatenate([table.bits for table in tables]),
            "block_of_chunk": np.concatenate([[0], np.cumsum(per_chunk)]).astype(np.int64),
        }
