"""Workers that die and schedulers that begin anew, as real processes."""

from __future__ import annotations

import os
import time
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import pytest

from pointbrush.database.job import Job
from pointbrush.jobs.runner import JobRunner, Receiver
from pointbrush.jobs.worker import Channel
from pointbrush.sequences import verify
from pointbrush.work.folder_store import FolderTarget
from pointbrush.work.imports.importing import ImportWork
from pointbrush.work.imports.requests import ImportRequest
from tests.dask_cluster import DaskCluster
from tests.test_jobs import Count, Seen, cluster, scheduler, seen  # noqa: F401  # fixtures
from tests.waiting import PATIENCE, eventually


@dataclass(frozen=True)
class DieOnce:
    """Work whose first worker dies half-way."""

    mark: Path
    steps: int = 6

    def __call__(self, channel: Channel) -> None:
        for step in range(self.steps):
            channel.item(step)
            if step == self.steps // 2 and not self.mark.exists():
                self.mark.touch()
                time.sleep(0.2)  # what was sent is on its way
                os._exit(1)


def test_a_job_whose_worker_died_is_begun_once_more(
    seen: Seen,  # noqa: F811
    scheduler: str,  # noqa: F811
    tmp_path: Path,
) -> None:
    with closing(JobRunner(seen.jobs.append, workers=1, scheduler=scheduler)) as runner:
        job = runner.submit(Job(kind="tracking", sequence="s"), DieOnce(tmp_path / "died"), seen)
        other = runner.submit(Job(kind="tracking", sequence="t"), Count(2), Receiver())
        job, other = runner.wait(job.id, PATIENCE), runner.wait(other.id, PATIENCE)
    assert (job.state, job.error, other.state) == ("done", None, "done")
    assert seen.items == list(range(6))
    assert (seen.finished, seen.done) == ([False], 1)


def test_a_scheduler_that_begins_anew_is_found_and_jobs_say_what_they_wait_for(
    seen: Seen,  # noqa: F811
) -> None:
    pytest.importorskip("distributed")
    with DaskCluster() as dask:
        dask.start("scheduler")
        runner = JobRunner(seen.jobs.append, scheduler=dask.address)
        with closing(runner):
            first = submit(runner, seen)
            eventually(lambda: "expected workers" in runner.known.get(first.id).message)
            dask.start("worker")
            assert runner.wait(first.id, PATIENCE).state == "done"
            dask.kill("worker")
            dask.kill("scheduler")
            second = submit(runner, seen)
            eventually(lambda: "scheduler" in runner.known.get(second.id).message)
            dask.start("scheduler")
            dask.start("worker")
            job = runner.wait(second.id, PATIENCE)
            assert (job.state, job.error) == ("done", None)


def submit(runner: JobRunner, seen: Seen) -> Job:  # noqa: F811
    return runner.submit(Job(kind="tracking", sequence="s"), Count(2), seen)


@dataclass(frozen=True)
class DieAtTheEnd:
    """An import whose first worker dies when the recording is there, before it is told."""

    work: ImportWork
    mark: Path

    def __call__(self, channel: Channel) -> None:
        self.work(channel)
        if not self.mark.exists():
            self.mark.touch()
            os._exit(1)


def test_an_import_whose_worker_died_at_the_end_is_made_anew(
    seen: Seen,  # noqa: F811
    tmp_path: Path,
) -> None:
    (tmp_path / "scan.xyz").write_text("1 2 3\n4 5 6\n")
    target = tmp_path / "sequences" / "scan"
    target.parent.mkdir()
    work = ImportWork(ImportRequest((tmp_path / "scan.xyz",)), FolderTarget(target), "scan")
    with closing(JobRunner(seen.jobs.append, workers=1)) as runner:
        died = DieAtTheEnd(work, tmp_path / "died")
        job = runner.submit(Job(kind="import", sequence="scan"), died, seen)
        job = runner.wait(job.id, PATIENCE)
    assert (job.state, job.error) == ("done", None)
    assert (tmp_path / "died").exists()
    assert verify(target) == []
