"""Jobs when there are no files, threads or memory to begin them, or to take in what they find."""

from __future__ import annotations

import errno
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pointbrush.errors import UnavailableError
from pointbrush.jobs.runner import JobRunner
from pointbrush.system.resources import NO_THREAD
from pointbrush.workspace import Workspace
from tests.serving import settings_in
from tests.test_jobs import Count, Seen, seen, submit  # noqa: F401  # a fixture
from tests.waiting import PATIENCE, eventually


@pytest.fixture
def runner(seen: Seen) -> Iterator[JobRunner]:  # noqa: F811
    runner = JobRunner(seen.jobs.append, workers=1)
    yield runner
    runner.close()


@pytest.mark.parametrize("error", [OSError(errno.EMFILE, "too many"), MemoryError()])
def test_a_job_waits_until_a_worker_process_can_begin(
    runner: JobRunner,
    seen: Seen,  # noqa: F811
    monkeypatch: pytest.MonkeyPatch,
    error: Exception,
) -> None:
    workers = runner._workers
    begin, refusals = workers.submit, iter([error])

    def refused_once(*work: Any) -> Any:
        for refusal in refusals:
            raise refusal
        return begin(*work)

    monkeypatch.setattr(workers, "submit", refused_once)
    job = runner.wait(submit(runner, seen, Count(2)).id, PATIENCE)
    assert (job.state, job.result) == ("done", {"items": 2})
    assert any("memory" in each.message for each in seen.jobs)


def test_what_was_handed_out_in_vain_is_not_heard(
    runner: JobRunner,
    seen: Seen,  # noqa: F811
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    workers = runner._workers
    workers.submit(int).result(PATIENCE)  # a process that begins at once what it is given
    begin, refusals = workers.submit, iter([MemoryError()])

    def kept_and_refused(*work: Any) -> Any:
        future = begin(*work)  # as a pool does that cannot begin another process
        for refusal in refusals:
            raise refusal
        return future

    monkeypatch.setattr(workers, "submit", kept_and_refused)
    job = runner.wait(submit(runner, seen, Count(3)).id, PATIENCE)
    assert (job.state, seen.items) == ("done", [0, 1, 2])


def test_a_worker_that_no_thread_can_listen_to_is_tried_again(
    runner: JobRunner,
    seen: Seen,  # noqa: F811
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    start, refusals = threading.Thread.start, iter([RuntimeError(NO_THREAD)])

    def refused_once(thread: threading.Thread) -> None:
        if thread.name.endswith("(_listen)"):
            for refusal in refusals:
                raise refusal
        start(thread)

    monkeypatch.setattr(threading.Thread, "start", refused_once)
    job = runner.wait(submit(runner, seen, Count(3)).id, PATIENCE)
    assert (job.state, seen.items) == ("done", [0, 1, 2])


def test_findings_that_there_is_no_memory_for_fail_the_job(
    runner: JobRunner,
    seen: Seen,  # noqa: F811
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def full(*_: Any) -> None:
        raise MemoryError

    monkeypatch.setattr(seen, "receive", full)
    job = runner.wait(submit(runner, seen, Count(3)).id, PATIENCE)
    assert job.state == "failed"
    assert "too little memory" in str(job.error)
    assert seen.done == 1


def test_a_job_that_no_thread_can_begin_for_is_refused_and_forgotten(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    workspace = Workspace(settings_in(tmp_path))
    workspace.keep_jobs()
    start = threading.Thread.start

    def refuse(thread: threading.Thread) -> None:
        if thread.name.endswith("(_supervise)"):
            raise RuntimeError(NO_THREAD)
        start(thread)

    try:
        monkeypatch.setattr(threading.Thread, "start", refuse)
        with pytest.raises(UnavailableError, match="memory"):
            workspace.imports.begin_sample(frames=2)
        monkeypatch.setattr(threading.Thread, "start", start)
        assert workspace.jobs.all() == []
        eventually(lambda: not workspace.labels.jobs.all())
        assert workspace.labels.guards.importing() == set()
    finally:
        workspace.close()
