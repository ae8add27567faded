"""How busy the event loop is: when it is, every viewer gets fewer points, so strokes stay quick."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager

PERIOD = 0.05
LATE, EARLY = 0.012, 0.004
"""Seconds of lag above which there is too much to do, and below which there may be more."""
BUSY, IDLE = 0.6, 0.45
"""The same for the share of the time that the loop computes: strokes need the rest."""
SENDS_A_TURN = 6
YIELD_SECONDS, YIELDS = 0.001, 8
"""How long points wait at most for an edit that is being applied: a flood must not stop them."""
CUT, GROW, LEAST = 0.85, 1.05, 0.02


class Load:
    """Watches the loop it runs on."""

    def __init__(self) -> None:
        self._share = 1.0
        self._left = SENDS_A_TURN
        self._waiting: deque[asyncio.Future[None]] = deque()
        self._due = False
        self._yielded = 0
        self._edits = 0

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

    def share(self) -> float:
        """Share 0..1 of what its link carries that a viewer should be sent."""
        return self._share

    def note(self, lag: float, busy: float) -> None:
        """The loop came back ``lag`` seconds late, and computed a share ``busy`` of the time."""
        if lag > LATE or busy > BUSY:
            self._share = max(LEAST, self._share * CUT)
        elif lag < EARLY and busy < IDLE:
            self._share = min(1.0, self._share * GROW)

    async def watch(self) -> None:
        """Measure until cancelled."""
        loop = asyncio.get_running_loop()
        while True:
            before, computed = loop.time(), time.thread_time()
            await asyncio.sleep(PERIOD)
            passed = loop.time() - before
            self.note(passed - PERIOD, (time.thread_time() - computed) / passed)
