"""Looking whether a recording has a newer revision: one short question, outside transactions."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable

from pointbrush.labels.statements import Driver, Statement, Values

KEPT = 8
"""Connections that are kept; more are open while more threads look at once."""


class Look:
    """Connections of their own that answer single questions; thread-safe."""

    def __init__(self, connect: Callable[[], Driver], failure: type[Exception]) -> None:
        """``connect``: opens a connection of the driver that commits each statement by itself.

        ``failure``: raised by the driver for a connection that was lost.
        """
        self._connect = connect
        self._failure = failure
        self._lock = threading.Lock()
        self._idle: list[Driver] = []

    def one(self, statement: Statement, values: Values) -> object:
        """The row that a statement gives, or None; raises the driver's errors.

        A kept connection may have been lost since: then a new one is asked.
        """
        with self._lock:
            driver = self._idle.pop() if self._idle else None
        if driver is not None:
            try:
                return self._asked(driver, statement, values)
            except self._failure:
                self.close()
        return self._asked(self._connect(), statement, values)

    def _asked(self, driver: Driver, statement: Statement, values: Values) -> object:
        try:
            row = statement.ask(driver, values)
        except BaseException:
            with contextlib.suppress(Exception):
                driver.close()
            raise
        with self._lock:
            keep = len(self._idle) < KEPT
            if keep:
                self._idle.append(driver)
        if not keep:
            driver.close()
        return row

    def close(self) -> None:
        """Close the connections that are kept."""
        with self._lock:
            idle, self._idle = self._idle, []
        for driver in idle:
            with contextlib.suppress(Exception):
                driver.close()
