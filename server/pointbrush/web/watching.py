"""Calls that wait for events of a recording."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import TypeVar

from fastapi.concurrency import run_in_threadpool

from pointbrush.database.job import Job
from pointbrush.labels import Commit
from pointbrush.work.events import Event
from pointbrush.workspace import Workspace

T = TypeVar("T")


class Watching:
    """Wakes the calls that wait for a recording; ``_waiting``: their events by its id."""

    def __init__(self) -> None:
        self._waiting: dict[str, set[asyncio.Event]] = {}
        self._ending = False

    @asynccontextmanager
    async def running(self, workspace: Workspace) -> AsyncIterator[Watching]:
        """Listen to the workspace while the context is open."""
        loop = asyncio.get_running_loop()

        def forward(event: Event) -> None:
            if isinstance(event, Commit | Job) and event.sequence and not loop.is_closed():
                loop.call_soon_threadsafe(self._wake, event.sequence)

        unsubscribe = workspace.subscribe(forward)
        try:
            yield self
        finally:
            unsubscribe()

    def _wake(self, sequence: str) -> None:
        for signal in self._waiting.get(sequence, ()):
            signal.set()

    def end(self) -> None:
        """Wake every call, because the server ends."""
        self._ending = True
        for sequence in list(self._waiting):
            self._wake(sequence)

    async def until(self, sequence: str, look: Callable[[], tuple[T, bool]], seconds: float) -> T:
        """Wait until ``look``, called in a thread, finds news; return its findings.

        After ``seconds``, or when the server ends, return its last findings.
        """
        loop = asyncio.get_running_loop()
        deadline, signal = loop.time() + seconds, asyncio.Event()
        self._waiting.setdefault(sequence, set()).add(signal)
        try:
            while True:
                signal.clear()
                found, news = await run_in_threadpool(look)
                left = deadline - loop.time()
                if news or left <= 0 or self._ending:
                    return found
                try:
                    await asyncio.wait_for(signal.wait(), left)
                except TimeoutError:
                    return found
        finally:
            waiting = self._waiting[sequence]
            waiting.discard(signal)
            if not waiting:
                del self._waiting[sequence]
