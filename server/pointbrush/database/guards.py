"""Guards of work on a recording, stored in the database for all its servers."""

from __future__ import annotations

import contextlib
import logging
import os
import secrets
import socket
import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Row, delete, insert, or_, select, update

from pointbrush.database.database import Database
from pointbrush.database.revisions import find_revision
from pointbrush.database.schema import works
from pointbrush.errors import ConflictError, NotFoundError, UnavailableError
from pointbrush.system.resources import process_alive

log = logging.getLogger(__name__)

BEAT_SECONDS = 20.0
"""Interval of a process's heartbeats."""
EXPIRY_SECONDS = 180.0
"""Time without a heartbeat after which work counts as abandoned."""
IMPORT, TRACKING = "import", "tracking"
DOING = {IMPORT: "is being imported", TRACKING: "is being tracked"}
_IMPORT_INDEX = next(i for i in works.indexes if i.name == "works_import")


@dataclass(frozen=True, slots=True)
class Guard:
    """Work of this process on the recording ``sequence``; end it with ``Guards.end``."""

    id: str
    sequence: str


class Guards:
    """Work of one process on the recordings of a database; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self.owner = secrets.token_hex(8)
        self._held: set[str] = set()
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="pointbrush-guards", daemon=True)

    def close(self) -> None:
        """Release the held guards and end the thread."""
        self._stop.set()
        if self._thread.ident is not None:
            self._thread.join()
            with contextlib.suppress(UnavailableError):
                self._remove(works.c.owner == self.owner)

    def reserve(self, ids: Iterable[str], free: Callable[[str], bool]) -> Guard:
        """Reserve for an import the first of ``ids`` that no recording or other import has.

        ``free(id)`` returns whether no files of that id exist.
        """
        for sequence in ids:
            guard = self._reserve(sequence, free)
            if guard is not None:
                return guard
        raise ConflictError("sequence: expected a free id, all are taken")

    def _reserve(self, sequence: str, free: Callable[[str], bool]) -> Guard | None:
        with self._database.write() as connection:
            now = self._database.now(connection)
            _clear(connection, now)
            guard = Guard(secrets.token_hex(16), sequence)
            row = self._row(guard, IMPORT, now)
            if not self._database.insert_new(connection, _IMPORT_INDEX, row):
                return None
            # Checked after the reservation: an earlier import of this id has finished by now.
            if find_revision(connection, sequence) is not None or not free(sequence):
                connection.execute(delete(works).where(works.c.id == guard.id))
                return None
        self._hold(guard)
        return guard

    def begin(self, sequence: str, kind: str) -> Guard:
        """Guard a recording against deletion during work on it; raises NotFoundError."""
        with self._database.write() as connection:
            if find_revision(connection, sequence, lock=True) is None:
                raise NotFoundError(f"sequence: expected a known id, got {sequence!r}")
            guard = Guard(secrets.token_hex(16), sequence)
            row = self._row(guard, kind, self._database.now(connection))
            connection.execute(insert(works), row)
        self._hold(guard)
        return guard

    def end(self, guard: Guard) -> None:
        """End a guard; if the database is unavailable, the guard expires later."""
        with self._lock:
            self._held.discard(guard.id)
        try:
            self._remove(works.c.id == guard.id)
        except UnavailableError as error:
            log.warning("%s stays guarded for %.0f s: %s", guard.sequence, EXPIRY_SECONDS, error)

    def importing(self) -> set[str]:
        """Return the ids reserved by unfinished imports."""
        with self._database.read() as connection:
            now = self._database.now(connection)
            rows = connection.execute(select(works).where(works.c.kind == IMPORT)).all()
        return {row.sequence for row in rows if not given_up(row, now, EXPIRY_SECONDS)}

    def _remove(self, condition: Any) -> None:
        with self._database.write() as connection:
            connection.execute(delete(works).where(condition))

    def _row(self, guard: Guard, kind: str, now: float) -> dict[str, Any]:
        return {
            "id": guard.id,
            "sequence": guard.sequence,
            "kind": kind,
            "host": host(),
            "process": os.getpid(),
            "owner": self.owner,
            "beat": now,
        }

    def _hold(self, guard: Guard) -> None:
        with self._lock:
            self._held.add(guard.id)
            if self._thread.ident is None:
                self._thread.start()

    def _run(self) -> None:
        while not self._stop.wait(BEAT_SECONDS):
            with self._lock:
                held = set(self._held)
            if not held:
                continue
            try:
                with self._database.write() as connection:
                    beat = update(works).where(works.c.id.in_(held))
                    connection.execute(beat.values(beat=self._database.now(connection)))
            except UnavailableError as error:
                log.warning("cannot say that work goes on: %s", error)


def busy_with(connection: Connection, sequence: str, now: float) -> str | None:
    """Return a sentence about the work on a recording, or None."""
    rows = connection.execute(select(works).where(works.c.sequence == sequence)).all()
    for row in rows:
        if not given_up(row, now, EXPIRY_SECONDS):
            host = row.host.partition("/")[0]
            return f"it {DOING[row.kind]} (by process {row.process} on {host})"
    return None


def _clear(connection: Connection, now: float) -> None:
    """Remove abandoned work."""
    rows = connection.execute(select(works).where(or_(works.c.host == host(), works.c.beat < now)))
    dead = [row.id for row in rows if given_up(row, now, EXPIRY_SECONDS)]
    if dead:
        connection.execute(delete(works).where(works.c.id.in_(dead)))


def given_up(row: Row[Any], now: float, seconds: float | None) -> bool:
    """Return whether the process of a row has ended, or had no heartbeat for ``seconds``."""
    if seconds is not None and row.beat < now - seconds:
        return True
    return bool(row.host == host() and not process_alive(row.process))


@cache
def host() -> str:
    """Return the name of this machine and, where it exists, the namespace of its process ids."""
    try:
        space = Path("/proc/self/ns/pid").stat().st_ino
    except OSError:
        space = 0
    return f"{socket.gethostname()}/{space}"
