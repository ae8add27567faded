"""Plan of the points that a viewer gets next: the newest due frame first, then what comes soon.

Pure decisions, no input or output: times come in, pieces go out.  ``PlayClock`` says which frame
is due.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from pointbrush.streaming.load import Load
from pointbrush.streaming.rate import SHARE, UNLIMITED, Link, Pace, PageBudget
from pointbrush.streaming.table import LARGEST_PIECE, FrameTable, Piece

MOST_PER_SECOND = 60.0
"""Faster playback shows every second, third … frame: no display shows more."""
LOOKAHEAD = 0.25
"""Seconds of frames sent before they are due."""
AHEAD = 4
"""Frames behind the one that is sent now whose messages are made."""
REFINE_SECONDS = 0.05
"""A refinement's message is cut to about this time on the link, so that a seek can overtake."""
AT_ONCE_SECONDS = 0.012
"""A frame that takes less than this on the link is not split: nobody would see its first part."""
SMALLEST_REFINEMENT = 64 * 1024
PREFETCH_AHEAD, PREFETCH_BEHIND = 4, 1
BUSY_PAUSE = 0.1
UP_PERIOD = 0.15
"""Seconds between two steps up by one level; steps down are at once."""


@dataclass(frozen=True, slots=True)
class PlayClock:
    """Frames due over time: ``start`` at time ``since``, ``rate`` frames a second (signed)."""

    start: int
    since: float
    rate: float
    frames: int
    loop: bool = True
    stride: int = field(init=False)
    """Frames between two that are shown, signed like the direction."""
    shown_per_second: float = field(init=False)
    """Different frames shown a second."""

    def __post_init__(self) -> None:
        step = max(1, math.ceil(abs(self.rate) / MOST_PER_SECOND - 1e-9))
        object.__setattr__(self, "stride", step if self.rate >= 0 else -step)
        object.__setattr__(self, "shown_per_second", abs(self.rate) / step)

    def steps(self, now: float) -> int:
        """Shown frames passed since the start."""
        return max(0, math.floor((now - self.since) * self.shown_per_second + 1e-9))

    def frame(self, step: int) -> int:
        """The frame of a step, wrapped when looping, else held at the end."""
        index = self.start + step * self.stride
        return index % self.frames if self.loop else min(max(index, 0), self.frames - 1)

    def due(self, now: float) -> int:
        """The frame that should be seen now."""
        return self.frame(self.steps(now))

    def next_change(self, now: float) -> float:
        """Seconds until another frame is due; infinity when none will be."""
        if self.rate == 0 or (not self.loop and self.ended(now)):
            return math.inf
        return max(0.0, self.since + (self.steps(now) + 1) / self.shown_per_second - now)

    def ended(self, now: float) -> bool:
        """Not looping, and at the last frame of the direction."""
        last = self.frames - 1 if self.rate >= 0 else 0
        return not self.loop and self.due(now) == last

    def ahead(self, now: float, seconds: float, first: int = 0) -> Iterator[tuple[int, int]]:
        """Step and frame due now, and of those due within ``seconds``, in order of time.

        Steps before ``first`` are left out.
        """
        last = self.steps(now + seconds) if self.rate else 0
        for step in range(max(first, min(self.steps(now), last)), last + 1):
            yield step, self.frame(step)

    def time_of(self, step: int) -> float:
        """Moment at which a step is due."""
        return self.since + step / self.shown_per_second if self.rate else self.since


@dataclass(slots=True)
class Plan:
    """One viewer's place in a sequence and what it holds.

    ``held[frame]``: chunks from the first on that were sent and not forgotten.
    ``chunks[frame]``: of large frames, the chunks that were sent in any order; where a viewer came
    back with a frame, nobody knows them, and there is no entry.
    """

    frames: int
    link: Link
    load: Load = field(default_factory=Load)
    """Bounds on what the server has time for."""
    page: PageBudget = field(default_factory=PageBudget)
    focus: int = 0
    around: tuple[int, ...] = ()
    """Frames that are shown with the focus while time stands."""
    clock: PlayClock | None = None
    direction: int = 1
    held: dict[int, int] = field(default_factory=dict)
    chunks: dict[int, set[int]] = field(default_factory=dict)
    damaged: set[int] = field(default_factory=set)
    """Frames that cannot be read; the viewer has been told.  Sought again, they are tried again."""
    pace: Pace = field(default_factory=Pace)
    shown_points: int = 0
    _step: int = -1
    _had: int = 0
    _goal: int = 0
    _level: int = 0
    _level_time: float = float("-inf")

    def seek(self, frame: int, around: Sequence[int] = ()) -> None:
        """Show one frame, with those ``around`` laid over it."""
        self.direction = 1 if frame >= self.focus else -1
        self.focus, self.around, self.clock = frame, tuple(around), None
        self.damaged.discard(frame)

    def play(self, clock: PlayClock) -> None:
        """Follow a clock."""
        self.clock, self.direction = clock, 1 if clock.rate >= 0 else -1
        self._level, self._level_time = 0, clock.since
        self._step, self._had = -1, 0

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
            self.chunks.pop(frame, None)

    def sent(self, piece: Piece, now: float) -> int:
        """Note that a piece is on its way; return how many frames were skipped before it."""
        self.held[piece.frame] = max(self.held.get(piece.frame, 0), piece.stop)
        if self.clock is None or piece.step <= self._step:
            return 0
        lead = (self.clock.time_of(piece.step) - now) / LOOKAHEAD
        skipped = piece.step - self._step - 1 - self._had
        self.pace.left(skipped, lead, now)
        self._step, self._had = piece.step, 0
        return max(0, skipped)

    def coming(self, piece: Piece) -> list[int]:
        """Frames that will be wanted soon after a piece that is sent now."""
        if self.clock is None:
            return []
        first = 1 if piece.step == 0 else AHEAD
        return [self.clock.frame(piece.step + more) for more in range(first, AHEAD + 1)]

    @property
    def level(self) -> int:
        """Return the level of frames while a clock is followed."""
        return self._level

    def unsent(self, piece: Piece, held: int | None) -> None:
        """A piece was not sent after all; ``held``: what was held of its frame before."""
        if held is None:
            self.held.pop(piece.frame, None)
        else:
            self.held[piece.frame] = held

    def passed(self, step: int) -> None:
        """A step needs nothing: the viewer holds its frame."""
        if step > self._step + self._had:
            self._had += 1

    def candidates(self, now: float) -> Iterator[tuple[int, int]]:
        """Step of the clock (0 while paused) and frame to look at, most urgent first."""
        if self.clock is not None:
            # What was sent or found there in this round need not be looked at again.
            yield from self.clock.ahead(now, LOOKAHEAD, max(0, self._step + self._had))
            return
        yield 0, self.focus
        for frame in self.around:
            yield 0, frame
        if self.load.strained:
            return
        for distance in range(1, PREFETCH_AHEAD + 1):
            yield 0, self._neighbour(distance)
        for distance in range(1, PREFETCH_BEHIND + 1):
            yield 0, self._neighbour(-distance)

    def _neighbour(self, distance: int) -> int:
        return (self.focus + self.direction * distance) % self.frames

    def piece(self, step: int, frame: int, table: FrameTable, now: float) -> Piece | None:
        """Choose a candidate's piece to send now, or None: complete, or as fine as it may be."""
        first = self.held.get(frame, 0)
        if first >= table.chunks:
            self.passed(step)
            return None
        if self.clock is not None and step <= self._step:
            # Of this round already: only what its message could not hold is still to come.
            stop = self._goal if step == self._step else 0
        else:
            stop = self._goal = self._allowed(table, now)
        if first >= stop:
            self.passed(step)
            return None
        if self.clock is None:
            stop = self._refinement(table, first, stop)
        stop = table.stop_within(first, stop, LARGEST_PIECE)
        final = stop == table.chunks
        return Piece(frame, first, stop, final=final, step=step, depth=table.depth)

    def _refinement(self, table: FrameTable, first: int, stop: int) -> int:
        if first == 0 and table.size(0, stop) > self.link.rate * AT_ONCE_SECONDS:
            return min(stop, table.stops[0])
        share = max(SMALLEST_REFINEMENT, int(self.link.rate * REFINE_SECONDS))
        return table.stop_within(first, stop, share)

    def _allowed(self, table: FrameTable, now: float) -> int:
        """Chunks that a frame may have at most."""
        if self.clock is None:
            return table.stops[table.level_within(UNLIMITED, self.page.asked)]
        share = min(SHARE * self.link.rate * self.pace.ease, self.load.each)
        share /= max(self.clock.shown_per_second, 1.0)
        level = table.level_within(share, self.page.limit)
        if level > self._level:
            level = self._level + (now - self._level_time >= UP_PERIOD)
        if level != self._level:
            self._level, self._level_time = level, now
        self.shown_points = table.points[level]
        return table.stops[level]

    def wait(self, now: float) -> float | None:
        """Seconds until there may be something new to send by itself, or None: never."""
        if self.clock is None or self.clock.rate == 0:
            return BUSY_PAUSE if self.load.strained else None
        return min(1.0, self.clock.next_change(now + LOOKAHEAD))
