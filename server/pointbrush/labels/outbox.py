"""Queue of the commits of a process for its subscribers."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable

from pointbrush.labels.types import Commit

log = logging.getLogger(__name__)

Listener = Callable[[Commit], None]


class Outbox:
    """Queue of commits for subscribers, each delivered once and in order."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._waiting: deque[Commit] = deque()
        self._listeners: list[Listener] = []
        self._draining = False

    def subscribe(self, listener: Listener) -> Callable[[], None]:
        """Call ``listener`` at every commit; returns a function that unsubscribes it."""
        with self._lock:
            self._listeners = [*self._listeners, listener]

        def undo() -> None:
            with self._lock:
                self._listeners = [one for one in self._listeners if one is not listener]

        return undo

    @property
    def wanted(self) -> bool:
        """Return whether there are subscribers."""
        return bool(self._listeners)

    def put(self, commit: Commit) -> None:
        """Queue a commit; call it in the order of the revisions."""
        with self._lock:
            if self._listeners:
                self._waiting.append(commit)

    def drain(self) -> None:
        """Deliver the queued commits; return at once if another thread is delivering."""
        while True:
            with self._lock:
                if self._draining or not self._waiting:
                    return
                self._draining = True
                commit, listeners = self._waiting.popleft(), self._listeners
            try:
                for listener in listeners:
                    _call(listener, commit)
            finally:
                with self._lock:
                    self._draining = False


def _call(listener: Listener, commit: Commit) -> None:
    # A subscriber's error must not fail an edit that is already durable.
    try:
        listener(commit)
    except Exception:
        log.exception("a subscriber failed at revision %d of %s", commit.revision, commit.sequence)
