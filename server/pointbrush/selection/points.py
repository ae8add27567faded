"""The view of a frame that selection works on: culling by its blocks, and sets of its points.

A set of numbers grows bit by bit, a byte for each point near those in it, however many the frame
has.  Points near others are the same object in a frame that is laid over the one it was found in.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from pointbrush.ranges import by_block, ranges

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

Alive = Callable[[NDArray[np.int64]], NDArray[np.bool_]]
"""Says of point numbers whether each can be hit (a deleted point cannot)."""

GROUP_POINTS = 1 << 21
PIXELS_APART = 2.0
"""Pixels that neighbours on a surface are apart at most, seen from where they were measured."""
NOTHING: NDArray[np.int64] = np.empty(0, np.int64)
"""A part of a selection without points: between two of them somebody else may have a turn."""
BLOCK = 65_536
PART_POINTS = 1 << 20
REACH = 2.0
"""Distances between neighbours within which a point counts as one of the same surface."""
LEAST_REACH = 0.005
"""Metres, about a depth camera's noise."""


class Coordinates(Protocol):
    """Coordinates (N, 3) float32 by number: an array, or one that is unpacked when it is read."""

    def __len__(self) -> int: ...

    def __getitem__(self, which: slice | NDArray[np.int64], /) -> NDArray[np.float32]: ...


class Blocks(Protocol):
    """Bounding boxes of runs of spatially adjacent points, and of the chunks that hold the runs.

    Block ``b`` is the points ``first[b]:first[b + 1]`` in stored order, inside ``lo[b]``..``hi[b]``
    (local metres); chunk ``c`` is the blocks ``chunk_first[c]:chunk_first[c + 1]``.
    """

    @property
    def first(self) -> NDArray[np.int64]:
        """(B+1,) run borders."""

    @property
    def lo(self) -> NDArray[np.float32]:
        """(B, 3) least corners."""

    @property
    def hi(self) -> NDArray[np.float32]:
        """(B, 3) greatest corners."""

    @property
    def chunk_first(self) -> NDArray[np.int64]:
        """(C+1,) each chunk's first block."""

    @property
    def chunk_lo(self) -> NDArray[np.float32]:
        """(C, 3) least corners of the chunks."""

    @property
    def chunk_hi(self) -> NDArray[np.float32]:
        """(C, 3) greatest corners of the chunks."""


class Pixels(Protocol):
    """The pixels of a depth camera that points lie on, seen from ``eye`` along ``axis``.

    Neighbours are ``pitch`` times their depth apart, by columns and by rows.
    """

    @property
    def eye(self) -> tuple[float, float, float]:
        """(3,) local metres."""

    @property
    def axis(self) -> int:
        """Number of the axis along which depth is measured."""

    @property
    def pitch(self) -> tuple[float, float]:
        """Tangents between neighbouring columns, and rows."""


@dataclass(frozen=True, eq=False)
class Points:
    """A frame in stored order and local coordinates.

    ``xyz`` (N, 3) float32 metres; ``rgb`` (N, 3) uint8 or None; ``levels`` first point number of
    each progressive level (each level is an even subsample of the frame); ``kdtree`` gives the
    frame's tree, or is None where the frame is too large to have one; ``up`` points away from the
    ground; ``pixels`` of a frame that is an image; ``release`` lets go of the memory of what was
    looked at, where the frame is larger than memory.
    """

    xyz: Coordinates
    blocks: Blocks
    rgb: NDArray[np.uint8] | None = None
    levels: tuple[int, ...] = (0,)
    kdtree: Callable[[], cKDTree] | None = None
    release: Callable[[], None] | None = None
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    pixels: Pixels | None = None

    def __len__(self) -> int:
        return len(self.xyz)

    def blocks_in_box(self, lo: NDArray[np.float64], hi: NDArray[np.float64]) -> NDArray[np.int64]:
        """Numbers of the blocks whose boxes touch the box ``lo``..``hi`` (local metres)."""

        def touches(a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.bool_]:
            return np.asarray(((a <= hi) & (b >= lo)).all(axis=1))

        return self.blocks_where(touches)

    def blocks_where(
        self,
        touches: Callable[[NDArray[np.float32], NDArray[np.float32]], NDArray[np.bool_]],
    ) -> NDArray[np.int64]:
        """Numbers of the blocks whose boxes pass ``touches(lo, hi)``; chunks are culled first."""
        chunks = np.flatnonzero(touches(self.blocks.chunk_lo, self.blocks.chunk_hi))
        first = self.blocks.chunk_first
        numbers = ranges(first[chunks], first[chunks + 1])
        kept = touches(self.blocks.lo[numbers], self.blocks.hi[numbers])
        return np.asarray(numbers[kept])

    def groups(self, blocks: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
        """``blocks`` in runs of about two million points, to be worked on one after another."""
        ends = np.cumsum(self.blocks.first[blocks + 1] - self.blocks.first[blocks])
        start = 0
        while start < len(blocks):
            before = int(ends[start - 1]) if start else 0
            stop = int(np.searchsorted(ends, before + GROUP_POINTS, side="right"))
            stop = max(stop, start + 1)
            yield blocks[start:stop]
            if self.release is not None and stop - start < len(blocks):
                self.release()
            start = stop

    def numbers(self, blocks: NDArray[np.int64]) -> NDArray[np.int64]:
        """Stored numbers of all points in ``blocks``, ascending when ``blocks`` is."""
        return ranges(self.blocks.first[blocks], self.blocks.first[blocks + 1])

    def spacing(self, blocks: NDArray[np.int64]) -> NDArray[np.float64]:
        """Typical distance between neighbouring points of the surface in each block, metres.

        A block's own density is that of its level, a known share of the frame's points.
        """
        first = self.blocks.first
        count = np.maximum(first[blocks + 1] - first[blocks], 1)
        extent = np.sort(self.blocks.hi[blocks] - self.blocks.lo[blocks], axis=1)
        area = np.asarray(extent[:, 1], np.float64) * extent[:, 2]
        borders = np.append(np.asarray(self.levels, np.int64), len(self))
        share = np.diff(borders) / max(len(self), 1)
        level = np.searchsorted(borders, first[blocks], side="right") - 1
        spacing: NDArray[np.float64] = np.sqrt(
            area / count * share[np.minimum(level, len(share) - 1)]
        )
        return spacing

    def spacings(
        self, blocks: NDArray[np.int64], numbers: NDArray[np.int64]
    ) -> NDArray[np.float64]:
        """Typical distance between neighbours at each of ``numbers``, the points of ``blocks``.

        The blocks of an image reach over outlines, where their boxes say nothing of the surface:
        its pixels bound what they say.
        """
        counts = self.blocks.first[blocks + 1] - self.blocks.first[blocks]
        spacing = np.repeat(self.spacing(blocks), counts)
        if self.pixels is None:
            return spacing
        axis, pitch = self.pixels.axis, max(map(abs, self.pixels.pitch))
        depth = np.abs(self.xyz[numbers][:, axis] - self.pixels.eye[axis])
        return np.asarray(np.minimum(spacing, PIXELS_APART * pitch * depth))


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


def reach_of(xyz: NDArray[np.float64], spacings: float = REACH) -> float:
    """Return metres within which a point counts as one of the surface of points (N, 3).

    As many ``spacings``, the median distance between neighbours; at least ``LEAST_REACH``.
    """
    from scipy.spatial import cKDTree

    if len(xyz) < 2:
        return LEAST_REACH
    apart = np.asarray(cKDTree(xyz).query(xyz, k=2)[0])[:, 1]
    return max(LEAST_REACH, spacings * float(np.median(apart)))


def near(points: Points, xyz: NDArray[np.float64], reach: float) -> NDArray[np.int64]:
    """Numbers of the points within ``reach`` of one of ``xyz`` (N, 3), local metres; sorted."""
    from scipy.spatial import cKDTree

    if len(xyz) == 0:
        return NOTHING
    tree = cKDTree(xyz)
    found = [NOTHING]
    blocks = points.blocks_in_box(xyz.min(axis=0) - reach, xyz.max(axis=0) + reach)
    for group in points.groups(blocks):
        numbers = points.numbers(group)
        apart, _ = tree.query(points.xyz[numbers], distance_upper_bound=reach)
        found.append(numbers[np.isfinite(apart)])
    return np.concatenate(found)
