"""View of a frame for selection: culling by blocks, and sets of points.

The memory of a set of numbers depends on its size instead of the frame's.  Near points of an
overlaid frame belong to the same object.
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
"""Function of point numbers: mask of points that rays can hit, without deleted ones."""

GROUP_POINTS = 1 << 21
PIXELS_APART = 2.0
"""Maximum distance, in pixels, of neighbours on a surface, from the sensor."""
NOTHING: NDArray[np.int64] = np.empty(0, np.int64)
"""An empty part of a selection, at which other work may be scheduled."""
BLOCK = 65_536
PART_POINTS = 1 << 20
REACH = 2.0
"""Maximum distance from a surface's points, in their spacings, of a point on it."""
LEAST_REACH = 0.005
"""Metres, about the noise of a depth camera."""


class Coordinates(Protocol):
    """Coordinates (N, 3) float32 by number: an array, or one that is decoded on access."""

    def __len__(self) -> int: ...

    def __getitem__(self, which: slice | NDArray[np.int64], /) -> NDArray[np.float32]: ...


class Blocks(Protocol):
    """Bounding boxes of runs of spatially adjacent points, and of chunks of runs.

    Block ``b`` has the points ``first[b]:first[b + 1]`` in stored order, in the box from ``lo[b]``
    to ``hi[b]`` (local metres); chunk ``c`` has the blocks ``chunk_first[c]:chunk_first[c + 1]``.
    """

    @property
    def first(self) -> NDArray[np.int64]:
        """(B+1,) borders of runs."""

    @property
    def lo(self) -> NDArray[np.float32]:
        """(B, 3) minimum corners."""

    @property
    def hi(self) -> NDArray[np.float32]:
        """(B, 3) maximum corners."""

    @property
    def chunk_first(self) -> NDArray[np.int64]:
        """(C+1,) first block of each chunk."""

    @property
    def chunk_lo(self) -> NDArray[np.float32]:
        """(C, 3) minimum corners of the chunks."""

    @property
    def chunk_hi(self) -> NDArray[np.float32]:
        """(C, 3) maximum corners of the chunks."""


class Pixels(Protocol):
    """Pixel lattice of a depth camera's points, seen from ``eye`` along ``axis``.

    Neighbours are at a distance of ``pitch`` times their depth, by columns and by rows.
    """

    @property
    def eye(self) -> tuple[float, float, float]:
        """(3,) local metres."""

    @property
    def axis(self) -> int:
        """Index of the axis of depth."""

    @property
    def pitch(self) -> tuple[float, float]:
        """Tangents between neighbouring columns, and rows."""


@dataclass(frozen=True, eq=False)
class Points:
    """A frame in stored order and local coordinates.

    ``xyz`` (N, 3): float32 metres; ``rgb`` (N, 3): uint8 or None; ``levels``: first point number of
    each progressive level (a uniform subsample of the frame); ``kdtree``: function for the frame's
    tree, None if the frame is too large; ``up``: direction away from the ground; ``pixels``:
    lattice of an image; ``release``: function to free the memory of read parts of a frame larger
    than memory.
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
        """Return numbers of blocks with boxes touching the box ``lo``..``hi`` (local metres)."""

        def touches(a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.bool_]:
            return np.asarray(((a <= hi) & (b >= lo)).all(axis=1))

        return self.blocks_where(touches)

    def blocks_where(
        self,
        touches: Callable[[NDArray[np.float32], NDArray[np.float32]], NDArray[np.bool_]],
    ) -> NDArray[np.int64]:
        """Return numbers of blocks with ``touches(lo, hi)`` of their boxes; chunks come first."""
        chunks = np.flatnonzero(touches(self.blocks.chunk_lo, self.blocks.chunk_hi))
        first = self.blocks.chunk_first
        numbers = ranges(first[chunks], first[chunks + 1])
        kept = touches(self.blocks.lo[numbers], self.blocks.hi[numbers])
        return np.asarray(numbers[kept])

    def groups(self, blocks: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
        """Yield ``blocks`` in groups of about two million points."""
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
        """Return stored numbers of all points in ``blocks``, ascending if ``blocks`` is."""
        return ranges(self.blocks.first[blocks], self.blocks.first[blocks + 1])

    def spacing(self, blocks: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the typical spacing of surface points in each block, in metres.

        The density of a block is corrected by the known share of its level in the frame's points.
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
        """Return the typical spacing at each of ``numbers``, the points of ``blocks``.

        Blocks of an image extend over outlines, where their boxes overestimate the spacing; its
        pixels limit it.
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
        """Add sorted numbers (n,); return the new ones."""
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
        """Return whether the set has one of sorted numbers (n,)."""
        return any(
            first in self._blocks and bool(self._blocks[first][numbers[part] - first].any())
            for first, part in by_block(numbers, BLOCK)
        )

    def parts(self) -> Iterator[NDArray[np.int64]]:
        """Yield all numbers, ascending, in parts of about a million."""
        gathered: list[NDArray[np.int64]] = []
        for first in sorted(self._blocks):
            gathered.append(np.flatnonzero(self._blocks[first]) + first)
            if sum(map(len, gathered)) > PART_POINTS - BLOCK:
                yield np.concatenate(gathered)
                gathered.clear()
        if gathered:
            yield np.concatenate(gathered)


def reach_of(xyz: NDArray[np.float64], spacings: float = REACH) -> float:
    """Return the distance (m) from points (N, 3) within which a point is on their surface.

    It is ``spacings`` times the median distance between neighbours, at least ``LEAST_REACH``.
    """
    from scipy.spatial import cKDTree

    if len(xyz) < 2:
        return LEAST_REACH
    apart = np.asarray(cKDTree(xyz).query(xyz, k=2)[0])[:, 1]
    return max(LEAST_REACH, spacings * float(np.median(apart)))


def near(points: Points, xyz: NDArray[np.float64], reach: float) -> NDArray[np.int64]:
    """Return sorted numbers of the points within ``reach`` of ``xyz`` (N, 3), in local metres."""
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
