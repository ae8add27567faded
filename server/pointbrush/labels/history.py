"""Reading the history: its lines, each author's stacks, and what a reconnecting page missed."""

from __future__ import annotations

import json
from typing import Any

from sqlalchemy import Connection, Row, and_, func, select

from pointbrush.errors import BadInputError
from pointbrush.labels import journal, schema
from pointbrush.labels.schema import edits
from pointbrush.labels.state import SequenceState
from pointbrush.labels.types import EditInfo, GapError

HISTORY_LIMIT = 1_000
"""Lines in one answer."""
SINCE_EDITS = 2_000
SINCE_POINTS = 5_000_000
"""Beyond so many edits or changed points, whole annotations are the shorter way to catch up."""


def lines(connection: Connection, number: int, before: int | None, limit: int) -> list[EditInfo]:
    """Lines of the history, newest first; raises BadInputError for a limit below 1."""
    if limit < 1:
        raise BadInputError(f"limit: expected 1 or more, got {limit}")
    target = edits.alias()
    query = (
        select(edits, target.c.id.label("target_id"))
        .join(
            target,
            and_(target.c.sequence == edits.c.sequence, target.c.revision == edits.c.target),
            isouter=True,
        )
        .where(edits.c.sequence == number)
    )
    if before is not None:
        query = query.where(edits.c.revision < before)
    rows = connection.execute(
        query.order_by(edits.c.revision.desc()).limit(min(limit, HISTORY_LIMIT))
    )
    return [info(row, row.target_id) for row in rows]


def authors(connection: Connection, number: int) -> set[str]:
    """The accounts that edited the sequence."""
    query = select(edits.c.author).where(edits.c.sequence == number).distinct()
    return set(connection.execute(query).scalars())


def info(row: Row[Any], target: str | None = None) -> EditInfo:
    """A row as a line of the history."""
    return EditInfo(
        id=row.id,
        revision=row.revision,
        author=row.author,
        time=row.time,
        kind=row.kind,
        summary=row.summary,
        points=row.points,
        frames=tuple(json.loads(row.frames)),
        undone=row.state in (schema.UNDONE, schema.DROPPED),
        target=target,
    )


def stacks(ask: journal.Ask, number: int, author: str) -> tuple[EditInfo | None, EditInfo | None]:
    """Return the edits that ``author``'s undo, and redo, would take."""
    last = journal.top_of_stack(ask, number, author, schema.ACTIVE)
    undone = journal.top_of_stack(ask, number, author, schema.UNDONE)
    return last and info(last), undone and info(undone)


def rows_to_resend(connection: Connection, state: SequenceState, revision: int) -> list[Row[Any]]:
    """Rows after ``revision``, oldest first; raises GapError when whole is shorter."""
    missed = state.revision - revision
    if not 0 <= missed <= SINCE_EDITS:
        raise GapError(
            f"revision: expected {max(0, state.revision - SINCE_EDITS)} to {state.revision}, "
            f"got {revision}"
        )
    after = and_(edits.c.sequence == state.number, edits.c.revision > revision)
    points = connection.execute(select(func.sum(edits.c.points)).where(after)).scalar() or 0
    if points > SINCE_POINTS:
        raise GapError(f"revision: {points:,} points changed since {revision}")
    return journal.rows_since(connection, state.number, revision, SINCE_EDITS)
