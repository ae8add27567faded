"""Uploads belong to the server that took them, until it has ended without a word."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

import pytest
from waiting import eventually

from tests.faults.server import running
from tests.faults.test_private import ended, scan, upload
from tests.web.test_ending import children


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_a_second_server_leaves_the_uploads_of_the_first(tmp_path: Path) -> None:
    workspace = tmp_path / "workspace"
    with running(workspace) as first, first.api() as api:
        assert ended(api, upload(api, "first.npy", scan()))["state"] == "done"
        workers = children(first.process.pid)
        for worker in workers:
            os.kill(worker, signal.SIGSTOP)
        waiting = [upload(api, f"scan{number}.npy", scan()) for number in range(2)]
        with running(workspace) as second, second.api() as other:
            assert len(list((workspace / "uploads").iterdir())) == 2
            for worker in workers:
                os.kill(worker, signal.SIGCONT)
            jobs = [ended(api, job) for job in waiting]
            assert [job["state"] for job in jobs] == ["done", "done"], jobs
            assert len(other.get("/sequences").json()) == 3

            for worker in workers:
                os.kill(worker, signal.SIGSTOP)
            upload(api, "lost.npy", scan())
            assert len(list((workspace / "uploads").iterdir())) == 1
            first.kill()
            for worker in workers:
                os.kill(worker, signal.SIGCONT)
            for beat in (workspace / "servers").glob("*/alive"):
                os.utime(beat, (1, 1))  # the one that lives beats again
            eventually(lambda: not list((workspace / "uploads").iterdir()))
            eventually(lambda: len(list((workspace / "servers").iterdir())) == 1)
            assert ended(other, upload(other, "next.npy", scan()))["state"] == "done"
            # A job's files go once it has said that it ended.
            eventually(lambda: not list((workspace / "uploads").iterdir()))
