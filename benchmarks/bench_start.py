"""Start: processor time of commands, and of a server until it answers /readyz.

python benchmarks/bench_start.py

The peer is an interpreter that imports what the server is made of, and does nothing with it.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import httpx

ROUNDS = 7
CLI = [sys.executable, "-m", "pointbrush.cli"]
PEER = [sys.executable, "-c", "import fastapi, numpy, pydantic, sqlalchemy, uvicorn"]


def ended(command: list[str]) -> float:
    """CPU seconds of a process and its children, from its start to its end."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, command
    return usage.ru_utime + usage.ru_stime


def ready(workspace: Path) -> float:
    """CPU seconds of a server until it has answered /readyz with 200."""
    command = [*CLI, "serve", "--workspace", str(workspace), "--port", "0", "--token", "t" * 32]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        assert "ready at" in line, line
        url = line.split("ready at ")[1].split("/?")[0].strip()
        httpx.get(f"{url}/readyz").raise_for_status()
        fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    finally:
        process.terminate()
        process.wait(30)


def main() -> None:
    """Print the median of each, taken by turns."""
    with tempfile.TemporaryDirectory() as folder:
        workspace = Path(folder)
        candidates: dict[str, Callable[[], float]] = {
            "imports of FastAPI, NumPy, Pydantic, SQLAlchemy, uvicorn": partial(ended, PEER),
            "pointbrush --help": partial(ended, [*CLI, "--help"]),
            "pointbrush info": partial(ended, [*CLI, "info", "--workspace", folder]),
            "a server that is ready": partial(ready, workspace),
        }
        seconds: dict[str, list[float]] = {name: [] for name in candidates}
        for counted in [False] + [True] * ROUNDS:
            for name, measure in candidates.items():
                spent = measure()
                if counted:
                    seconds[name].append(spent)
    print("start, CPU seconds")
    for name, each in seconds.items():
        print(f"  {name:60} {statistics.median(each):6.2f}")


if __name__ == "__main__":
    main()
