"""A bell that one task waits for.  ``asyncio.wait_for`` makes a task each time, this does not."""

from __future__ import annotations

import asyncio


class Wake:
    """Rung from the event loop; remembers one ring while nobody waits."""

    def __init__(self) -> None:
        self._rung = self._points = False
        self._waiter: asyncio.Future[None] | None = None

    def set(self, *, points: bool = True) -> None:
        """Ring; ``points``: there may be points to send, and not messages alone."""
        self._rung = True
        self._points = self._points or points
        if self._waiter is not None and not self._waiter.done():
            self._waiter.set_result(None)

    def clear(self) -> bool:
        """Forget earlier rings; returns whether one was for points."""
        points = self._points
        self._rung = self._points = False
        return points

    async def wait(self, seconds: float | None) -> None:
        """Return at the next ring, or after ``seconds`` if given."""
        if self._rung:
            return
        loop = asyncio.get_running_loop()
        self._waiter = waiter = loop.create_future()
        timer = None if seconds is None else loop.call_later(seconds, self.set)
        try:
            await waiter
        finally:
            self._waiter = None
            if timer is not None:
                timer.cancel()
