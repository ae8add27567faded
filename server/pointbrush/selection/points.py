"""The view of a frame that selection works on, and culling by its blocks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

GROUP = 64
"""Blocks per coarse box: two levels of boxes cull a hundred million points in milliseconds."""


class Blocks(Protocol):
    """Bounding boxes of runs of spatially adjacent points."""

    @property
    def first(self) -> NDArray[np.int64]:
        """(B+1,) run borders, in stored order."""

    @property
    def lo(self) -> NDArray[np.float32]:
        """(B, 3) least corners, local metres."""

    @property
    def hi(self) -> NDArray[np.float32]:
        """(B, 3) greatest corners, local metres."""


@dataclass(frozen=True, eq=False)
class Points:
    """A frame in stored order and local coordinates.

    ``xyz`` (N, 3) float32 metres; ``rgb`` (N, 3) uint8 or None; ``levels`` first point number of
    each progressive level (each level is an even subsample of the frame); ``kdtree`` gives the
    frame's tree, or is None where the frame is too large to have one.
    """

    xyz: NDArray[np.float32]
    blocks: Blocks
    rgb: NDArray[np.uint8] | None = None
    levels: tuple[int, ...] = (0,)
    kdtree: Callable[[], cKDTree] | None = None

    def __len__(self) -> int:
        return len(self.xyz)

    @cached_property
    def _coarse(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        starts = np.arange(0, len(self.blocks.lo), GROUP)
        lo = np.minimum.reduceat(self.blocks.lo, starts, axis=0)
        hi = np.maximum.reduceat(self.blocks.hi, starts, axis=0)
        return lo, hi

    def blocks_in_box(self, lo: NDArray[np.float64], hi: NDArray[np.float64]) -> NDArray[np.int64]:
        """Numbers of the blocks whose boxes touch the box ``lo``..``hi`` (local metres)."""

        def touches(a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.bool_]:
            return np.asarray(((a <= hi) & (b >= lo)).all(axis=1))

        return self.blocks_where(touches)

    def blocks_where(
        self,
        touches: Callable[[NDArray[np.float32], NDArray[np.float32]], NDArray[np.bool_]],
    ) -> NDArray[np.int64]:
        """Numbers of the blocks whose boxes pass ``touches(lo, hi)``, coarse boxes first."""
        block_lo, block_hi = self.blocks.lo, self.blocks.hi
        n = len(block_lo)
        if n == 0:
            return np.empty(0, np.int64)
        if n <= 4 * GROUP:
            return np.flatnonzero(touches(block_lo, block_hi))
        groups = np.flatnonzero(touches(*self._coarse))
        numbers = (groups[:, None] * GROUP + np.arange(GROUP)).ravel()
        numbers = numbers[numbers < n]
        return numbers[touches(block_lo[numbers], block_hi[numbers])]

    def numbers(self, blocks: NDArray[np.int64]) -> NDArray[np.int64]:
        """Stored numbers of all points in ``blocks``, ascending when ``blocks`` is."""
        return spans(self.blocks.first[blocks], self.blocks.first[blocks + 1])

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


def spans(start: NDArray[np.int64], stop: NDArray[np.int64]) -> NDArray[np.int64]:
    """Concatenated ``arange(start[i], stop[i])`` without a Python loop."""
    lengths = stop - start
    total = int(lengths.sum())
    if total == 0:
        return np.empty(0, np.int64)
    offset = np.repeat(start - np.concatenate(([0], np.cumsum(lengths)[:-1])), lengths)
    return offset + np.arange(total)
