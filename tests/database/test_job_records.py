"""Jobs of several servers on one PostgreSQL: no server waits for another in a circle."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace

import psycopg
import pytest
from waiting import eventually

from pointbrush.database.database import Limits
from pointbrush.database.job import Job
from pointbrush.teamwork.store import WorkspaceStore

LOCKED = "SELECT id FROM jobs WHERE id = %s FOR UPDATE NOWAIT"
WAITING = """SELECT count(*) FROM pg_stat_activity
    WHERE wait_event_type = 'Lock' AND datname = current_database()"""


def record(job_id: str, created: float) -> Job:
    return Job(id=job_id, kind="import", state="running", progress=0.5, created=created)


@pytest.fixture
def stores(labels_url: str) -> Iterator[tuple[WorkspaceStore, WorkspaceStore]]:
    limits = Limits(statement_seconds=20)
    with (
        closing(WorkspaceStore(labels_url, limits=limits)) as here,
        closing(WorkspaceStore(labels_url, limits=limits)) as there,
    ):
        yield here, there


@pytest.fixture
def other(labels_url: str) -> Iterator[psycopg.Connection]:
    """A transaction of somebody else."""
    with closing(psycopg.connect(labels_url)) as connection:
        yield connection


def test_jobs_are_claimed_past_one_that_another_server_writes(
    stores: tuple[WorkspaceStore, WorkspaceStore], other: psycopg.Connection
) -> None:
    here, there = stores
    for number, job_id in enumerate("abc"):
        there.jobs.add(record(job_id, float(number)))
    there.jobs.release(["a", "c"], "")
    other.execute(LOCKED, ["a"])
    other.execute(LOCKED, ["b"])
    assert [job.id for job in here.jobs.claim(silent=False)] == ["c"]
    other.rollback()
    assert [job.id for job in here.jobs.claim(silent=False)] == ["a"]
    assert here.jobs.claim(silent=False) == []


def test_jobs_are_claimed_oldest_first_and_each_once(
    stores: tuple[WorkspaceStore, WorkspaceStore],
) -> None:
    here, there = stores
    for number, job_id in enumerate("cab"):
        there.jobs.add(record(job_id, float(number)))
    there.jobs.release(list("abc"), "")
    assert [job.id for job in here.jobs.claim(silent=False)] == ["c", "a", "b"]
    assert there.jobs.claim(silent=False) == []
    assert there.jobs.update([record("a", 1.0)]) == {"a"}


def test_jobs_are_written_in_the_order_of_their_ids(
    stores: tuple[WorkspaceStore, WorkspaceStore],
    other: psycopg.Connection,
    labels_url: str,
) -> None:
    here, _ = stores
    records = [record("b", 0.0), record("a", 1.0)]
    for each in records:
        here.jobs.add(each)
    other.execute(LOCKED, ["a"])
    with (
        closing(psycopg.connect(labels_url, autocommit=True)) as looking,
        ThreadPoolExecutor(1) as pool,
    ):
        lost = pool.submit(here.jobs.update, [replace(each, progress=0.7) for each in records])
        eventually(lambda: looking.execute(WAITING).fetchone() == (1,))
        try:
            other.execute(LOCKED, ["b"])  # nobody has it who waits for the other one
        finally:
            other.rollback()
        assert lost.result() == set()
    assert {job.progress for job in here.jobs.all()} == {0.7}
