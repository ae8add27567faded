"""Background work: snapshots of blocks, and checkpoints of SQLite's log."""

from __future__ import annotations

import contextlib
import logging
import queue
import sqlite3
import threading
from collections.abc import Callable
from pathlib import Path

from pointbrush.database.database import Database
from pointbrush.database.schema import snapshots
from pointbrush.database.statements import insert
from pointbrush.errors import UnavailableError
from pointbrush.labels.blocks import Place
from pointbrush.labels.packing import States, encode_states

log = logging.getLogger(__name__)

CHECKPOINT_BYTES = 16 << 20
"""Size of SQLite's write-ahead log that starts a checkpoint."""

LOOK_SECONDS = 1.0

Take = Callable[[], tuple[int, Place, int, States] | None]
"""Copies a block: sequence number, place, revision, states; None: no snapshot is due."""


class Upkeep:
    """A thread for queued work; all of it can be lost and repeated."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._tasks: queue.SimpleQueue[Take | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="pointbrush-upkeep", daemon=True)
        self._thread.start()

    def snapshot(self, take: Take) -> None:
        """Queue a snapshot; the thread calls ``take``."""
        self._tasks.put(take)

    def close(self) -> None:
        """Finish the queued work and end the thread."""
        self._tasks.put(None)
        self._thread.join()

    def _run(self) -> None:
        running = True
        while running:
            try:
                take = self._tasks.get(timeout=LOOK_SECONDS)
                running = take is not None
                if take is not None:
                    self._write(take)
            except queue.Empty:
                pass
            except UnavailableError as error:
                log.warning("a snapshot is put off: %s", error)
            except Exception:
                log.exception("a snapshot failed")
            self._look_at_log()

    def _look_at_log(self) -> None:
        """Make a checkpoint if SQLite's log is long."""
        path = self._database.path
        if path is not None and _size(path.with_name(path.name + "-wal")) > CHECKPOINT_BYTES:
            # Passive: neither readers nor writers wait for it.
            try:
                with contextlib.closing(sqlite3.connect(path, timeout=1)) as connection:
                    connection.execute("PRAGMA wal_checkpoint(PASSIVE)")
            except sqlite3.Error as error:
                log.warning("a checkpoint is put off: %s", error)

    def _write(self, take: Take) -> None:
        taken = take()
        if taken is None:
            return
        number, (frame, layer, block), revision, states = taken
        row = {
            "sequence": number,
            "frame": frame,
            "layer": layer,
            "block": block,
            "revision": revision,
            "data": encode_states(states),
        }
        statement = insert(snapshots, sqlite=self._database.sqlite)
        statement = statement.on_conflict_do_update(
            index_elements=["sequence", "frame", "layer", "block"],
            set_={"revision": statement.excluded.revision, "data": statement.excluded.data},
            # another process may have written a later snapshot
            where=snapshots.c.revision < statement.excluded.revision,
        )
        with self._database.write() as connection:
            connection.execute(statement, row)


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0
