"""Jobs in the database: all its servers see them, and they outlive the server that ran them."""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Iterable
from dataclasses import asdict, dataclass
from typing import Any, Literal

from sqlalchemy import ColumnElement, Connection, Row, Table, delete, func, select, update

from pointbrush.errors import ConflictError
from pointbrush.labels.database import Database
from pointbrush.labels.guards import given_up, host
from pointbrush.labels.lost_answers import write_once
from pointbrush.labels.schema import jobs, works
from pointbrush.labels.statements import insert

STALE_SECONDS = 30.0
"""After how long a silence a job's server counts as gone."""
KEPT_JOBS = 1000
"""Ended jobs that are kept; older ones are forgotten first."""
UNDER_WAY = ("queued", "running")
INTERRUPTED = "a backup was made while the job ran; start it again"
Wish = Literal["", "cancel", "keep"]
"""Wish of somebody at another server for a job: to stop, or to stop and keep what it found."""
_JSON = ("result", "request")


@dataclass(frozen=True, slots=True)
class JobRecord:
    """A job as the database has it; the first fields are those of ``pointbrush.jobs.Job``."""

    id: str
    kind: str
    sequence: str | None
    state: str
    progress: float
    message: str
    result: dict[str, Any] | None
    error: str | None
    created: float
    author: str | None
    edit: str | None
    request: dict[str, Any] | None
    """Request that begins it again on another server; None when nothing does."""
    lost: int = 0
    """Servers that have gone without a word while it ran."""
    wish: Wish = ""
    owner: str = ""
    """The process that runs it; nobody's when empty."""


class JobRecords:
    """The jobs of one database, as one of its servers writes them; thread-safe.

    Rows are locked in the order of their ids, or passed over where another server has locked them:
    servers on one database never wait for each other in a circle.
    """

    def __init__(self, database: Database, owner: str) -> None:
        """``owner`` is this process, as in its guards."""
        self._database, self.owner = database, owner

    def add(self, record: JobRecord) -> None:
        """Write a new job down, as this process's.

        Raises ConflictError when there is a job of its id, UnavailableError.
        """

        def make(connection: Connection) -> bool:
            row = _row(record) | self._mine(self._database.now(connection))
            # Another server may write the same call down at this moment: it is waited for.
            new = insert(jobs, sqlite=self._database.sqlite).values(row).on_conflict_do_nothing()
            counted = {"preserve_rowcount": True}
            if connection.execute(new, execution_options=counted).rowcount == 0:
                raise ConflictError(f"id: expected one of no job yet, got {record.id}")
            ended = (
                select(jobs.c.id)
                .where(jobs.c.state.not_in(UNDER_WAY))
                .order_by(jobs.c.created.desc())
                .offset(KEPT_JOBS)
            )
            old = jobs.c.id.in_(ended.subquery().select())
            _delete_unlocked(connection, jobs, old)
            return True

        def find(connection: Connection) -> bool | None:
            own = (jobs.c.id == record.id) & (jobs.c.owner == self.owner)
            return connection.scalar(select(jobs.c.id).where(own)) is not None or None

        write_once(self._database, make, find)

    def update(self, records: Iterable[JobRecord]) -> set[str]:
        """Write how far jobs of this process are; return those that are another's by now."""
        lost: set[str] = set()
        with self._database.write() as connection:
            now = self._database.now(connection)
            for record in sorted(records, key=lambda record: record.id):
                row = _row(record) | {"beat": now}
                for name in ("id", "owner", "wish", "lost"):
                    del row[name]
                own = (jobs.c.id == record.id) & (jobs.c.owner == self.owner)
                if connection.execute(update(jobs).where(own).values(row)).rowcount == 0:
                    lost.add(record.id)
        return lost

    def remove(self, ids: Collection[str]) -> None:
        """Remove jobs of this process."""
        own = jobs.c.id.in_(ids) & (jobs.c.owner == self.owner)
        with self._database.write() as connection:
            connection.execute(delete(jobs).where(own))

    def release(self, ids: Collection[str], message: str) -> None:
        """Leave jobs of this process to the next server that sees them."""
        own = jobs.c.id.in_(ids) & (jobs.c.owner == self.owner) & jobs.c.state.in_(UNDER_WAY)
        nobody = {"owner": "", "beat": 0.0, "state": "queued", "progress": 0.0, "message": message}
        with self._database.write() as connection:
            connection.execute(select(jobs.c.id).where(own).order_by(jobs.c.id).with_for_update())
            connection.execute(update(jobs).where(own).values(nobody))

    def under_way(self) -> list[JobRecord]:
        """Return all jobs that are queued or run, the oldest first."""
        chosen = select(jobs).where(jobs.c.state.in_(UNDER_WAY)).order_by(jobs.c.created)
        with self._database.read() as connection:
            return [_record(row) for row in connection.execute(chosen)]

    def all(self) -> list[JobRecord]:
        """Return every job that is kept, the newest first."""
        with self._database.read() as connection:
            rows = connection.execute(select(jobs).order_by(jobs.c.created.desc()))
            return [_record(row) for row in rows]

    def find(self, job_id: str) -> JobRecord | None:
        """Return one job, or None."""
        with self._database.read() as connection:
            row = connection.execute(select(jobs).where(jobs.c.id == job_id)).one_or_none()
        return None if row is None else _record(row)

    def ask(self, job_id: str, wish: Wish) -> None:
        """Ask the server of a job to stop it."""
        with self._database.write() as connection:
            connection.execute(update(jobs).where(jobs.c.id == job_id).values(wish=wish))

    def claim(self, *, silent: bool) -> list[JobRecord]:
        """Take over jobs whose server has gone, each once, whoever else asks at the same time.

        ``silent``: also those whose server has only not been heard of for a while.  What the dead
        server guarded is free again.
        """
        if not any(record.owner != self.owner for record in self.under_way()):
            return []
        seconds = STALE_SECONDS if silent else None
        taken: list[JobRecord] = []
        owners: set[str] = set()
        with self._database.write() as connection:
            now = self._database.now(connection)
            others = select(jobs).where(jobs.c.state.in_(UNDER_WAY), jobs.c.owner != self.owner)
            gone = [row.id for row in connection.execute(others) if _abandoned(row, now, seconds)]
            chosen = others.where(jobs.c.id.in_(gone)).order_by(jobs.c.id)
            for row in connection.execute(chosen.with_for_update(skip_locked=True)).all():
                if not _abandoned(row, now, seconds):
                    continue  # it was heard of before its row was locked
                lost = row.lost + (1 if row.owner else 0)
                mine = self._mine(now) | {"lost": lost}
                connection.execute(update(jobs).where(jobs.c.id == row.id).values(mine))
                owners |= {row.owner} - {""}
                taken.append(_record(row, lost=lost, owner=self.owner))
            if owners:
                _delete_unlocked(connection, works, works.c.owner.in_(owners))
        return sorted(taken, key=lambda record: record.created)

    def count(self) -> dict[str, int]:
        """Count the jobs in each state."""
        chosen = select(jobs.c.state, func.count()).group_by(jobs.c.state)
        with self._database.read() as connection:
            return {state: int(number) for state, number in connection.execute(chosen)}

    def _mine(self, now: float) -> dict[str, Any]:
        return {"host": host(), "process": os.getpid(), "owner": self.owner, "beat": now}


def _abandoned(row: Row[Any], now: float, seconds: float | None) -> bool:
    """Return whether a job is nobody's or its server has gone (see ``given_up``)."""
    return not row.owner or given_up(row, now, seconds)


def _delete_unlocked(connection: Connection, table: Table, condition: ColumnElement[bool]) -> None:
    """Delete rows by a condition, but for those that another transaction has locked."""
    free = select(table.c.id).where(condition).with_for_update(skip_locked=True)
    ids = connection.execute(free).scalars().all()
    connection.execute(delete(table).where(table.c.id.in_(ids)))


def _row(record: JobRecord) -> dict[str, Any]:
    row = asdict(record)
    return row | {name: None if row[name] is None else json.dumps(row[name]) for name in _JSON}


def _record(row: Row[Any], **other: Any) -> JobRecord:
    fields = {name: row._mapping[name] for name in JobRecord.__dataclass_fields__}
    fields |= {name: json.loads(fields[name]) for name in _JSON if fields[name] is not None}
    return JobRecord(**fields | other)
