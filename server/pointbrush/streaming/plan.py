"""Which points a viewer should get next: the newest due frame first, then what comes soon.

Pure decisions, no input or output: times come in, pieces go out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from pointbrush.streaming.clock import PlayClock
from pointbrush.streaming.rate import SHARE, UNLIMITED, Link, PageBudget
from pointbrush.streaming.table import FrameTable

LOOKAHEAD = 0.25
"""Seconds of frames sent before they are due."""
LARGEST_PIECE = 2 * 2**20
REFINE_SECONDS = 0.05
"""A refinement's message is cut to about this time on the link, so that a seek can overtake."""
AT_ONCE_SECONDS = 0.012
"""A frame that takes less than this on the link is not split: nobody would see its first part."""
SMALLEST_REFINEMENT = 64 * 1024
PREFETCH_AHEAD, PREFETCH_BEHIND = 4, 1
UP_PERIOD = 0.3
"""Seconds between two steps up in level; steps down are at once."""


@dataclass(frozen=True, slots=True)
class Piece:
    """Chunks [first, stop) of a frame; ``final`` completes it at the viewer."""

    frame: int
    first: int
    stop: int
    final: bool


@dataclass(slots=True)
class Plan:
    """One viewer's place in a sequence and what it holds.

    ``held[frame]``: chunks from the first on that were sent and not forgotten.
    """

    frames: int
    link: Link
    page: PageBudget = field(default_factory=PageBudget)
    focus: int = 0
    clock: PlayClock | None = None
    direction: int = 1
    held: dict[int, int] = field(default_factory=dict)
    shown_points: int = 0
    _level: int = 0
    _level_time: float = float("-inf")

    def seek(self, frame: int) -> None:
        """Show one frame; playing goes on from there if it was."""
        self.direction = 1 if frame >= self.focus else -1
        self.focus, self.clock = frame, None

    def play(self, clock: PlayClock) -> None:
        """Follow a clock."""
        self.clock, self.direction = clock, 1 if clock.rate >= 0 else -1
        self._level, self._level_time = 0, float("-inf")

    def pause(self, frame: int | None, now: float) -> None:
        """Stop the clock at ``frame``, or where it is."""
        if self.clock is not None and frame is None:
            self.focus = self.clock.due(now)
        elif frame is not None:
            self.focus = frame
        self.clock = None

    def forget(self, frames: list[int]) -> None:
        """The viewer dropped these."""
        for frame in frames:
            self.held.pop(frame, None)

    def sent(self, piece: Piece) -> None:
        """A piece is on its way."""
        self.held[piece.frame] = max(self.held.get(piece.frame, 0), piece.stop)

    def candidates(self, now: float) -> Iterator[int]:
        """Frames to look at, most urgent first."""
        if self.clock is not None:
            yield from self.clock.ahead(now, LOOKAHEAD)
            return
        yield self.focus
        for distance in range(1, PREFETCH_AHEAD + 1):
            yield self._neighbour(distance)
        for distance in range(1, PREFETCH_BEHIND + 1):
            yield self._neighbour(-distance)

    def _neighbour(self, distance: int) -> int:
        return (self.focus + self.direction * distance) % self.frames

    def piece(self, frame: int, table: FrameTable, now: float) -> Piece | None:
        """What to send of a candidate now, or None: complete, or as fine as it may be."""
        first = self.held.get(frame, 0)
        stop = self._allowed(table, now)
        if first >= stop:
            return None
        if self.clock is None:
            stop = self._refinement(table, first, stop)
        stop = table.stop_within(first, stop, LARGEST_PIECE)
        return Piece(frame, first, stop, final=stop == table.chunks)

    def _refinement(self, table: FrameTable, first: int, stop: int) -> int:
        if first == 0 and table.size(0, stop) > self.link.rate * AT_ONCE_SECONDS:
            return min(stop, table.stops[0])
        share = max(SMALLEST_REFINEMENT, int(self.link.rate * REFINE_SECONDS))
        return table.stop_within(first, stop, share)

    def _allowed(self, table: FrameTable, now: float) -> int:
        """Chunks that a frame may have at most."""
        if self.clock is None:
            return table.stops[table.level_within(UNLIMITED, self.page.asked)]
        share = SHARE * self.link.rate / max(self.clock.shown_per_second, 1.0)
        level = table.level_within(share, self.page.limit)
        if level > self._level and now - self._level_time < UP_PERIOD:
            level = self._level
        if level != self._level:
            self._level, self._level_time = level, now
        self.shown_points = table.points[level]
        return table.stops[level]

    def wait(self, now: float) -> float | None:
        """Seconds until the clock brings something new, or None while paused."""
        if self.clock is None or self.clock.rate == 0:
            return None
        return min(1.0, self.clock.next_change(now + LOOKAHEAD))
