"""Prefetching of the frames after the shown one, so that playback does not wait for each."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable

from pointbrush.errors import PointbrushError

log = logging.getLogger(__name__)

AHEAD_FRAMES = 16
"""Frames that are prefetched: half a second of playback."""
AHEAD_BYTES = 256 << 20
"""Most bytes of the prefetched frames; at least one frame is fetched."""
THREADS = 6
"""Frames of one recording that are fetched at once."""
REMEMBERED = 64
"""Number of last shown frames, which give the direction, and of kept requests of all viewers."""


class ReadAhead:
    """Prefetches frames in the direction of playback; thread-safe.

    The newest requests are served first, so that a jump does not wait for older ones.
    """

    def __init__(self, frames: int, nbytes: int, fetch: Callable[[int], None]) -> None:
        """``fetch(index)`` fetches one of ``frames`` of ``nbytes`` in all, unless it is here."""
        self._frames, self._fetch = frames, fetch
        self._ahead = max(1, min(AHEAD_FRAMES, AHEAD_BYTES * frames // max(nbytes, 1)))
        self._looked_at: deque[int] = deque(maxlen=REMEMBERED)
        self._wishes: deque[int] = deque()
        self._threads = 0
        self._lock = threading.Lock()

    def looked_at(self, index: int) -> None:
        """Fetch the frames after ``index``, or before it if playback runs backwards."""
        with self._lock:
            seen = self._looked_at
            step = -1 if index + 1 in seen and index - 1 not in seen else 1
            seen.append(index)
            ahead = (index + step * k for k in range(1, self._ahead + 1))
            new = [frame for frame in ahead if 0 <= frame < self._frames and frame not in seen]
            old = [frame for frame in self._wishes if frame not in new]
            self._wishes = deque([*new, *old][:REMEMBERED])
            started = max(0, min(THREADS, len(self._wishes)) - self._threads)
            self._threads += started
        for _ in range(started):
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
