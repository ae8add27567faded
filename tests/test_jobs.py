"""Jobs in real worker processes: progress, items, cancel, failure, a worker that dies."""

from __future__ import annotations

import io
import logging
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
import uuid
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from distributed import LocalCluster

from pointbrush.database.job import Job
from pointbrush.errors import BadInputError, ConflictError, NotFoundError, UnavailableError
from pointbrush.jobs import worker
from pointbrush.jobs.runner import JobRunner, Receiver
from pointbrush.jobs.worker import Channel, DaskExecutor, brief_logs
from pointbrush.values.runs import TrackingRequest
from pointbrush.workspace import Workspace
from tests.serving import add_sequence, settings_in
from tests.waiting import PATIENCE, eventually


@dataclass(frozen=True)
class Count:
    """Work that reports each step, and can go wrong in several ways."""

    steps: int = 3
    pause: float = 0.0
    fail: str = ""

    def __call__(self, channel: Channel) -> None:
        for step in range(self.steps):
            channel.item(step)
            channel.progress((step + 1) / self.steps, f"step {step}")
            time.sleep(self.pause)
        if self.fail == "input":
            raise BadInputError("steps: expected more, got few")
        if self.fail == "bug":
            raise ZeroDivisionError("oops")
        if self.fail == "die":
            os._exit(1)


class Seen(Receiver):
    """Everything that a runner told us."""

    def __init__(self) -> None:
        super().__init__()
        self.jobs: list[Job] = []
        self.finished: list[bool] = []
        self.done = 0

    def finish(self, _: Job, cancelled: bool) -> dict[str, Any]:
        self.finished.append(cancelled)
        return {"items": len(self.items)}

    def end(self, _: Job) -> None:
        self.done += 1


@pytest.fixture
def seen() -> Seen:
    return Seen()


@pytest.fixture(scope="module")
def cluster() -> Iterator[str]:
    """A Dask scheduler with one worker, in processes of their own; its address."""
    options = {"n_workers": 1, "threads_per_worker": 1, "host": "127.0.0.1"}
    with LocalCluster(**options, dashboard_address="127.0.0.1:0", silence_logs=50) as started:
        yield started.scheduler_address


def temporary_with(given: str | None) -> str:
    """Folder for temporary files of this process, once TMPDIR is ``given`` to it, or taken."""
    os.environ.pop("TMPDIR", None)
    if given is not None:
        os.environ["TMPDIR"] = given
    return tempfile.gettempdir()


def test_a_worker_of_a_cluster_has_the_servers_folder_for_temporary_files(
    cluster: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own, server = tmp_path / "own", tmp_path / "server"
    own.mkdir()
    server.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(server))
    executor = DaskExecutor(cluster)
    try:
        executor.submit(temporary_with, None).result(60)
        assert executor.submit(temporary_with, str(own)).result(60) == str(server)
        assert executor.submit(temporary_with, None).result(60) != str(server)
    finally:
        executor.shutdown()


@pytest.fixture(params=["processes", "dask"])
def scheduler(request: pytest.FixtureRequest) -> str:
    """What jobs run on: nothing for local processes."""
    return request.getfixturevalue("cluster") if request.param == "dask" else ""


@pytest.fixture
def runner(seen: Seen, scheduler: str) -> Iterator[JobRunner]:
    runner = JobRunner(seen.jobs.append, workers=1, scheduler=scheduler)
    yield runner
    runner.close()


def submit(runner: JobRunner, seen: Seen, work: Count) -> Job:
    return runner.submit(Job(kind="tracking", sequence="s"), work, seen)


def test_a_job_reports_and_hands_over_everything_before_it_finishes(
    runner: JobRunner, seen: Seen
) -> None:
    job = runner.wait(submit(runner, seen, Count(50)).id, PATIENCE)
    assert (job.state, job.progress, job.result) == ("done", 1.0, {"items": 50})
    assert seen.items == list(range(50))
    assert [j.progress for j in seen.jobs] == sorted(j.progress for j in seen.jobs)
    assert (seen.finished, seen.done) == ([False], 1)


@dataclass(frozen=True)
class Priority:
    """Work that hands over the priority it runs at."""

    def __call__(self, channel: Channel) -> None:
        channel.item(os.getpriority(os.PRIO_PROCESS, 0))


def test_work_gives_way_to_the_server(seen: Seen) -> None:
    with closing(JobRunner(seen.jobs.append, workers=1)) as runner:
        job = runner.submit(Job(kind="tracking", sequence="s"), Priority(), seen)
        assert runner.wait(job.id, PATIENCE).state == "done"
    server = os.getpriority(os.PRIO_PROCESS, 0)
    assert seen.items[0] > server or server == 19  # which nothing can give way to


def leave_a_mark() -> None:
    os.environ["POINTBRUSH_TEST_MARK"] = "ready"


@dataclass(frozen=True)
class Mark:
    """Work that hands over what was left behind in its process."""

    def __call__(self, channel: Channel) -> None:
        channel.item(os.environ.get("POINTBRUSH_TEST_MARK"))


def test_a_worker_that_was_made_ready_does_the_next_job(seen: Seen) -> None:
    with closing(JobRunner(seen.jobs.append, workers=1)) as runner:
        runner.make_ready(leave_a_mark)
        job = runner.submit(Job(kind="tracking", sequence="s"), Mark(), seen)
        assert runner.wait(job.id, PATIENCE).state == "done"
    assert seen.items == ["ready"]
    others = multiprocessing.active_children()
    runner.make_ready(leave_a_mark)  # nothing begins any more
    assert multiprocessing.active_children() == others


def test_cancel_stops_the_work_and_still_finishes(runner: JobRunner, seen: Seen) -> None:
    job = submit(runner, seen, Count(1000, pause=0.01))
    eventually(lambda: seen.items)
    runner.cancel(job.id)
    job = runner.wait(job.id, PATIENCE)
    assert job.state == "cancelled"
    assert len(seen.items) < 1000
    assert (seen.finished, seen.done) == ([True], 1)
    with pytest.raises(ConflictError):
        runner.cancel(job.id)


def test_a_queued_job_is_cancelled_before_it_starts(runner: JobRunner, seen: Seen) -> None:
    first = submit(runner, seen, Count(1000, pause=0.01))
    others = [submit(runner, seen, Count(1)) for _ in range(3)]
    runner.cancel(others[-1].id)
    assert runner.wait(others[-1].id, PATIENCE).state == "cancelled"
    runner.cancel(first.id)
    assert runner.wait(others[0].id, PATIENCE).state == "done"


def test_a_failure_is_one_sentence(runner: JobRunner, seen: Seen) -> None:
    job = runner.wait(submit(runner, seen, Count(fail="input")).id, PATIENCE)
    assert (job.state, job.error) == ("failed", "steps: expected more, got few")
    assert (seen.finished, seen.done) == ([], 1)


def test_a_bug_fails_the_job_not_the_runner(runner: JobRunner, seen: Seen) -> None:
    job = runner.wait(submit(runner, seen, Count(fail="bug")).id, PATIENCE)
    assert job.state == "failed"
    assert "ZeroDivisionError" in str(job.error)
    assert runner.wait(submit(runner, seen, Count(1)).id, PATIENCE).state == "done"


def test_a_worker_that_dies_fails_its_job_and_the_next_one_runs(
    runner: JobRunner, seen: Seen
) -> None:
    job = runner.wait(submit(runner, seen, Count(fail="die")).id, PATIENCE)
    assert (job.state, "worker process died" in str(job.error)) == ("failed", True)
    assert runner.wait(submit(runner, seen, Count(1)).id, PATIENCE).state == "done"


def test_unknown_jobs_are_not_found(runner: JobRunner) -> None:
    with pytest.raises(NotFoundError):
        runner.known.get("nothing")


def test_workers_end_when_the_server_is_killed() -> None:
    script = (
        "import os, sys, time\n"
        "from pointbrush.jobs.worker import Workers\n"
        "future = Workers(1, '').submit(os.getpid)\n"
        "print(future.result(), flush=True)\n"
        "time.sleep(60)\n"
    )
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) as server:
        assert server.stdout is not None
        worker = int(server.stdout.readline())
        server.kill()
    eventually(lambda: not Path(f"/proc/{worker}").exists())


def test_close_cancels_what_runs(seen: Seen, scheduler: str) -> None:
    runner = JobRunner(seen.jobs.append, workers=1, scheduler=scheduler)
    job = submit(runner, seen, Count(10_000, pause=0.01))
    eventually(lambda: seen.items)
    runner.close()
    assert runner.known.get(job.id).state == "cancelled"


@pytest.mark.parametrize("address", ["", "localhost", "http://localhost:1", "tcp://localhost"])
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(BadInputError, match="expected tcp://host:port"):
        DaskExecutor(address)


def test_a_scheduler_that_is_not_there_is_said_at_once(
    seen: Seen, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worker, "CONNECT_SECONDS", 0.5)
    with pytest.raises(UnavailableError, match="expected a Dask scheduler at"):
        JobRunner(seen.jobs.append, scheduler="tcp://127.0.0.1:9")


def test_a_recording_is_tracked_on_the_cluster(cluster: str, tmp_path: Path) -> None:
    settings = replace(settings_in(tmp_path), scheduler=cluster)
    add_sequence(settings, "wall", frames=3, points=4_000)
    with closing(Workspace(settings)) as workspace:
        workspace.labels.create_label("wall", "anna", name="pin")
        stroke = {"id": str(uuid.uuid4()), "label": 1, "radius": 0.3}
        workspace.strokes.apply("wall", 0, stroke | {"samples": [{"origin": [0, 0, 3]}]}, "anna")
        job = workspace.tracking.start("wall", TrackingRequest("icp", start=0, stop=2), "anna")
        job = workspace.runner.wait(job.id, PATIENCE)
        assert (job.state, job.error) == ("done", None)
        assert workspace.labels.counts("wall")[1, 1][0] > 0


def test_dask_says_in_a_line_what_it_lost() -> None:
    told, logger = io.StringIO(), logging.getLogger("distributed.lost")
    handler = logging.StreamHandler(told)
    logger.addHandler(handler)
    try:
        brief_logs()
        raise ConnectionError("the other end\nis gone")
    except ConnectionError:
        logger.exception("a stream\nhas ended")
    finally:
        logger.removeHandler(handler)
    assert told.getvalue() == "distributed.lost: a stream (ConnectionError: the other end)\n"
