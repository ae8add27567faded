"""Jobs in the database, shared by its servers; they outlive the server that ran them."""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Iterable
from dataclasses import dataclass, fields
from typing import Any, Literal

from sqlalchemy import ColumnElement, Connection, Row, Table, delete, select, update

from pointbrush.database.database import Database
from pointbrush.database.guards import given_up, host
from pointbrush.database.job import Job
from pointbrush.database.lost_answers import write_once
from pointbrush.database.schema import jobs, works
from pointbrush.database.statements import insert
from pointbrush.errors import ConflictError

STALE_SECONDS = 30.0
"""Time without a heartbeat after which a job's server counts as ended."""
KEPT_JOBS = 1000
"""Limit of stored ended jobs; the oldest are removed first."""
UNDER_WAY = ("queued", "running")
INTERRUPTED = "a backup was made while the job ran; start it again"
TaskPatch = Literal["", "cancel", "keep"]
"""Request from another server for a job: to stop, or to stop and keep its results so far."""
_JSON = ("result", "request")


@dataclass(frozen=True, kw_only=True)
class JobRecord(Job):
    """A job as stored."""

    server: str = ""
    """The process that runs it; empty: none."""
    lost: int = 0
    """Number of servers that ended unexpectedly while it ran."""
    wish: TaskPatch = ""


class JobRecords:
    """The jobs of one database, for one of its servers; thread-safe.

    Rows are locked in the order of their ids, and rows locked by another server are skipped, which
    prevents deadlocks between servers of one database.
    """

    def __init__(self, database: Database, owner: str) -> None:
        """``owner`` identifies this process, as in its guards."""
        self._database, self.owner = database, owner

    def add(self, job: Job) -> None:
        """Store a new job, owned by this process.

        Raises ConflictError if a job with its id exists, UnavailableError.
        """

        def make(connection: Connection) -> bool:
            row = _row(job) | self._mine(self._database.now(connection)) | {"lost": 0, "wish": ""}
            # Waits for another server that may store the same job at the same moment.
            new = insert(jobs, sqlite=self._database.sqlite).values(row).on_conflict_do_nothing()
            counted = {"preserve_rowcount": True}
            if connection.execute(new, execution_options=counted).rowcount == 0:
                raise ConflictError(f"id: expected one of no job yet, got {job.id}")
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
            own = (jobs.c.id == job.id) & (jobs.c.owner == self.owner)
            return connection.scalar(select(jobs.c.id).where(own)) is not None or None

        write_once(self._database, make, find)

    def update(self, changed: Iterable[Job]) -> set[str]:
        """Store the progress of this process's jobs; return jobs that another process has taken."""
        lost: set[str] = set()
        with self._database.write() as connection:
            now = self._database.now(connection)
            for job in sorted(changed, key=lambda job: job.id):
                row = _row(job) | {"beat": now}
                own = (jobs.c.id == row.pop("id")) & (jobs.c.owner == self.owner)
                if connection.execute(update(jobs).where(own).values(row)).rowcount == 0:
                    lost.add(job.id)
        return lost

    def remove(self, ids: Collection[str]) -> None:
        """Remove jobs of this process."""
        own = jobs.c.id.in_(ids) & (jobs.c.owner == self.owner)
        with self._database.write() as connection:
            connection.execute(delete(jobs).where(own))

    def release(self, ids: Collection[str], message: str) -> None:
        """Release jobs of this process for another server to take."""
        own = jobs.c.id.in_(ids) & (jobs.c.owner == self.owner) & jobs.c.state.in_(UNDER_WAY)
        nobody = {"owner": "", "beat": 0.0, "state": "queued", "progress": 0.0, "message": message}
        with self._database.write() as connection:
            connection.execute(select(jobs.c.id).where(own).order_by(jobs.c.id).with_for_update())
            connection.execute(update(jobs).where(own).values(nobody))

    def under_way(self) -> list[JobRecord]:
        """Return all queued and running jobs, oldest first."""
        chosen = select(jobs).where(jobs.c.state.in_(UNDER_WAY)).order_by(jobs.c.created)
        with self._database.read() as connection:
            return [_record(row) for row in connection.execute(chosen)]

    def all(self) -> list[JobRecord]:
        """Return all stored jobs, newest first."""
        with self._database.read() as connection:
            rows = connection.execute(select(jobs).order_by(jobs.c.created.desc()))
            return [_record(row) for row in rows]

    def find(self, job_id: str) -> JobRecord | None:
        """Return one job, or None."""
        with self._database.read() as connection:
            row = connection.execute(select(jobs).where(jobs.c.id == job_id)).one_or_none()
        return None if row is None else _record(row)

    def ask(self, job_id: str, wish: TaskPatch) -> None:
        """Ask the server of a job to stop it."""
        with self._database.write() as connection:
            connection.execute(update(jobs).where(jobs.c.id == job_id).values(wish=wish))

    def claim(self, *, silent: bool) -> list[JobRecord]:
        """Take over jobs of ended servers, each job only once among concurrent servers.

        ``silent``: also jobs of servers without a recent heartbeat.  The guards of the ended
        servers are released.
        """
        if not any(record.server != self.owner for record in self.under_way()):
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
                    continue  # a heartbeat arrived before its row was locked
                lost = row.lost + (1 if row.owner else 0)
                mine = self._mine(now) | {"lost": lost}
                connection.execute(update(jobs).where(jobs.c.id == row.id).values(mine))
                owners |= {row.owner} - {""}
                taken.append(_record(row, lost=lost, server=self.owner))
            if owners:
                _delete_unlocked(connection, works, works.c.owner.in_(owners))
        return sorted(taken, key=lambda record: record.created)

    def _mine(self, now: float) -> dict[str, Any]:
        return {"host": host(), "process": os.getpid(), "owner": self.owner, "beat": now}


def _abandoned(row: Row[Any], now: float, seconds: float | None) -> bool:
    """Return whether a job has no owner or its server has ended (see ``given_up``)."""
    return not row.owner or given_up(row, now, seconds)


def _delete_unlocked(connection: Connection, table: Table, condition: ColumnElement[bool]) -> None:
    """Delete rows by a condition, except rows that another transaction has locked."""
    free = select(table.c.id).where(condition).with_for_update(skip_locked=True)
    ids = connection.execute(free).scalars().all()
    connection.execute(delete(table).where(table.c.id.in_(ids)))


def _row(job: Job) -> dict[str, Any]:
    row = {each.name: getattr(job, each.name) for each in fields(Job)}
    row["author"] = row.pop("owner")
    return row | {name: row[name] and json.dumps(row[name]) for name in _JSON}


def _record(row: Row[Any], **other: Any) -> JobRecord:
    found = row._mapping
    values = {each.name: found[each.name] for each in fields(JobRecord) if each.name in found}
    values |= {name: json.loads(found[name]) for name in _JSON if found[name] is not None}
    return JobRecord(**values | {"owner": row.author, "server": row.owner} | other)
