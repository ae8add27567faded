"""Queries for the newest revision of a sequence."""

from __future__ import annotations

from typing import Any

from sqlalchemy import Connection, Row, and_, bindparam, select

from pointbrush.database.class_names import REVISION
from pointbrush.database.schema import edits, sequences
from pointbrush.database.statements import Statement

IS_LIVE = sequences.c.deleted.is_(None)

Found = tuple[int, int, int]
"""Number and revision of a sequence, and the revision of the classes' names."""
_LOOK = select(sequences.c.number, sequences.c.revision, REVISION.label("classes")).where(
    sequences.c.id == bindparam("sequence_id"), IS_LIVE
)
_LOCK = _LOOK.with_for_update()
LOOK, LOCK = Statement(_LOOK), Statement(_LOCK)
"""Queries for ``Found`` of a sequence; LOCK also locks it against other processes' commits."""
LOOK_FOR = Statement(
    _LOOK.add_columns(edits.c.revision.label("edit")).join(
        edits,
        and_(edits.c.sequence == sequences.c.number, edits.c.id == bindparam("edit_id")),
        isouter=True,
    )
)
"""Query for ``Found``, and the revision of an edit if it exists."""


def find_sequence(connection: Connection, sequence: str) -> Row[Any] | None:
    """Return the row of a sequence that is not deleted."""
    query = select(sequences).where(sequences.c.id == sequence, IS_LIVE)
    return connection.execute(query).one_or_none()


def find_revision(connection: Connection, sequence: str, *, lock: bool = False) -> Found | None:
    """Return ``Found`` of a sequence; ``lock`` blocks commits of other processes."""
    row = connection.execute(_LOCK if lock else _LOOK, {"sequence_id": sequence}).one_or_none()
    return found_in(row)


def found_in(row: Any) -> Found | None:
    """Return ``Found`` of a row of LOOK or LOCK, if there is one."""
    return None if row is None else (row.number, row.revision, row.classes)


def revisions(connection: Connection) -> dict[str, Found]:
    """Return ``Found`` of every sequence that is not deleted."""
    query = select(sequences.c.id, sequences.c.number, sequences.c.revision, REVISION).where(
        IS_LIVE
    )
    return {name: tuple(found) for name, *found in connection.execute(query)}
