"""Copies of recordings, each for one person, independent of the labels of other people."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from sqlalchemy import ColumnElement, and_, exists, or_, select, update

from pointbrush.database.database import Database
from pointbrush.database.project_tables import tasks
from pointbrush.database.schema import LIVE, PROJECT_OF, sequences

CopyKind = Literal["agreement", "truth", "scratch", "study"]
"""Copies that are compared with each other, with known ground truth, not at all, or in a study."""


@dataclass(frozen=True, slots=True)
class CopyTask:
    """Frames ``first`` to ``last`` of a copy, their assignee (an account or ""), their state."""

    first: int
    last: int
    assignee: str
    state: str


@dataclass(frozen=True, slots=True)
class Copy:
    """A copy ``id`` of recording ``original``, and its tasks."""

    id: str
    original: str
    kind: CopyKind
    tasks: tuple[CopyTask, ...] = ()


class Copies:
    """The copies of one database; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def mark(self, copy: str, original: str, project: str, kind: CopyKind) -> None:
        """Mark a newly registered recording as a copy."""
        number = select(sequences.c.number).where(sequences.c.id == original, LIVE)
        with self._database.write() as connection:
            values = {"copy_of": number.scalar_subquery(), "copy_kind": kind, "project": project}
            row = update(sequences).where(sequences.c.id == copy, LIVE)
            connection.execute(row.values(**values))

    def originals(self) -> dict[str, str]:
        """Return the id of each copy's original, by the id of the copy."""
        whole = sequences.alias()
        chosen = (
            select(sequences.c.id, whole.c.id.label("original"))
            .join(whole, whole.c.number == sequences.c.copy_of)
            .where(sequences.c.deleted.is_(None))
        )
        with self._database.read() as connection:
            return {row.id: row.original for row in connection.execute(chosen)}

    def of(self, project: str, kind: CopyKind, original: str | None = None) -> list[Copy]:
        """Return the copies of one recording of a project, or of all its recordings, by id."""
        whole = sequences.alias()
        chosen = (
            select(sequences.c.number, sequences.c.id, whole.c.id.label("original"))
            .join(whole, whole.c.number == sequences.c.copy_of)
            .where(sequences.c.deleted.is_(None), whole.c.deleted.is_(None))
            .where(project == PROJECT_OF, sequences.c.copy_kind == kind)
            .order_by(sequences.c.id)
        )
        if original is not None:
            chosen = chosen.where(whole.c.id == original)
        with self._database.read() as connection:
            rows = connection.execute(chosen).all()
            numbers = [row.number for row in rows]
            given: dict[int, list[CopyTask]] = {number: [] for number in numbers}
            of_them = select(tasks).where(tasks.c.project == project).order_by(tasks.c.number)
            for row in connection.execute(of_them):
                if row.sequence in given:
                    task = CopyTask(row.first, row.last, row.assignee or "", row.state)
                    given[row.sequence].append(task)
        return [Copy(row.id, row.original, kind, tuple(given[row.number])) for row in rows]


def seen_elsewhere(account: str) -> ColumnElement[bool]:
    """Return the condition that an account has a task of another copy of a task's recording.

    It also holds for a task of the recording itself if one of the two has known ground truth.  It
    applies to rows of ``tasks`` joined with ``sequences``.
    """
    other, theirs = sequences.alias(), tasks.alias()
    there = (
        select(theirs.c.number)
        .join(other, other.c.number == theirs.c.sequence)
        .where(
            theirs.c.assignee == account,
            or_(
                and_(other.c.copy_of == sequences.c.copy_of, other.c.number != sequences.c.number),
                and_(other.c.number == sequences.c.copy_of, sequences.c.copy_kind == "truth"),
                and_(other.c.copy_of == sequences.c.number, other.c.copy_kind == "truth"),
            ),
        )
    )
    return exists(there.correlate(sequences))
