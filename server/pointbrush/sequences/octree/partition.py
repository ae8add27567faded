"""Sorting a frame larger than memory into cubes that fit, in temporary files.

Rows arrive in any order and are appended to the file of their cube.  The frame's bounds may be
unknown: when there are too many cubes, their size doubles.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import DamagedError
from pointbrush.frame import PointFrame
from pointbrush.sequences.columns import require_local, to_local

Key = tuple[int, int, int]

MAX_CELLS = 512
CELL_ROWS = 1_200_000
"""Most rows of a finished cube, unless all are at one place."""

_FINEST = 24
_SPREAD = 16


@dataclass(slots=True)
class Cell:
    """A cube: edge ``2**exponent``, at ``key`` times that from the grid's corner."""

    exponent: int
    key: Key
    rows: int = 0
    files: list[Path] = field(default_factory=list)


@dataclass(frozen=True, slots=True, eq=False)
class Groups:
    """Rows sorted by cube: ``rows[first[i]:first[i + 1]]`` belong to ``keys[i]``."""

    exponent: int
    keys: NDArray[np.int64]
    first: NDArray[np.int64]
    rows: NDArray[Any]


def edge_exponent(extent: float) -> int:
    """Exponent of the cubes' edge for a frame, or its beginning, of this extent."""
    return int(np.ceil(np.log2(extent / _SPREAD))) if extent > 0 else -10


def group(
    part: PointFrame, dtype: np.dtype[Any], number: int, shift: NDArray[np.float64], exponent: int
) -> Groups:
    """Sort a part's points by the cubes of edge ``2**exponent`` that they are in, as rows.

    ``number`` is that of the first point in the source.  Raises BadInputError beyond float32.
    """
    # Imported on first use: loading compiled loops takes long, and only an import needs them.
    from pointbrush.sequences.octree.loops import local_bounds, sort_into_cubes

    ends = np.stack(local_bounds(part.xyz, shift))
    require_local(ends)
    while True:
        low, high = np.floor(ends / np.float32(2.0**exponent)).astype(np.int64)
        size = high - low + 1
        if float(size[0]) * float(size[1]) * float(size[2]) < 2**16:
            break
        exponent += 1
    order = np.empty(len(part), np.int64)
    first = sort_into_cubes(part.xyz, shift, 2.0**exponent, low, size, order)
    present = np.flatnonzero(np.diff(first))
    keys = np.stack(np.unravel_index(present, size.tolist()), axis=1) + low
    rows = np.empty(len(part), dtype)
    for name in (dtype.names or ())[:-1]:
        rows[name] = getattr(part, name).take(order, axis=0)
    rows["source_index"] = order + number
    return Groups(exponent, keys, np.append(first[present], len(part)), rows)


class Partition:
    """Cubes on disk.  Call ``add`` with groups in order, then ``finish`` for the cubes."""

    def __init__(
        self, folder: Path, dtype: np.dtype[Any], shift: NDArray[np.float64], exponent: int
    ) -> None:
        """``dtype``: rows with a field ``xyz``, source coordinates; local = source − ``shift``."""
        self.exponent = exponent
        self.rows = 0
        self._folder, self._dtype, self._shift = folder, dtype, shift
        self.corner: Key = (0, 0, 0)
        self._cells: dict[Key, Cell] = {}
        self._files = 0

    def add(self, groups: Groups) -> None:
        """Append rows to their cubes' files."""
        while groups.exponent > self.exponent:
            self._coarsen()
        shift = self.exponent - groups.exponent
        for number, key in enumerate((groups.keys >> shift).tolist()):
            part = groups.rows[groups.first[number] : groups.first[number + 1]]
            self._append(self._cells, self.exponent, tuple(key), part)
        self.rows += len(groups.rows)
        while len(self._cells) > MAX_CELLS:
            self._coarsen()

    def _append(self, cells: dict[Key, Cell], exponent: int, key: Key, part: NDArray[Any]) -> None:
        cell = cells.get(key)
        if cell is None:
            cell = cells[key] = Cell(exponent, key)
        if not cell.files:
            cell.files.append(self._folder / f"cell-{self._files:06d}")
            self._files += 1
        with cell.files[-1].open("ab") as file:
            part.tofile(file)
        cell.rows += len(part)

    def _coarsen(self) -> None:
        self.exponent += 1
        cells: dict[Key, Cell] = {}
        for (x, y, z), cell in self._cells.items():
            key = (x >> 1, y >> 1, z >> 1)
            merged = cells.setdefault(key, Cell(self.exponent, key))
            merged.rows += cell.rows
            merged.files += cell.files
        self._cells = cells

    def finish(self) -> tuple[list[Cell], int]:
        """The cubes in Morton order, none larger than memory allows, and the root's exponent.

        Keys count from ``corner`` (in edges of ``exponent``) then, and are never negative.
        """
        keys = np.array(list(self._cells))
        low = keys.min(axis=0)
        self.corner = tuple(low.tolist())
        root = self.exponent + int((keys.max(axis=0) - low).max()).bit_length()
        cells = [
            Cell(cell.exponent, tuple((np.array(key) - low).tolist()), cell.rows, cell.files)
            for key, cell in self._cells.items()
        ]
        cells = [part for cell in self._merge(cells, root) for part in self._split(cell)]
        finest = min(cell.exponent for cell in cells)

        def curve(cell: Cell) -> int:
            code = 0
            for bit in range(root - finest):
                for axis in range(3):
                    fine = cell.key[axis] << (cell.exponent - finest)
                    code |= ((fine >> bit) & 1) << (3 * bit + axis)
            return code

        return sorted(cells, key=curve), root

    def _merge(self, cells: list[Cell], root: int) -> list[Cell]:
        """Join cubes into the largest cubes that fit in memory."""
        totals: Counter[tuple[int, Key]] = Counter()
        for cell in cells:
            for up in range(root - cell.exponent + 1):
                totals[up, _above(cell.key, up)] += cell.rows
        joined: dict[tuple[int, Key], list[Cell]] = defaultdict(list)
        for cell in cells:
            up = 0
            while (
                up < root - cell.exponent and totals[up + 1, _above(cell.key, up + 1)] <= CELL_ROWS
            ):
                up += 1
            joined[up, _above(cell.key, up)].append(cell)
        return [
            Cell(
                self.exponent + up,
                key,
                sum(cell.rows for cell in parts),
                [file for cell in parts for file in cell.files],
            )
            for (up, key), parts in joined.items()
        ]

    def _split(self, cell: Cell) -> list[Cell]:
        """Split a cube with too many rows into octants, recursively."""
        if cell.rows <= CELL_ROWS:
            return [cell]
        if self.exponent - cell.exponent >= _FINEST:
            return self._cut(cell)
        octants: dict[Key, Cell] = {}
        middle = self.cube(cell)[0] + 2.0 ** (cell.exponent - 1)
        for rows in self._pieces(cell):
            side = to_local(rows["xyz"], self._shift) >= middle
            number = side @ np.array([4, 2, 1])
            for octant in np.unique(number).tolist():
                offset = (octant >> 2, (octant >> 1) & 1, octant & 1)
                x, y, z = (2 * k + o for k, o in zip(cell.key, offset, strict=True))
                self._append(octants, cell.exponent - 1, (x, y, z), rows[number == octant])
        return [part for octant in octants.values() for part in self._split(octant)]

    def _cut(self, cell: Cell) -> list[Cell]:
        """Cut a cube with all rows at one place into parts."""
        parts: list[Cell] = []
        for rows in self._pieces(cell):
            part: dict[Key, Cell] = {}
            self._append(part, cell.exponent, cell.key, rows)
            parts += part.values()
        return parts

    def cube(self, cell: Cell) -> tuple[NDArray[np.float64], float]:
        """Lower corner (3,) of a finished cube, local metres, and its edge."""
        edge = 2.0**cell.exponent
        return np.array(cell.key) * edge + np.array(self.corner) * 2.0**self.exponent, edge

    def _pieces(self, cell: Cell) -> Iterator[NDArray[Any]]:
        for path in cell.files:
            with path.open("rb") as file:
                while len(rows := np.fromfile(file, self._dtype, CELL_ROWS)):
                    yield rows
            path.unlink()

    def take(self, cell: Cell) -> NDArray[Any]:
        """Return all rows of a cube and remove its files."""
        rows = np.empty(cell.rows, self._dtype)
        left = rows.view(np.uint8).data
        for path in cell.files:
            with path.open("rb", buffering=0) as file:
                while read := file.readinto(left):
                    left = left[read:]
            path.unlink()
        if len(left):
            raise DamagedError(f"expected {cell.rows:,} rows in temporary files, got fewer")
        return rows


def _above(key: Key, up: int) -> Key:
    x, y, z = key
    return (x >> up, y >> up, z >> up)
