"""Encoded messages that several viewers need, under a budget of bytes; each is made once."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Awaitable, Callable, Hashable

Versioned = tuple[int, bytes]
"""A message, and the revision it is of."""
ENTRY_BYTES = 512
"""Bytes of memory of an entry beside its message: its key above all."""


class MessageCache:
    """Least recently used bytes by key; concurrent askers share one making."""

    def __init__(self, budget: int) -> None:
        self._budget = budget
        self._entries: OrderedDict[Hashable, Versioned] = OrderedDict()
        self._making: dict[Hashable, asyncio.Task[Versioned]] = {}
        self.nbytes = 0

    def known(self, key: Hashable, least: int = 0) -> Versioned | None:
        """The bytes of ``key``, of revision ``least`` or newer, if they are here."""
        found = self._entries.get(key)
        if found is None or found[0] < least:
            return None
        self._entries.move_to_end(key)
        return found

    async def get(
        self, key: Hashable, make: Callable[[], Awaitable[Versioned]], least: int = 0
    ) -> Versioned:
        """The bytes of ``key``, of revision ``least`` or newer; ``make`` is awaited if need be.

        It runs in a task of its own: an asker that goes away takes nothing from the others.
        """
        found = self.known(key, least)
        if found is not None:
            return found
        made = await self._join(key, make)
        # What others had begun to make may have been read before the change.
        return made if made[0] >= least else await self._join(key, make)

    async def _join(self, key: Hashable, make: Callable[[], Awaitable[Versioned]]) -> Versioned:
        task = self._making.get(key)
        if task is None:
            task = asyncio.create_task(self._make(key, make))
            self._making[key] = task
        return await asyncio.shield(task)

    async def _make(self, key: Hashable, make: Callable[[], Awaitable[Versioned]]) -> Versioned:
        try:
            made = await make()
            self._put(key, made)
            return made
        finally:
            del self._making[key]

    def _put(self, key: Hashable, made: Versioned) -> None:
        old = self._entries.pop(key, None)
        self._entries[key] = made
        self.nbytes += cost(made) - (0 if old is None else cost(old))
        while self.nbytes > self._budget:
            self.nbytes -= cost(self._entries.popitem(last=False)[1])


def cost(made: Versioned) -> int:
    """Bytes of memory of a message that is kept."""
    return ENTRY_BYTES + len(made[1])
