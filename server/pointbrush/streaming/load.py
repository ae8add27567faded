"""Load of the event loop: when it is busy, viewers get fewer points, so that strokes stay fast."""

from __future__ import annotations

import asyncio
import math
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager

PERIOD = 0.05
LATE, EARLY = 0.012, 0.004
"""Lag in seconds above which the server sends less, and below which it may send more."""
BUSY, IDLE = 0.6, 0.45
"""The same bounds for the loop's share of computing time; strokes need the rest."""
SENDS_A_TURN = 6
YIELD_SECONDS, YIELDS = 0.001, 8
"""Longest wait of points for an edit in progress; a flood of edits must not stop points."""
FIRST, LEAST = 300e6, 25e6
"""Total bytes a second of all playing viewers: before any measurement, and at least."""
CUT, GROW = 0.85, 1.05
MOST_CUTS = 4
"""Most cuts at once; the number of cuts is the lag divided by ``LATE``."""
CALM_SECONDS = 0.1
BEHIND = 32
"""Number of waiting edits from which on provisional answers are left out."""


class Load:
    """Measures its event loop, and divides the bytes that it can send among playing viewers.

    The budget is in bytes instead of a share of the links' rates: if a hundred viewers start to
    play at once, each link's estimate equals the machine's memory bandwidth for about a second.
    """

    def __init__(self, most_waiting: float = math.inf) -> None:
        """``most_waiting``: waiting edits of all viewers from which on new strokes are refused."""
        self.most_waiting = most_waiting
        self.each = math.inf
        """Bytes a second that the server may send to one playing viewer."""
        self._budget = FIRST
        self._calm = math.inf
        self._left = SENDS_A_TURN
        self._waiting: deque[asyncio.Future[None]] = deque()
        self._due = False
        self._yielded = 0
        self._edits = 0
        self.waiting = 0
        """Edits that the server has received and not applied yet."""

    @property
    def strained(self) -> bool:
        """Return whether the load was too high just now; then no frames are sent ahead."""
        return self._calm < CALM_SECONDS

    @property
    def behind(self) -> bool:
        """Return whether so many edits wait that provisional answers are left out."""
        return self.waiting >= BEHIND

    @property
    def overloaded(self) -> bool:
        """Return whether the server refuses new strokes."""
        return self.waiting >= self.most_waiting

    @contextmanager
    def edit(self) -> Iterator[None]:
        """Mark an edit in a thread; points wait for it, so that it rarely waits for the GIL."""
        self._edits += 1
        try:
            yield
        finally:
            self._edits -= 1

    async def turn(self) -> None:
        """Wait for a turn to send points; each iteration of the loop has few turns.

        A send that fits the socket's buffer does not yield; a hundred sends in one iteration would
        delay each step of every stroke.
        """
        loop = asyncio.get_running_loop()
        if not self._due:
            self._due = True
            loop.call_soon(self._next_turn)
        if self._left and not self._edits and not self._waiting:
            self._left -= 1
            return
        waiter = loop.create_future()
        self._waiting.append(waiter)
        await waiter

    def _next_turn(self) -> None:
        """Resume the viewers that have waited longest, unless an edit is being applied."""
        loop = asyncio.get_running_loop()
        if self._edits and self._yielded < YIELDS:
            self._yielded += 1
            loop.call_later(YIELD_SECONDS, self._next_turn)
            return
        self._yielded = 0
        self._left = SENDS_A_TURN
        while self._left and self._waiting:
            waiter = self._waiting.popleft()
            if not waiter.done():
                waiter.set_result(None)
                self._left -= 1
        self._due = self._left < SENDS_A_TURN
        if self._due:
            loop.call_soon(self._next_turn)

    def note(self, lag: float, busy: float, sent: float, followers: int) -> None:
        """Record the latest load.

        The loop came back ``lag`` seconds late, computed a share ``busy`` of the time, and sent
        ``sent`` bytes a second; ``followers`` viewers follow a clock.
        """
        # Without playing viewers, a busy loop only answers requests.
        if lag > LATE or (busy > BUSY and followers):
            self._calm = 0.0
            self._budget = max(LEAST, self._budget * CUT ** min(MOST_CUTS, max(1.0, lag / LATE)))
        elif lag < EARLY and busy < IDLE:
            self._calm += PERIOD
            # The budget only grows from a load that uses at least half of it.
            if self._budget < FIRST or sent > self._budget / 2:
                self._budget *= GROW
        self.each = self._budget / followers if followers else math.inf

    async def watch(self, sent: Callable[[], int], followers: Callable[[], int]) -> None:
        """Measure until cancelled; ``sent()``: bytes so far."""
        loop = asyncio.get_running_loop()
        while True:
            before, computed, carried = loop.time(), time.thread_time(), sent()
            await asyncio.sleep(PERIOD)
            passed = loop.time() - before
            busy = (time.thread_time() - computed) / passed
            self.note(passed - PERIOD, busy, (sent() - carried) / passed, followers())
