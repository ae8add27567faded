"""Jobs that are begun again, at the moment in which their next server ends too."""

from __future__ import annotations

import logging
import threading
from contextlib import closing
from pathlib import Path

import pytest

from pointbrush.database.job import Job
from pointbrush.jobs.runner import JobRunner, Receiver
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.work.job_registry import JobRegistry
from tests.test_jobs import Count
from tests.waiting import PATIENCE


def test_a_job_begun_again_while_its_server_ends_is_left_to_the_next_one(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    url = f"sqlite:///{tmp_path / 'labels.sqlite'}"
    begins, closed = threading.Event(), threading.Event()
    told: list[Job] = []

    def begin(job: Job) -> None:
        begins.set()
        assert closed.wait(PATIENCE)
        runner.submit(job, Count(), Receiver())

    waiting = Job(kind="import", sequence="s", request={"call": "again"})
    with closing(WorkspaceStore(url)) as store, caplog.at_level(logging.WARNING):
        store.jobs.add(waiting)
        store.jobs.release([waiting.id], "")
        runner = JobRunner(told.append, workers=1)
        runner.make_ready(int)
        book = JobRegistry(store, runner, told.append, {"again": begin}, keep=lambda _job: None)
        book.open()
        assert begins.wait(PATIENCE)
        runner.close()
        closed.set()
        book.close()
        left = store.jobs.find(waiting.id)
    assert [entry for entry in caplog.records if entry.exc_info] == []
    assert left is not None
    assert (left.state, left.server, left.error) == ("queued", "", None)
