"""However a server ends, its worker processes end too."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import httpx
import pytest
from waiting import PATIENCE, eventually

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
    command = [sys.executable, "-m", "pointbrush.cli", "serve", "--port", "0", "--workers", "1"]
    command += ["--workspace", str(tmp_path / "workspace"), "--import-roots", str(DATA.parent)]
    environment = os.environ | {"POINTBRUSH_TOKEN": "token-of-the-ending-test"}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as server:
        assert server.stdout is not None
        try:
            url = next(line for line in server.stdout if "ready at" in line).split()[-1]
            headers = {"Authorization": "Bearer token-of-the-ending-test"}
            with httpx.Client(base_url=url.split("?")[0], headers=headers) as api:
                body = {"path": str(DATA / "0000.npz")}
                job = api.post("api/v1/sequences", json=body).raise_for_status().json()
                while job["state"] in ("queued", "running"):
                    time.sleep(0.1)
                    job = api.get(f"api/v1/jobs/{job['id']}").json()
                assert job["state"] == "done", job["error"]
            workers = children(server.pid)
            assert workers
            server.send_signal(how)
            status = server.wait(PATIENCE)
        finally:
            server.kill()
    assert how == signal.SIGKILL or status == 0
    eventually(lambda: not alive(workers))
