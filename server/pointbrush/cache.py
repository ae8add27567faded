"""A least-recently-used cache bounded by the number or the total size of its entries."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import Lock
from typing import Generic, TypeVar

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


class Cache(Generic[K, V]):
    """Thread-safe; at least the newest entry stays, however large it is.

    An entry has the size 1 unless it is given, so that ``capacity`` is a number of entries.
    """

    def __init__(self, capacity: int) -> None:
        self._capacity = capacity
        self._entries: OrderedDict[K, tuple[V, int]] = OrderedDict()
        self._total = 0
        self._lock = Lock()

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self._capacity,)  # a copy in another process begins empty

    def __len__(self) -> int:
        return len(self._entries)

    def __contains__(self, key: object) -> bool:
        return key in self._entries

    def known(self, key: K) -> V | None:
        """Return the entry under ``key``, or None."""
        with self._lock:
            if key not in self._entries:
                return None
            self._entries.move_to_end(key)
            return self._entries[key][0]

    def held(self) -> list[K]:
        """Return the current keys, the least recently used first."""
        with self._lock:
            return list(self._entries)

    def drop(self, *keys: K) -> None:
        """Remove the entries under ``keys`` that exist."""
        with self._lock:
            for key in keys:
                self._total -= self._entries.pop(key, (None, 0))[1]

    def get(self, key: K, make: Callable[[], V], size: int = 1) -> V:
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
            self._keep(key, value, size)
        return value

    def put(self, key: K, value: V, size: int = 1) -> list[tuple[K, V]]:
        """Set the entry under ``key``; return the entries that were removed for it."""
        with self._lock:
            self._total -= self._entries.pop(key, (None, 0))[1]
            return self._keep(key, value, size)

    def _keep(self, key: K, value: V, size: int) -> list[tuple[K, V]]:
        self._entries[key] = (value, size)
        self._total += size
        removed = []
        while self._total > self._capacity and len(self._entries) > 1:
            oldest, (old, freed) = self._entries.popitem(last=False)
            self._total -= freed
            removed.append((oldest, old))
        return removed
