"""Messages of a recording's labels: the current values of runs of points, with their revisions."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable
from typing import Any

from pointbrush.labels import LabelStore
from pointbrush.streaming.encoding import encode_whole
from pointbrush.streaming.shared.cache import MessageCache, Versioned

CATCH_UP_TRIES = 100
CATCH_UP_PAUSE = 0.005
"""Seconds between two tries."""


class Values:
    """Values of the points of one recording, by revision.  Event loop only."""

    def __init__(
        self,
        labels: LabelStore,
        key: tuple[str, str],
        cache: MessageCache,
        run: Callable[..., Awaitable[Any]],
    ) -> None:
        """``key``: id and identity of the recording; ``run`` as of ``Room``."""
        self._labels, self._key, self._cache, self._run = labels, key, cache, run
        self.revision = 0
        """The newest commit in the outboxes of the viewers."""
        self._changed: dict[int, int] = {}
        self._start = 0

    def begin(self, revision: int) -> None:
        """Start with the state at a revision, or at a later one that has arrived since."""
        self.revision = self._start = max(self.revision, revision)

    def missed(self, before: int) -> None:
        """Treat all frames as changed up to a revision, as its commits did not arrive."""
        self._start = before
        self._changed.clear()

    def change(self, frames: Iterable[int], revision: int) -> None:
        """Mark frames as changed by a commit; older values are not returned from now on."""
        self._changed.update(dict.fromkeys(frames, revision))

    def last_change(self, frame: int) -> int:
        """Return the revision of the last change of a frame."""
        return self._changed.get(frame, self._start)

    def known(self, frame: int, first: int, count: int) -> Versioned | None:
        """Return the result of ``message`` if it needs no read."""
        found = self._cache.known(self._run_key(frame, first, count), self.last_change(frame))
        return None if found is None or found[0] > self.revision else found

    async def message(self, frame: int, first: int, count: int) -> Versioned:
        """Return the revision of the current values of a run of points, and their message.

        Every commit up to that revision is in the viewers' outboxes.
        """
        recording = self._key[0]

        def read() -> Versioned:
            values = self._labels.values(recording, frame, first, count)
            return values.revision, encode_whole(recording, frame, first, values)

        key, least = self._run_key(frame, first, count), self.last_change(frame)
        found = await self._cache.get(key, lambda: self._run(read), least)
        for _ in range(CATCH_UP_TRIES):
            if self.revision >= found[0]:
                break
            # The commit has been read, but its event has not arrived yet.
            await asyncio.sleep(CATCH_UP_PAUSE)
        return found

    def _run_key(self, frame: int, first: int, count: int) -> tuple[object, ...]:
        return "values", self._key, frame, first, count
