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

from tests.forked import ForkedCommand, first_line
from tests.serving import add_sequence, settings_in
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
        self._printed = tempfile.TemporaryDirectory()
        self._kept: str | None = None
        stdout, stderr = self._out("stdout"), self._out("stderr")
        arguments = ("serve", "--port", str(port))
        environment = {
            **os.environ,
            **PLENTY,
            "POINTBRUSH_WORKSPACE": str(workspace),
            "POINTBRUSH_TOKEN": TOKEN,
            **environment,
        }
        self.process: ForkedCommand | subprocess.Popen[bytes]
        if prefix or "LD_PRELOAD" in environment:
            command = [*prefix, sys.executable, "-m", "pointbrush.cli", *arguments]
            with stdout.open("ab") as out, stderr.open("ab") as err:
                self.process = subprocess.Popen(command, stdout=out, stderr=err, env=environment)
        else:
            self.process = ForkedCommand(arguments, environment, stdout, stderr)
        line = first_line(self.process, stdout)
        assert line.startswith("pointbrush ready at "), self.stderr
        self.url = line.split()[-1].split("/?token=")[0]

    def _out(self, stream: str) -> Path:
        path = Path(self._printed.name) / stream
        path.touch()
        return path

    @property
    def port(self) -> int:
        """The port that it listens on."""
        return int(self.url.rpartition(":")[2])

    @property
    def stderr(self) -> str:
        """What it has said so far; all of it once it has ended."""
        if self._kept is not None:
            return self._kept
        return (Path(self._printed.name) / "stderr").read_text(errors="replace")

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
        if self._kept is None:
            self._kept = self.stderr
            self._printed.cleanup()
            if self._kept:
                print(self._kept, file=sys.stderr)


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


@contextmanager
def two_servers(
    folder: Path, url: str, *, frames: int, points: int
) -> Iterator[tuple[ServerProcess, ServerProcess]]:
    """Two servers of one workspace with a recording ``ball``, on the database at ``url``."""
    settings = settings_in(folder)
    add_sequence(settings, "ball", frames=frames, points=points)
    with (
        running(settings.workspace, POINTBRUSH_DATABASE=url) as here,
        running(settings.workspace, POINTBRUSH_DATABASE=url) as there,
    ):
        yield here, there
