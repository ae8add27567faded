"""Plan of the points that a viewer gets next: the newest due frame, then the frames after it.

The plan only decides, without input or output: it takes times and the levels of open frames, and
returns pieces.  ``PlayClock`` returns the frame that is due.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from pointbrush.streaming.load import Load
from pointbrush.streaming.rate import SHARE, UNLIMITED, Link, Pace, PageBudget
from pointbrush.streaming.table import LARGEST_PIECE, FrameTable, Piece

MOST_PER_SECOND = 60.0
"""Displays show at most this rate; faster playback shows every second, third … frame."""
LOOKAHEAD = 0.25
"""Seconds of frames sent before they are due."""
AHEAD = 4
"""Number of frames after the current one of which messages are prepared."""
REFINE_SECONDS = 0.05
"""A refinement's message takes about this time on the link, so that a seek can overtake it."""
AT_ONCE_SECONDS = 0.012
"""A frame that takes less than this on the link is not split: its first part is not visible."""
SMALLEST_REFINEMENT = 64 * 1024
LARGE_PIECE = 512 * 1024
"""Bytes of one message of chunks of a large frame."""
PREFETCH_AHEAD, PREFETCH_BEHIND = 4, 1
BUSY_PAUSE = 0.1
UP_PERIOD = 0.15
"""Seconds between two steps up by one level; steps down are immediate."""

Known: TypeAlias = Callable[[int], FrameTable | None]
"""Returns the levels of a frame that is open, and None for another one."""


@dataclass(frozen=True, slots=True)
class PlayClock:
    """Frames due over time: ``start`` at time ``since``, ``rate`` frames a second (signed)."""

    start: int
    since: float
    rate: float
    frames: int
    loop: bool = True
    stride: int = field(init=False)
    """Difference of two consecutive shown frames, signed like the direction."""
    shown_per_second: float = field(init=False)
    """Different frames shown a second."""

    def __post_init__(self) -> None:
        step = max(1, math.ceil(abs(self.rate) / MOST_PER_SECOND - 1e-9))
        object.__setattr__(self, "stride", step if self.rate >= 0 else -step)
        object.__setattr__(self, "shown_per_second", abs(self.rate) / step)

    def steps(self, now: float) -> int:
        """Return the number of shown frames since the start."""
        return max(0, math.floor((now - self.since) * self.shown_per_second + 1e-9))

    def frame(self, step: int) -> int:
        """Return the frame of a step: wrapped if the clock loops, else held at the end."""
        index = self.start + step * self.stride
        return index % self.frames if self.loop else min(max(index, 0), self.frames - 1)

    def due(self, now: float) -> int:
        """Return the frame that should be visible now."""
        return self.frame(self.steps(now))

    def next_change(self, now: float) -> float:
        """Return the seconds until another frame is due, or infinity if none will be."""
        if self.rate == 0 or (not self.loop and self.ended(now)):
            return math.inf
        return max(0.0, self.since + (self.steps(now) + 1) / self.shown_per_second - now)

    def ended(self, now: float) -> bool:
        """Return whether a clock without loop has reached the last frame of its direction."""
        last = self.frames - 1 if self.rate >= 0 else 0
        return not self.loop and self.due(now) == last

    def ahead(self, now: float, seconds: float, first: int = 0) -> Iterator[tuple[int, int]]:
        """Return step and frame of each frame due within ``seconds``, from the current one on.

        Steps before ``first`` are left out.
        """
        last = self.steps(now + seconds) if self.rate else 0
        for step in range(max(first, min(self.steps(now), last)), last + 1):
            yield step, self.frame(step)

    def time_of(self, step: int) -> float:
        """Return the time at which a step is due."""
        return self.since + step / self.shown_per_second if self.rate else self.since


@dataclass(frozen=True, slots=True)
class Unopened:
    """A frame that has to be opened before a piece can be chosen."""

    frame: int


@dataclass(slots=True)
class Plan:
    """One viewer's place in a sequence and the chunks that it has.

    ``held[frame]``: number of chunks, from the first on, that were sent and not forgotten.
    ``chunks[frame]``: chunks of a large frame, which are sent in any order; there is no entry for
    a frame that a resuming viewer brought, because its chunks are unknown.
    """

    frames: int
    link: Link
    load: Load = field(default_factory=Load)
    """Load of the server, which bounds the points to send."""
    page: PageBudget = field(default_factory=PageBudget)
    focus: int = 0
    around: tuple[int, ...] = ()
    """Frames that are shown with the focus while the clock is stopped."""
    clock: PlayClock | None = None
    direction: int = 1
    held: dict[int, int] = field(default_factory=dict)
    chunks: dict[int, set[int]] = field(default_factory=dict)
    damaged: set[int] = field(default_factory=set)
    """Frames that cannot be read and were reported to the viewer; a seek tries them again."""
    large: bool = False
    """Frames are octrees of chunks; the viewer requests the chunks that it needs."""
    wanted: tuple[int, list[int]] = field(default_factory=lambda: (0, []))
    """A frame of a large sequence and its requested chunks, in order of urgency."""
    pace: Pace = field(default_factory=Pace)
    shown_points: int = 0
    _step: int = -1
    _had: int = 0
    _goal: int = 0
    _level: int = 0
    _level_time: float = float("-inf")

    def seek(self, frame: int, around: Sequence[int] = ()) -> None:
        """Show one frame, overlaid with the frames ``around`` it."""
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
        """Remove frames that the viewer has dropped."""
        for frame in frames:
            self.held.pop(frame, None)
            self.chunks.pop(frame, None)

    def sent(self, piece: Piece, now: float) -> int:
        """Record a piece that is being sent; return the number of frames skipped before it."""
        self.held[piece.frame] = max(self.held.get(piece.frame, 0), piece.stop)
        if self.clock is None or piece.step <= self._step:
            return 0
        lead = (self.clock.time_of(piece.step) - now) / LOOKAHEAD
        skipped = piece.step - self._step - 1 - self._had
        self.pace.left(skipped, lead, now)
        self._step, self._had = piece.step, 0
        return max(0, skipped)

    def sending(self, piece: Piece, *, anew: bool) -> None:
        """Record the chunks of a large frame that are being sent; ``anew``: the first ones."""
        if not self.large:
            return
        sent = set(range(piece.first, piece.stop))
        if anew:
            self.chunks[piece.frame] = set()
        if piece.frame in self.chunks:
            self.chunks[piece.frame] |= sent
        frame, chunks = self.wanted
        if frame == piece.frame:
            chunks[:] = [chunk for chunk in chunks if chunk not in sent]

    def coming(self, piece: Piece) -> list[int]:
        """Return the frames to prepare after a piece that is being sent."""
        if self.clock is None:
            return []
        first = 1 if piece.step == 0 else AHEAD
        return [self.clock.frame(piece.step + more) for more in range(first, AHEAD + 1)]

    @property
    def level(self) -> int:
        """Return the level of frames while a clock is followed."""
        return self._level

    def unsent(self, piece: Piece, held: int | None) -> None:
        """Take a piece back that was not sent; ``held``: chunks held of its frame before."""
        if held is None:
            self.held.pop(piece.frame, None)
        else:
            self.held[piece.frame] = held

    def passed(self, step: int) -> None:
        """Pass a step for which the viewer has its frame already."""
        if step > self._step + self._had:
            self._had += 1

    def next(self, now: float, known: Known) -> Piece | Unopened | None:
        """Choose the next piece to send, or the frame to open for that; None: nothing to send."""
        if self.large:
            return self._next_chunks(now, known)
        for step, frame in self.candidates(now):
            if frame in self.damaged:
                self.passed(step)
                continue
            table = known(frame)
            if table is None:
                return Unopened(frame)
            piece = self.piece(step, frame, table, now)
            if piece is not None:
                return piece
        return None

    def _next_chunks(self, now: float, known: Known) -> Piece | Unopened | None:
        """Return the root of the shown frame first, then runs of requested chunks."""
        frame = self.focus if self.clock is None else self.clock.due(now)
        root = frame not in self.held
        frame, chunks = (frame, [0]) if root else self.wanted
        if not chunks or frame in self.damaged:
            return None
        table = known(frame)
        if table is None:
            return Unopened(frame)
        if root:
            return Piece(frame, 0, table.stops[0], final=table.chunks == table.stops[0])
        while chunks and chunks[0] >= table.chunks:
            chunks.pop(0)
        return _run_of(frame, chunks, table) if chunks else None

    def candidates(self, now: float) -> Iterator[tuple[int, int]]:
        """Return step of the clock (0 while paused) and frame of candidates, most urgent first."""
        if self.clock is not None:
            # Skip the steps that this round of playback has sent or passed.
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
        """Choose a candidate's piece to send; None: the frame is complete, or at its limit."""
        first = self.held.get(frame, 0)
        if first >= table.chunks:
            self.passed(step)
            return None
        if self.clock is not None and step <= self._step:
            # This round has sent the frame: only the chunks beyond the first message remain.
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
        """Return the largest number of chunks that a frame may have now."""
        if self.clock is None:
            return table.stops[table.level_within(UNLIMITED, self.page.requested_points)]
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
        """Return the seconds until another piece may be due without an event, or None: never."""
        if self.clock is None or self.clock.rate == 0:
            return BUSY_PAUSE if self.load.strained else None
        return min(1.0, self.clock.next_change(now + LOOKAHEAD))


def _run_of(frame: int, chunks: Sequence[int], table: FrameTable) -> Piece:
    """Return the longest run of requested chunks from the first one on, within LARGE_PIECE."""
    first = chunks[0]
    stop = first + 1
    while stop in chunks[: stop - first + 1] and table.size(first, stop + 1) <= LARGE_PIECE:
        stop += 1
    return Piece(frame, first, stop, final=False)
