"""Fetching the frames after one that is looked at, so that playing does not wait for each."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable

from pointbrush.errors import PointbrushError

log = logging.getLogger(__name__)

AHEAD_FRAMES = 8
"""Frames that are fetched before anybody asks for them: a quarter of a second of playing."""
THREADS = 4
"""Frames of one recording that are fetched at once."""


class ReadAhead:
    """Fetches frames in the direction in which they are looked at; thread-safe.

    What was wished for earlier and not begun gives way: after a jump nobody waits for it.
    """

    def __init__(self, frames: int, fetch: Callable[[int], None]) -> None:
        """``fetch(index)`` fetches one of ``frames``, unless it is here."""
        self._frames, self._fetch = frames, fetch
        self._last = -1
        self._wishes: deque[int] = deque()
        self._threads = 0
        self._lock = threading.Lock()

    def looked_at(self, index: int) -> None:
        """Fetch those after ``index``, or before it, where the last one was after it."""
        with self._lock:
            if index == self._last:
                return
            step = -1 if index < self._last else 1
            self._last = index
            wished = (index + step * k for k in range(1, AHEAD_FRAMES + 1))
            self._wishes = deque(frame for frame in wished if 0 <= frame < self._frames)
            missing = min(THREADS, len(self._wishes)) - self._threads
            self._threads += max(0, missing)
        for _ in range(missing):
            threading.Thread(target=self._run, name="pointbrush-ahead", daemon=True).start()

    def _run(self) -> None:
        while True:
            with self._lock:
                if not self._wishes:
                    self._threads -= 1
                    return
                index = self._wishes.popleft()
            try:
                self._fetch(index)
            except PointbrushError as error:
                log.info("frame %d was not fetched ahead: %s", index, error)
            except Exception:
                log.exception("frame %d was not fetched ahead", index)
