"""A limit on the lines of the log that callers without a token can cause."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

LINES_A_MINUTE = 60
"""Most lines a minute of each kind; a kind is one logging call in the code."""
MOST_KINDS = 500
LOGGERS = ("uvicorn.error", "asyncio", "pointbrush.web.logs", "pointbrush.web.problems")
"""Loggers with lines that a caller without a token can cause."""


@dataclass(slots=True)
class _Kind:
    """Lines of one kind in the minute that has begun at ``since`` (seconds, monotonic)."""

    since: float
    lines: int = 0
    left_out: int = 0


class LineLimit(logging.Filter):
    """Passes at most ``lines`` of each kind a minute; the next line reports the number left out.

    All records with a true attribute ``known``, of authenticated callers, pass.
    """

    def __init__(
        self, lines: int = LINES_A_MINUTE, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__()
        self._lines, self._clock = lines, clock
        self._kinds: dict[tuple[str, int], _Kind] = {}
        self._lock = threading.Lock()

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether to write a record."""
        if getattr(record, "known", False):
            return True
        with self._lock:
            kind = self._kind(record)
            kind.lines += 1
            if kind.lines > self._lines:
                kind.left_out += 1
                return False
            left_out, kind.left_out = kind.left_out, 0
        if left_out:
            record.msg = f"{record.getMessage()} ({left_out} more lines like it were left out)"
            record.args = ()
        return True

    def _kind(self, record: logging.LogRecord) -> _Kind:
        place, now = (record.pathname, record.lineno), self._clock()
        found = self._kinds.get(place)
        if found is None:
            if len(self._kinds) >= MOST_KINDS:
                self._kinds.clear()
            found = self._kinds[place] = _Kind(now)
        elif now - found.since >= 60.0:
            found.since, found.lines = now, 0
        return found


def limit_lines() -> None:
    """Bound the lines of all loggers that callers without a token reach."""
    limit = LineLimit()
    for name in LOGGERS:
        logging.getLogger(name).addFilter(limit)
