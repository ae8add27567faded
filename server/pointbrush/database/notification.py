"""Notification of commits between the processes of one database."""

from __future__ import annotations

import contextlib
import logging
import secrets
import sqlite3
import threading
from collections.abc import Callable
from pathlib import Path

from pointbrush.database.database import Database
from pointbrush.database.statements import Driver
from pointbrush.errors import UnavailableError

log = logging.getLogger(__name__)

CHANNEL = "pointbrush_commits"
POLL_SECONDS = 0.1
"""Polling interval for commits of other processes to a SQLite file."""
RETRY_SECONDS = 1.0


class Watcher:
    """A thread that notices other processes' commits and calls ``heard`` to catch up."""

    def __init__(self, database: Database, heard: Callable[[], None]) -> None:
        self._database = database
        self._heard = heard
        self._stop = threading.Event()
        self.origin = secrets.token_hex(8)
        self._starting = threading.Lock()
        self._thread = threading.Thread(target=self._run, name="pointbrush-watcher", daemon=True)

    def start(self) -> None:
        """Start the thread once."""
        with self._starting:
            if self._thread.ident is None and not self._stop.is_set():
                self._thread.start()

    def announce(self, driver: Driver) -> None:
        """Notify other processes when the transaction commits."""
        if not self._database.sqlite:
            driver.execute("SELECT pg_notify(%s, %s)", (CHANNEL, self.origin))

    def close(self) -> None:
        """End the thread."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join()

    def _caught_up(self) -> bool:
        """Apply other processes' commits; return False, after a pause, if that failed.

        There is no second notification, so without a retry the state stays behind until the next
        commit.
        """
        try:
            self._heard()
        except Exception as error:
            if isinstance(error, UnavailableError):
                log.warning("another process's commits are read later: %s", error)
            else:
                log.exception("could not catch up with another process's commits")
            self._stop.wait(RETRY_SECONDS)
            return False
        return True

    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                if self._database.path is not None:
                    self._watch_sqlite(self._database.path)
                else:
                    self._watch_postgres()
            except self._database.driver_error as error:
                log.warning("other processes' commits cannot be heard of now: %s", error)
                self._stop.wait(RETRY_SECONDS)

    def _watch_sqlite(self, path: Path) -> None:
        """Poll ``PRAGMA data_version``, which changes when another connection commits."""
        seen: int | None = None
        with contextlib.closing(sqlite3.connect(path, timeout=1)) as connection:
            while not self._stop.wait(POLL_SECONDS):
                version = connection.execute("PRAGMA data_version").fetchone()[0]
                if version != seen and self._caught_up():
                    seen = version

    def _watch_postgres(self) -> None:
        with self._database.listener() as connection:
            connection.execute(f"LISTEN {CHANNEL}")
            behind = True  # commits before LISTEN were not announced
            while not self._stop.is_set():
                if behind and self._caught_up():
                    behind = False
                notices = list(connection.notifies(timeout=0.25, stop_after=1))
                behind = behind or any(notice.payload != self.origin for notice in notices)
