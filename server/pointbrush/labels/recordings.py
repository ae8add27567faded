"""Recordings in the database: identified by their import, deleted and restored as a whole."""

from __future__ import annotations

import re
import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, Row, delete, select, update

from pointbrush.database import schema
from pointbrush.database.database import Database
from pointbrush.database.guards import busy_with
from pointbrush.database.project_rows import REMOVED, forget_tasks, put_in
from pointbrush.database.project_tables import FIRST, tasks, version_recordings
from pointbrush.database.revisions import IS_LIVE
from pointbrush.database.statements import driver_of
from pointbrush.errors import BadInputError, ConflictError, NotFoundError
from pointbrush.labels import plans
from pointbrush.labels.open_recordings import OpenRecordings
from pointbrush.labels.state import decode_points, encode_points

KEPT_SECONDS = 30 * 86_400.0
"""Time for which a deleted recording can be restored."""
SURE_SECONDS = 86_400.0
"""Additional time until an expired recording is purged, so that a wrong clock can be corrected."""
_SET_ASIDE = re.compile(r"\.labels-\d+")
_SEQUENCES = schema.sequences.c
_LIVE_INDEX = next(i for i in schema.sequences.indexes if i.name == "sequences_live")


@dataclass(frozen=True, slots=True)
class Known:
    """A recording's row; times are seconds since the epoch.

    ``identity`` is the import's, None for labels of schema 0001 without a registered recording.
    """

    number: int
    id: str
    identity: str | None
    revision: int
    deleted: float | None

    @property
    def until(self) -> float | None:
        """Return the time until which it can be restored."""
        return None if self.deleted is None else self.deleted + KEPT_SECONDS


class Recordings:
    """Recordings with labels, including deleted recordings."""

    def __init__(self, database: Database, open_recordings: OpenRecordings) -> None:
        self._database, self._open_recordings = database, open_recordings

    def register(
        self,
        sequence: str,
        points: Sequence[int],
        identity: str | None = None,
        project: str = FIRST,
    ) -> None:
        """Register a recording with the number of points of each frame; a repetition has no effect.

        A new recording is in ``project`` from the start, so that only its people see it, or in the
        first project if there is none of this id.  Labels of another import with this id are set
        aside under a separate id; labels of this import that were set aside are restored.
        ``identity`` None: the import is unknown.  Raises ConflictError if it is registered with
        other points.
        """
        plans.check_text("sequence", sequence, plans.ID_LIMIT)
        counts = [int(n) for n in points]
        if any(n < 0 for n in counts):
            raise BadInputError("points: expected counts of 0 or more")
        with self._database.read() as connection:
            row = _find(connection, sequence)
        if row is not None and row.identity == identity and _has(row, counts):
            return
        with self._open_recordings.listing(), self._database.write() as connection:
            row = _find(connection, sequence, lock=True)
            if row is None or not _fits(row, counts, identity):
                row = self._make_room(connection, sequence, row, counts, identity)
                if project != FIRST:
                    put_in(connection, project, sequence)
            elif identity is not None and row.identity is None:
                _change(connection, row.number, identity=identity)
            self._open_recordings.watcher.announce(driver_of(connection))
        if not _has(row, counts):
            raise ConflictError(
                f"sequence: expected {sequence!r} to keep its frames, got other point counts"
            )

    def _make_room(
        self,
        connection: Connection,
        sequence: str,
        there: Row[Any] | None,
        counts: list[int],
        identity: str | None,
    ) -> Row[Any]:
        """Return a row for this import; a row of another import is set aside."""
        if there is not None and identity is None:
            return there
        if there is not None:
            _change(connection, there.number, id=f"{sequence}.labels-{there.number}")
        for row in connection.execute(select(schema.sequences).where(IS_LIVE)).all():
            mine = identity is not None and row.identity == identity
            if mine and _SET_ASIDE.search(row.id) and _has(row, counts):
                _change(connection, row.number, id=sequence)
                return row
        fields = {
            "id": sequence,
            "revision": 0,
            "highest_label": 0,
            "points": encode_points(counts),
            "identity": identity,
        }
        self._database.insert_new(connection, _LIVE_INDEX, fields)
        # Inserted here, or by another process at the same moment.
        query = select(schema.sequences).where(_SEQUENCES.id == sequence, IS_LIVE)
        return connection.execute(query).one()

    def forget(self, sequence: str) -> None:
        """Remove a recording's labels with their history; an unknown recording is no error."""
        with self._open_recordings.listing(), self._database.write() as connection:
            row = _find(connection, sequence, lock=True)
            if row is not None:
                _erase(connection, row.number)
        self._open_recordings.forget(sequence)

    def live(self) -> list[Known]:
        """Return all recordings that are not deleted."""
        with self._database.read() as connection:
            return [
                _known(row) for row in connection.execute(select(schema.sequences).where(IS_LIVE))
            ]

    # ── deleted ones ─────────────────────────────────────────────────────────────────────

    def delete(self, sequence: str) -> Known:
        """Mark a recording as deleted, independent of the removal of its files.

        Raises NotFoundError, ConflictError while it is imported or tracked.
        """
        with self._open_recordings.listing(), self._database.write() as connection:
            row = _find(connection, sequence, lock=True)
            if row is None:
                raise NotFoundError(f"sequence: expected a known id, got {sequence!r}")
            busy = busy_with(connection, sequence, self._database.now(connection))
            if busy is not None:
                raise ConflictError(f"sequence: {sequence!r} cannot be deleted now, {busy}")
            identity = row.identity or secrets.token_hex(8)
            _change(
                connection, row.number, deleted=self._database.now(connection), identity=identity
            )
            row = connection.execute(_of(row.number)).one()
            self._open_recordings.watcher.announce(driver_of(connection))
        self._open_recordings.forget(sequence)
        return _known(row)

    def deleted(self) -> list[Known]:
        """Return the recordings that are deleted and not yet purged, newest first."""
        query = select(schema.sequences).where(~IS_LIVE).order_by(_SEQUENCES.deleted.desc())
        with self._database.read() as connection:
            return [_known(row) for row in connection.execute(query)]

    def restore(self, number: int, sequence: str) -> Known:
        """Restore a deleted recording under the id ``sequence``, which the caller has reserved.

        Raises NotFoundError if it is not deleted, or expired.
        """
        with self._open_recordings.listing(), self._database.write() as connection:
            oldest = self._database.now(connection) - KEPT_SECONDS
            row = connection.execute(_of(number).with_for_update()).one_or_none()
            if row is None or row.deleted is None or row.deleted < oldest:
                raise NotFoundError(f"sequence: expected a deleted recording, got {sequence!r}")
            back = {"project": None} if row.project == REMOVED else {}
            _change(connection, number, id=sequence, deleted=None, expired=None, **back)
            row = connection.execute(_of(number)).one()
            self._open_recordings.watcher.announce(driver_of(connection))
        return _known(row)

    def expired(self) -> list[Known]:
        """Return the recordings that expired at least SURE_SECONDS ago.

        This call stores when an expiry is first seen, and clears it if the clock was set back.
        """
        with self._database.read() as connection:
            now = self._database.now(connection)
            rows = connection.execute(select(schema.sequences).where(~IS_LIVE)).all()
        noted = {row.number: _first_seen(row, now) for row in rows}
        changed = [row.number for row in rows if row.expired != noted[row.number]]
        if changed:
            with self._database.write() as connection:
                for number in changed:
                    _change(connection, number, expired=noted[number])
        return [_known(row) for row in rows if _is_over(noted[row.number], now)]

    def purge(self, number: int) -> None:
        """Remove the rows of a recording that expired at least SURE_SECONDS ago."""
        with self._database.write() as connection:
            now = self._database.now(connection)
            row = connection.execute(_of(number).with_for_update()).one_or_none()
            if row is not None and _is_over(_first_seen(row, now), now):
                _erase(connection, number)

    def erase(self, number: int) -> None:
        """Remove the rows of a deleted recording now, overwritten in a SQLite file."""
        with self._database.write(erases=True) as connection:
            _erase(connection, number)


def _find(connection: Connection, sequence: str, *, lock: bool = False) -> Row[Any] | None:
    query = select(schema.sequences).where(_SEQUENCES.id == sequence, IS_LIVE)
    return connection.execute(query.with_for_update() if lock else query).one_or_none()


def _of(number: int) -> Any:
    return select(schema.sequences).where(_SEQUENCES.number == number)


def _change(connection: Connection, number: int, **values: Any) -> None:
    connection.execute(update(schema.sequences).where(_SEQUENCES.number == number).values(**values))


def _erase(connection: Connection, number: int) -> None:
    forget_tasks(connection, tasks.c.sequence == number)
    connection.execute(delete(version_recordings).where(version_recordings.c.sequence == number))
    for table in schema.PER_SEQUENCE:
        connection.execute(delete(table).where(table.c.sequence == number))
    connection.execute(delete(schema.sequences).where(_SEQUENCES.number == number))


def _first_seen(row: Row[Any], now: float) -> float | None:
    """Return the time at which its expiry was first seen, or None."""
    if row.deleted is None or row.deleted >= now - KEPT_SECONDS:
        return None
    return now if row.expired is None or row.expired > now else float(row.expired)


def _is_over(first_seen: float | None, now: float) -> bool:
    return first_seen is not None and now - first_seen >= SURE_SECONDS


def _has(row: Row[Any], counts: list[int]) -> bool:
    return bool(decode_points(row.points).tolist() == counts)


def _fits(row: Row[Any], counts: list[int], identity: str | None) -> bool:
    """Return whether a row is of this import; rows of schema 0001 match by their points."""
    if identity is None or row.identity is None:
        return _has(row, counts)
    return bool(row.identity == identity)


def _known(row: Row[Any]) -> Known:
    return Known(row.number, row.id, row.identity, row.revision, row.deleted)
