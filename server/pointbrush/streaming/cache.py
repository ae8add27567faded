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
        self._making: dict[Hashable, asyncio.Task[Versioned]] = {}
        self.nbytes = 0

    async def get(self, key: Hashable, make: Callable[[], Awaitable[Versioned]]) -> Versioned:
        """The bytes of ``key``; ``make`` is awaited when they are not here.

        It runs in a task of its own: an asker that goes away takes nothing from the others.
        """
        if key in self._entries:
            self._entries.move_to_end(key)
            return self._entries[key]
        task = self._making.get(key)
        if task is None:
            task = asyncio.create_task(self._make(key, make))
            self._making[key] = task
        return await asyncio.shield(task)

    async def _make(self, key: Hashable, make: Callable[[], Awaitable[Versioned]]) -> Versioned:
        mine = asyncio.current_task()
        try:
            made = await make()
            if self._making.get(key) is mine:
                self._put(key, made)
            return made
        finally:
            if self._making.get(key) is mine:
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
