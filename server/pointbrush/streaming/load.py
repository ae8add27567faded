"""Load of the event loop: when it is busy, viewers get fewer points, so strokes stay quick."""

from __future__ import annotations

import asyncio
import math
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager

PERIOD = 0.05
LATE, EARLY = 0.012, 0.004
"""Seconds of lag above which there is too much to do, and below which there may be more."""
BUSY, IDLE = 0.6, 0.45
"""The same for the share of the time that the loop computes: strokes need the rest."""
SENDS_A_TURN = 6
YIELD_SECONDS, YIELDS = 0.001, 8
"""Longest wait of points for an edit that is being applied: a flood must not stop them."""
FIRST, LEAST = 300e6, 25e6
"""Bytes a second for all who follow a clock together: before anything is known, and at least."""
CUT, GROW = 0.85, 1.05
MOST_CUTS = 4
"""Cuts at once: as many as the lag is times too long."""
CALM_SECONDS = 0.1
BEHIND = 32
"""Edits that wait from which on only what must be answered is."""


class Load:
    """Watches the loop it runs on, and shares out what it can send among those who follow a clock.

    A budget in bytes, and not a share of what links carry: when a hundred begin to play in one
    moment, each link looks as wide as the machine's memory, and nobody knows better for a second.
    """

    def __init__(self, most_waiting: float = math.inf) -> None:
        """``most_waiting``: edits of all viewers that wait, until no further strokes are begun."""
        self.most_waiting = most_waiting
        self.each = math.inf
        """Bytes a second that one viewer who follows a clock may be sent."""
        self._budget = FIRST
        self._calm = math.inf
        self._left = SENDS_A_TURN
        self._waiting: deque[asyncio.Future[None]] = deque()
        self._due = False
        self._yielded = 0
        self._edits = 0
        self.waiting = 0
        """Edits that viewers have sent and that are not applied yet."""

    @property
    def strained(self) -> bool:
        """Whether there was too much to do just now: nothing is sent that may never be seen."""
        return self._calm < CALM_SECONDS

    @property
    def behind(self) -> bool:
        """Return whether edits wait for others' edits."""
        return self.waiting >= BEHIND

    @property
    def overloaded(self) -> bool:
        """Return whether no further strokes can be begun now."""
        return self.waiting >= self.most_waiting

    @contextmanager
    def edit(self) -> Iterator[None]:
        """While an edit is applied in a thread: it has Python's lock almost to itself."""
        self._edits += 1
        try:
            yield
        finally:
            self._edits -= 1

    async def turn(self) -> None:
        """Wait for a turn to send points: few in each turn of the loop.

        A send that fits the socket's buffer returns at once; a hundred of them in one turn would
        keep every stroke waiting at each of its steps.
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
        """Let those go on who have waited longest, unless an edit is being applied."""
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
        # Where nobody follows, a busy loop only means that somebody gets what is asked for.
        if lag > LATE or (busy > BUSY and followers):
            self._calm = 0.0
            self._budget = max(LEAST, self._budget * CUT ** min(MOST_CUTS, max(1.0, lag / LATE)))
        elif lag < EARLY and busy < IDLE:
            self._calm += PERIOD
            # What nobody asks for says nothing about what could be sent.
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
