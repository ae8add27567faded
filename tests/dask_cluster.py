"""A Dask scheduler and a worker as processes of this machine, which come and go."""

from __future__ import annotations

import subprocess
import sys

from tests.ports import free_port, listening
from tests.waiting import PATIENCE, eventually


class DaskCluster:
    """A scheduler at a port of its own and one worker, neither of which runs at first."""

    def __init__(self) -> None:
        self._port = free_port()
        self.address = f"tcp://127.0.0.1:{self._port}"
        scheduler = ["--host", "127.0.0.1", "--port", str(self._port), "--no-dashboard"]
        worker = [self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        self._commands = {
            "scheduler": ["distributed.cli.dask_scheduler", *scheduler],
            "worker": ["distributed.cli.dask_worker", *worker, "--host", "127.0.0.1"],
        }
        self._running: dict[str, subprocess.Popen[bytes]] = {}

    def __enter__(self) -> DaskCluster:
        return self

    def __exit__(self, *_: object) -> None:
        for part in list(self._running):
            self.kill(part)

    def start(self, part: str) -> None:
        """Begin the "scheduler", and wait until it listens, or the "worker"."""
        command = [sys.executable, "-m", *self._commands[part]]
        silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self._running[part] = subprocess.Popen(command, **silent)
        if part == "scheduler":
            eventually(lambda: listening(self._port))

    def kill(self, part: str) -> None:
        """End one of them without a word."""
        process = self._running.pop(part)
        process.kill()
        process.wait(PATIENCE)
