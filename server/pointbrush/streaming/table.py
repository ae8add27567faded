"""A frame's levels as running totals: bytes and points of a prefix of its chunks; its pieces."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from pointbrush.sequences import StoredFrame

LARGEST_PIECE = 2 * 2**20


@dataclass(frozen=True, slots=True)
class Piece:
    """Chunks [first, stop) of a frame; ``final`` completes it, ``step`` is a step of the clock.

    ``depth``: the chunks are sent as parts of the frame's depth image.
    """

    frame: int
    first: int
    stop: int
    final: bool
    step: int = 0
    depth: bool = False


@dataclass(frozen=True, slots=True)
class FrameTable:
    """``stops[l]`` chunks, ``nbytes[l]`` bytes and ``points[l]`` points up to level ``l``.

    ``ends[c]`` is the end of chunk ``c`` in the wire file, ``firsts[c]`` its first point and
    ``firsts[-1]`` the number of points.  ``base``: offset of the first chunk in the wire file.
    ``depth``: the counts are of the parts of a depth image.
    """

    stops: tuple[int, ...]
    nbytes: tuple[int, ...]
    points: tuple[int, ...]
    ends: tuple[int, ...]
    firsts: tuple[int, ...]
    base: int = 0
    depth: bool = False

    @classmethod
    def of(cls, frame: StoredFrame, *, depth: bool = False) -> FrameTable:
        """Return the table of a stored frame, or of its ``depth`` image if it has one.

        An octree has two levels: its root and all other chunks.
        """
        table = frame.chunk_table
        ends, base = (table["offset"] + table["nbytes"]).astype(np.int64), 0
        image = frame.depth_ends
        if depth and image is not None:
            ends, base = image, int(ends[-1])
        counts = table["count"].astype(np.int64)
        levels = table["level"]
        stops = np.flatnonzero(np.append(levels[1:] != levels[:-1], len(levels) > 0)) + 1
        points = np.cumsum(counts)
        return cls(
            stops=tuple(stops.tolist()),
            nbytes=tuple((ends[stops - 1] - base).tolist()),
            points=tuple(points[stops - 1].tolist()),
            ends=tuple(ends.tolist()),
            firsts=(*table["first"].astype(np.int64).tolist(), frame.count),
            base=base,
            depth=base > 0,
        )

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return len(self.ends)

    def spans(self, chunks: Collection[int]) -> list[tuple[int, int]]:
        """Return first point and end of each run of consecutive ``chunks``, in order."""
        numbers = np.unique(np.fromiter(chunks, np.int64, len(chunks)))
        runs = np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1)
        return [(self.firsts[run[0]], self.firsts[run[-1] + 1]) for run in runs if len(run)]

    def start(self, chunk: int) -> int:
        """Return the offset of a chunk in the wire file."""
        return self.ends[chunk - 1] if chunk else self.base

    def size(self, first: int, stop: int) -> int:
        """Return the number of bytes of chunks [first, stop)."""
        return self.start(stop) - self.start(first)

    def level_within(self, nbytes: float, points: float) -> int:
        """Return the finest level with a prefix that fits, or 0 if none fits."""
        by_bytes = bisect_right(self.nbytes, nbytes)
        by_points = bisect_right(self.points, points)
        return max(0, min(by_bytes, by_points) - 1)

    def stop_within(self, first: int, stop: int, nbytes: int) -> int:
        """Return the end of the longest run in [first, stop) within ``nbytes``, or of one chunk."""
        fits = bisect_right(self.ends, self.start(first) + nbytes)
        return max(first + 1, min(stop, fits)) if first < stop else stop

    def first_piece(self, frame: int, level: int) -> Piece:
        """Choose the first piece to send of the table's frame ``frame``, up to a level."""
        stop = self.stop_within(0, self.stops[min(level, len(self.stops) - 1)], LARGEST_PIECE)
        return Piece(frame, 0, stop, final=stop == self.chunks, depth=self.depth)
