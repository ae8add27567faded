"""However a server ends, its worker processes end too."""

from __future__ import annotations

import os
import signal
import sys
import time
from pathlib import Path

import pytest

from tests.faults.server import running
from tests.waiting import PATIENCE, eventually

DATA = Path(__file__).parents[2] / "data" / "juggling"


def children(pid: int) -> set[int]:
    """Processes that ``pid`` and its children started and that still run."""
    found: set[int] = set()
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            fields = (entry / "stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if int(fields[1]) == pid and fields[0] != "Z":
            found |= {int(entry.name)} | children(int(entry.name))
    return found


def alive(pids: set[int]) -> set[int]:
    result = set()
    for pid in pids:
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
        except OSError:
            continue
        if state != "Z":
            result.add(pid)
    return result


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL])
def test_workers_end_with_the_server(tmp_path: Path, how: signal.Signals) -> None:
    with running(tmp_path / "workspace", POINTBRUSH_IMPORT_ROOTS=str(DATA.parent)) as server:
        with server.api() as api:
            job = api.post("sequences", json={"path": str(DATA / "0000.npz")})
            job = job.raise_for_status().json()
            while job["state"] in ("queued", "running"):
                time.sleep(0.1)
                job = api.get(f"jobs/{job['id']}").json()
            assert job["state"] == "done", job["error"]
        workers = children(server.process.pid)
        assert workers
        if how == signal.SIGINT:  # as Ctrl+C does, which all processes of a terminal get
            for worker in workers:
                os.kill(worker, how)
        server.process.send_signal(how)
        status = server.process.wait(PATIENCE)
    assert how == signal.SIGKILL or status == 0
    eventually(lambda: not alive(workers))
    assert "Traceback" not in server.stderr
