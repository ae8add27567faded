"""Readiness of the server, checked in separate threads so that it answers under any load."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Mapping

from pointbrush.errors import PointbrushError

ANSWER_SECONDS = 5.0
"""A part that takes longer to answer is not ready."""
FRESH_SECONDS = 1.0
"""Time for which an answer is reused, because calls need no token."""

Check = Callable[[], None]
"""Raises PointbrushError when its part cannot be used."""


class ReadyProbe:
    """Checks the parts that a workspace depends on."""

    def __init__(self, checks: Mapping[str, Check]) -> None:
        self._parts = {name: _Part(check) for name, check in checks.items()}
        self.stopping = False
        """The server takes no new work because it is about to end."""
        self._known: dict[str, str | None] = {}
        self._checked = float("-inf")
        self._check_lock = asyncio.Lock()

    async def find_faults(self) -> dict[str, str | None]:
        """Check each part: its fault, or None."""
        if self.stopping:
            return {"server": "it is stopping"}
        async with self._check_lock:
            if time.monotonic() - self._checked > FRESH_SECONDS:
                faults = await asyncio.gather(*(part.find_fault() for part in self._parts.values()))
                self._known = dict(zip(self._parts, faults, strict=True))
                self._checked = time.monotonic()
            return self._known


class _Part:
    """One check; a second call waits for a running one."""

    def __init__(self, check: Check) -> None:
        self._check = check
        self._running: asyncio.Future[str | None] | None = None

    async def find_fault(self) -> str | None:
        if self._running is None or self._running.done():
            loop = asyncio.get_running_loop()
            self._running = loop.create_future()
            # Not a pool's thread: a hanging one would keep the server from ending.
            arguments = (loop, self._running)
            threading.Thread(target=self._run, args=arguments, daemon=True).start()
        try:
            return await asyncio.wait_for(asyncio.shield(self._running), ANSWER_SECONDS)
        except TimeoutError:
            return f"no answer within {ANSWER_SECONDS:g} seconds"

    def _run(self, loop: asyncio.AbstractEventLoop, answer: asyncio.Future[str | None]) -> None:
        problem: str | None = None
        try:
            self._check()
        except PointbrushError as error:
            problem = str(error)
        except Exception as error:
            problem = f"failed unexpectedly ({type(error).__name__})"
        if not loop.is_closed():
            loop.call_soon_threadsafe(answer.set_result, problem)
