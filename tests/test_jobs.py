"""Jobs in real worker processes: progress, items, cancel, failure, a worker that dies."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from pointbrush.errors import BadInputError, ConflictError, NotFoundError
from pointbrush.jobs import Channel, Job, JobRunner


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


class Seen:
    """Everything that a runner told us."""

    def __init__(self) -> None:
        self.jobs: list[Job] = []
        self.items: list[Any] = []
        self.finished: list[bool] = []
        self.done = 0

    def finish(self, _: Job, cancelled: bool) -> dict[str, Any]:
        self.finished.append(cancelled)
        return {"items": len(self.items)}

    def item(self, _: Job, value: Any) -> None:
        self.items.append(value)

    def end(self, _: Job) -> None:
        self.done += 1


@pytest.fixture
def seen() -> Seen:
    return Seen()


@pytest.fixture
def runner(seen: Seen) -> Iterator[JobRunner]:
    runner = JobRunner(seen.jobs.append, workers=1)
    yield runner
    runner.close()


def submit(runner: JobRunner, seen: Seen, work: Count) -> Job:
    return runner.submit("tracking", "s", work, seen.finish, seen.item, seen.end)


def test_a_job_reports_and_hands_over_everything_before_it_finishes(
    runner: JobRunner, seen: Seen
) -> None:
    job = runner.wait(submit(runner, seen, Count(50)).id, 60)
    assert (job.state, job.progress, job.result) == ("done", 1.0, {"items": 50})
    assert seen.items == list(range(50))
    assert [j.progress for j in seen.jobs] == sorted(j.progress for j in seen.jobs)
    assert (seen.finished, seen.done) == ([False], 1)


def test_cancel_stops_the_work_and_still_finishes(runner: JobRunner, seen: Seen) -> None:
    job = submit(runner, seen, Count(1000, pause=0.01))
    while not seen.items:
        time.sleep(0.01)
    runner.cancel(job.id)
    job = runner.wait(job.id, 60)
    assert job.state == "cancelled"
    assert len(seen.items) < 1000
    assert (seen.finished, seen.done) == ([True], 1)
    with pytest.raises(ConflictError):
        runner.cancel(job.id)


def test_a_queued_job_is_cancelled_before_it_starts(runner: JobRunner, seen: Seen) -> None:
    first = submit(runner, seen, Count(1000, pause=0.01))
    others = [submit(runner, seen, Count(1)) for _ in range(3)]
    runner.cancel(others[-1].id)
    assert runner.wait(others[-1].id, 60).state == "cancelled"
    runner.cancel(first.id)
    assert runner.wait(others[0].id, 60).state == "done"


def test_a_failure_is_one_sentence(runner: JobRunner, seen: Seen) -> None:
    job = runner.wait(submit(runner, seen, Count(fail="input")).id, 60)
    assert (job.state, job.error) == ("failed", "steps: expected more, got few")
    assert (seen.finished, seen.done) == ([], 1)


def test_a_bug_fails_the_job_not_the_runner(runner: JobRunner, seen: Seen) -> None:
    job = runner.wait(submit(runner, seen, Count(fail="bug")).id, 60)
    assert job.state == "failed"
    assert "oops" in str(job.error)
    assert runner.wait(submit(runner, seen, Count(1)).id, 60).state == "done"


def test_a_worker_that_dies_fails_its_job_and_the_next_one_runs(
    runner: JobRunner, seen: Seen
) -> None:
    job = runner.wait(submit(runner, seen, Count(fail="die")).id, 60)
    assert (job.state, "worker process died" in str(job.error)) == ("failed", True)
    assert runner.wait(submit(runner, seen, Count(1)).id, 60).state == "done"


def test_unknown_jobs_are_not_found(runner: JobRunner) -> None:
    with pytest.raises(NotFoundError):
        runner.job("nothing")


def test_workers_end_when_the_server_is_killed() -> None:
    script = (
        "import os, sys, time\n"
        "from pointbrush.jobs import JobRunner\n"
        "runner = JobRunner(print, workers=1)\n"
        "future = runner._submit(os.getpid)\n"
        "print(future.result(), flush=True)\n"
        "time.sleep(60)\n"
    )
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) as server:
        assert server.stdout is not None
        worker = int(server.stdout.readline())
        server.kill()
    deadline = time.monotonic() + 30
    while Path(f"/proc/{worker}").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not Path(f"/proc/{worker}").exists()


def test_close_cancels_what_runs(seen: Seen) -> None:
    runner = JobRunner(seen.jobs.append, workers=1)
    job = submit(runner, seen, Count(10_000, pause=0.01))
    while not seen.items:
        time.sleep(0.01)
    runner.close()
    assert runner.job(job.id).state == "cancelled"
