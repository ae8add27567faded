"""Cache of encoded messages that several viewers need, within a budget of bytes."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Hashable

from pointbrush.cache import Cache

Versioned = tuple[int, bytes]
"""The revision of a message, and its bytes."""
ENTRY_BYTES = 512
"""Memory of an entry in addition to its message, mostly for its key."""


class MessageCache:
    """LRU cache of bytes by key; concurrent calls for a key share one task."""

    def __init__(self, budget: int) -> None:
        self._entries: Cache[Hashable, Versioned] = Cache(budget)
        self._making: dict[Hashable, asyncio.Task[Versioned]] = {}

    def known(self, key: Hashable, least: int = 0) -> Versioned | None:
        """Return the cached message of ``key`` of revision ``least`` or newer, or None."""
        found = self._entries.known(key)
        return None if found is None or found[0] < least else found

    async def get(
        self, key: Hashable, make: Callable[[], Awaitable[Versioned]], least: int = 0
    ) -> Versioned:
        """Return the message of ``key`` of revision ``least`` or newer; await ``make`` if needed.

        ``make`` runs in a separate task, so that cancelling one caller does not affect the others.
        """
        found = self.known(key, least)
        if found is not None:
            return found
        made = await self._join(key, make)
        # A task started by another caller may have read its data before the change.
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
            self._entries.put(key, made, ENTRY_BYTES + len(made[1]))
            return made
        finally:
            del self._making[key]
