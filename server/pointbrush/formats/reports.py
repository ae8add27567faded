"""Warnings of readers about a recording that they do not refuse, collected."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

MOST = 100
"""Warnings that are kept of one recording."""


class _Collector(logging.Handler):
    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.found: dict[str, None] = {}

    def emit(self, record: logging.LogRecord) -> None:
        if len(self.found) < MOST:
            self.found.setdefault(record.getMessage())


@contextmanager
def reported() -> Iterator[dict[str, None]]:
    """Collect what readers warn of meanwhile, each once, in order; it is logged as well.

    Readers of this process, in all its threads: one recording at a time.
    """
    collector = _Collector()
    logger = logging.getLogger("pointbrush.formats")
    logger.addHandler(collector)
    try:
        yield collector.found
    finally:
        logger.removeHandler(collector)
