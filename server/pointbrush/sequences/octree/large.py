"""A frame larger than memory: points in any order → an octree of chunks on disk.

First the points are sorted into cubes in temporary files.  Then each cube, in memory, passes an
even subsample to its ancestors and becomes a subtree; cubes are encoded in parallel.  Last, the
subsamples become the levels above.  Points are stored with the upper levels
first, so the columns are written from the back: their length is known, the upper part's is not.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.frame import PointFrame
from pointbrush.sequences.octree.ahead import WORKERS, ahead
from pointbrush.sequences.octree.growing import LargeWriter
from pointbrush.sequences.octree.partition import CELL_ROWS, Cell, Groups, Key, Partition
from pointbrush.sequences.octree.rows import Part, Parts, Rows
from pointbrush.sequences.octree.segment import Segment, encode_cube
from pointbrush.sequences.wire.chunk import Grid

_SCAN_SHARE = 0.5

Report = Callable[[float, str], None]
Beside = Callable[[PointFrame, int], None]


class LargeFrame:
    """Writes one large frame into ``folder`` (and ``folder``.wire), which must not exist."""

    def __init__(self, folder: Path, report: Report, beside: Beside) -> None:
        """``beside`` gets each part and the number of its first point, in several threads."""
        self.folder = folder
        self._report, self._beside = report, beside
        self._temporary = folder.with_name(folder.name + ".parts")

    def write(self, chunks: Iterable[PointFrame], grid: Grid, total: int | None) -> float:
        """Store the points of all ``chunks``, which have the same fields, as one frame.

        Returns the greatest quantisation error per axis.
        Raises BadInputError when fields or types differ or there are too many points.
        """
        self._temporary.mkdir()
        self.folder.mkdir()
        with ThreadPoolExecutor(WORKERS, "octree") as pool:
            parts = Parts(chunks, grid)
            partition = self._partition(pool, parts, grid, total)
            cells, root = partition.finish()
            with LargeWriter(self.folder, self._temporary, partition.rows) as writer:
                encode = partial(encode_cube, grid=grid, scaling=np.array(parts.meta["scaling"]))
                above = self._subtrees(pool, partition, cells, root, encode, writer)
                self._ancestors(partition, above, root, encode, writer)
                self._report(0.97, "writing the tables")
                writer.finish(parts.meta)
        shutil.rmtree(self._temporary)
        return writer.error

    def _partition(
        self, pool: ThreadPoolExecutor, parts: Parts, grid: Grid, total: int | None
    ) -> Partition:
        """Sort all rows into cubes; other threads group rows during the reading."""

        def group(part: Part) -> Groups:
            self._beside(part.frame, part.first)
            return part.groups()

        partition: Partition | None = None
        for groups in ahead(pool, group, parts):
            if partition is None:
                partition = Partition(
                    self._temporary, groups.rows.dtype, grid.shift, groups.exponent
                )
            partition.add(groups)
            share = partition.rows / total if total else 0.0
            self._report(_SCAN_SHARE * min(share, 1.0), f"read {partition.rows:,} points")
        if partition is None:
            raise BadInputError("expected at least one point, got none")
        return partition

    def _subtrees(
        self,
        pool: ThreadPoolExecutor,
        partition: Partition,
        cells: list[Cell],
        root: int,
        encode_rows: Callable[..., Segment],
        writer: LargeWriter,
    ) -> dict[int, dict[Key, list[_Branch]]]:
        """Write every cube's subtree, last cube first; return subsamples by level and cube."""
        above: dict[int, dict[Key, list[_Branch]]] = {}

        def encode(cell: Cell) -> tuple[Cell, Segment]:
            corner, edge = partition.cube(cell)
            level = root - cell.exponent
            rows = partition.take(cell)
            return cell, encode_rows(rows, corner, edge, level, hands_up=len(cells) > 1)

        done = 0
        for cell, segment in ahead(
            pool, encode, reversed(cells), size=lambda cell: cell.rows / CELL_ROWS
        ):
            number = writer.add(segment)
            branch = _Branch(segment.up, [number] if len(segment) else [])
            above.setdefault(root - cell.exponent, {}).setdefault(cell.key, []).append(branch)
            done += cell.rows
            share = _SCAN_SHARE + (0.96 - _SCAN_SHARE) * done / partition.rows
            self._report(share, f"ordered {done:,} of {partition.rows:,} points")
        return above

    def _ancestors(
        self,
        partition: Partition,
        above: dict[int, dict[Key, list[_Branch]]],
        root: int,
        encode_rows: Callable[..., Segment],
        writer: LargeWriter,
    ) -> None:
        """Build the levels above the cubes from the cubes' subsamples, deepest first."""
        for level in range(max(above), 0, -1):
            branches = sorted(above.pop(level, {}).items(), reverse=True)
            parents: dict[Key, list[_Branch]] = {}
            for (x, y, z), parts in branches:
                parents.setdefault((x >> 1, y >> 1, z >> 1), []).extend(parts)
            for key, parts in parents.items():
                exponent = root - (level - 1)
                corner, edge = partition.cube(Cell(exponent, key))
                rows = np.concatenate([part.up for part in parts])
                segment = encode_rows(rows, corner, edge, level - 1, hands_up=level > 1)
                below = [number for part in parts for number in part.segments]
                if len(segment):
                    number = writer.add(segment)
                    writer.attach(below, number)
                    below = [number]
                branch = _Branch(segment.up, below)
                above.setdefault(level - 1, {}).setdefault(key, []).append(branch)


class _Branch:
    """Rows for the level above, and the segments that wait for their parent there."""

    def __init__(self, up: Rows, segments: list[int]) -> None:
        self.up = up
        self.segments = segments
