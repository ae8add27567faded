"""Encoded messages that several viewers need, under a budget of bytes; each is made once."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Awaitable, Callable, Hashable


Versioned = tuple[int, bytes]
"""A message, and the revision it is of (0 for what never changes)."""


class MessageCache:
    """Least recently used bytes by key; concurrent askers share one making."""

    def __init__(self, budget: int) -> None:
        self._budget = budget
        self._entries: OrderedDict[Hashable, Versioned] = OrderedDict()
        self._making: dict[Hashable, asyncio.Future[Versioned]] = {}
        self.nbytes = 0

    async def get(self, key: Hashable, make: Callable[[], Awaitable[Versioned]]) -> Versioned:
        """The bytes of ``key``; ``make`` is awaited when they are not here."""
        if key in self._entries:
            self._entries.move_to_end(key)
            return self._entries[key]
        if key in self._making:
            return await asyncio.shield(self._making[key])
        future: asyncio.Future[Versioned] = asyncio.get_running_loop().create_future()
        # A failure is for whoever made it; nobody else may be waiting.
        future.add_done_callback(lambda done: done.cancelled() or done.exception())
        self._making[key] = future
        try:
            data = await make()
        except BaseException as error:
            if isinstance(error, asyncio.CancelledError):
                future.cancel()
            else:
                future.set_exception(error)
            raise
        else:
            future.set_result(data)
            if self._making.get(key) is future:
                self._put(key, data)
            return data
        finally:
            if self._making.get(key) is future:
                del self._making[key]

    def _put(self, key: Hashable, data: Versioned) -> None:
        self._entries[key] = data
        self.nbytes += len(data[1])
        while self.nbytes > self._budget:
            self.nbytes -= len(self._entries.popitem(last=False)[1][1])

    def drop(self, matches: Callable[[Hashable], bool]) -> None:
        """Forget entries, also those being made just now."""
        for key in [key for key in self._entries if matches(key)]:
            self.nbytes -= len(self._entries.pop(key)[1])
        for key in [key for key in self._making if matches(key)]:
            del self._making[key]
