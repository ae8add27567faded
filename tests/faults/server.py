"""`pointbrush serve` in a process of its own, to be killed, stopped and starved."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import httpx

from tests.waiting import PATIENCE

TOKEN = "test-token-of-the-owner"
PLENTY = {"POINTBRUSH_REQUESTS_PER_SECOND": "100000", "POINTBRUSH_WORKERS": "1"}


class ServerProcess:
    """A running server; what it said on stderr is kept."""

    def __init__(
        self,
        workspace: Path,
        *,
        prefix: Sequence[str] = (),
        port: int = 0,
        **environment: str,
    ) -> None:
        """``prefix``: the command that runs the server's command, as another user say.

        ``port``: 0 for a free one.
        """
        self.workspace = workspace
        self._stderr = tempfile.TemporaryFile()  # noqa: SIM115 – closed with the process
        self.process = subprocess.Popen(
            [*prefix, sys.executable, "-m", "pointbrush.cli", "serve", "--port", str(port)],
            stdout=subprocess.PIPE,
            stderr=self._stderr,
            text=True,
            env={
                **os.environ,
                **PLENTY,
                "POINTBRUSH_WORKSPACE": str(workspace),
                "POINTBRUSH_TOKEN": TOKEN,
                **environment,
            },
        )
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line.startswith("pointbrush ready at "), self.stderr
        self.url = line.split()[-1].split("/?token=")[0]

    @property
    def port(self) -> int:
        """The port that it listens on."""
        return int(self.url.rpartition(":")[2])

    @property
    def stderr(self) -> str:
        if not self._stderr.closed:
            self._stderr.seek(0)
            self._said = self._stderr.read().decode(errors="replace")
        return self._said

    def api(self, token: str = TOKEN, timeout: float = PATIENCE) -> httpx.Client:
        headers = {"Authorization": f"Bearer {token}"}
        return httpx.Client(base_url=f"{self.url}/api/v1", headers=headers, timeout=timeout)

    def kill(self) -> None:
        """SIGKILL; no error when it has ended already."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGKILL)
        self.process.wait(PATIENCE)
        self._close()

    def stop(self, timeout: float = PATIENCE) -> int:
        """SIGTERM; returns the exit code."""
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(timeout)
        self._close()
        return code

    def _close(self) -> None:
        assert self.process.stdout is not None
        if self.process.stdout.closed:
            return
        self.process.stdout.close()
        if self.stderr:
            print(self.stderr, file=sys.stderr)
        self._stderr.close()


@contextmanager
def running(
    workspace: Path, *, prefix: Sequence[str] = (), **environment: str
) -> Iterator[ServerProcess]:
    """A server until the context ends, which kills it if nobody else has."""
    server = ServerProcess(workspace, prefix=prefix, **environment)
    try:
        yield server
    finally:
        server.kill()
