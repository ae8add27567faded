"""A least-recently-used cache bounded by the total size of its entries."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import Lock
from typing import Generic, TypeVar

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


class Cache(Generic[K, V]):
    """Thread-safe; at least the newest entry stays, however large it is."""

    def __init__(self, capacity: int) -> None:
        self._capacity = capacity
        self._entries: OrderedDict[K, tuple[V, int]] = OrderedDict()
        self._total = 0
        self._lock = Lock()

    def known(self, key: K) -> V | None:
        """The entry under ``key``, or None."""
        with self._lock:
            if key not in self._entries:
                return None
            self._entries.move_to_end(key)
            return self._entries[key][0]

    def held(self) -> list[K]:
        """The current keys, the least recently used first."""
        with self._lock:
            return list(self._entries)

    def drop(self, key: K) -> None:
        """Remove the entry under ``key`` if there is one."""
        with self._lock:
            _, freed = self._entries.pop(key, (None, 0))
            self._total -= freed

    def get(self, key: K, make: Callable[[], V], size: int) -> V:
        """Return the entry under ``key``; create it if it is absent.

        Two threads may make the same entry at once; both get the one that is kept.
        """
        with self._lock:
            if key in self._entries:
                self._entries.move_to_end(key)
                return self._entries[key][0]
        value = make()
        with self._lock:
            if key in self._entries:
                return self._entries[key][0]
            self._entries[key] = (value, size)
            self._total += size
            while self._total > self._capacity and len(self._entries) > 1:
                _, (_, freed) = self._entries.popitem(last=False)
                self._total -= freed
        return value
