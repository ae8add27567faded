"""The command ``pointbrush``, and functions, in processes forked from one with all imports done.

Imports are most of the start of a server, and tests start hundreds.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import chdir, contextmanager
from multiprocessing import forkserver
from multiprocessing.connection import Connection, arbitrary_address
from pathlib import Path
from typing import Any

from pointbrush.cli import main
from pointbrush.jobs import worker
from tests.waiting import PATIENCE, eventually

FORKSERVER = multiprocessing.get_context("forkserver")
FORKSERVER.set_forkserver_preload(
    [
        *("pointbrush.cli", "pointbrush.web.server", "alembic.command", "pytest"),
        *("psycopg", "sqlalchemy.dialects.postgresql.psycopg", "scipy.sparse.csgraph"),
        *("httpx", "anyio._backends._asyncio", "uvicorn.loops.uvloop", "uvicorn.lifespan.on"),
        *("idna.core", "tests.preloaded", "tests.e2e.server"),
    ]
)


ROOT = Path(__file__).parent.parent
ensure_running = forkserver.ensure_running


def ensure_running_from_root() -> None:
    """Start the fork server where it finds ``tests.preloaded``, in whichever folder a test is."""
    if fork_server._forkserver_pid is None:
        with chdir(ROOT):
            ensure_running()
    else:
        ensure_running()


fork_server = forkserver._forkserver  # type: ignore[attr-defined]
fork_server.ensure_running = ensure_running_from_root


class ForkedCommand:
    """A running command, with the methods of ``subprocess.Popen`` that tests use."""

    def __init__(
        self,
        arguments: Sequence[str],
        environment: Mapping[str, str],
        stdout: Path,
        stderr: Path,
        cwd: Path | None = None,
    ) -> None:
        """``environment``: all of it; what is printed is added to the files."""
        stdout.touch()
        given = (
            tuple(arguments),
            dict(environment),
            Path.cwd() if cwd is None else cwd,
            stdout,
            stderr,
        )
        self._process = FORKSERVER.Process(target=run_here, args=given)
        self._process.start()
        assert self._process.pid is not None
        self.pid = self._process.pid

    def poll(self) -> int | None:
        return self._process.exitcode

    def wait(self, timeout: float) -> int:
        self._process.join(timeout)
        code = self.poll()
        if code is None:
            raise subprocess.TimeoutExpired("pointbrush", timeout)
        return code

    def send_signal(self, number: signal.Signals) -> None:
        if self.poll() is None:
            os.kill(self.pid, number)


def first_line(process: ForkedCommand | subprocess.Popen[bytes], stdout: Path) -> str:
    """Wait for the line by which a server says that it is ready; "" when it has ended."""
    eventually(lambda: "\n" in stdout.read_text() or process.poll() is not None)
    return stdout.read_text().partition("\n")[0]


def run(
    *arguments: str, environment: Mapping[str, str] | None = None, cwd: Path | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a command to its end."""
    with tempfile.TemporaryDirectory() as folder:
        stdout, stderr = Path(folder) / "stdout", Path(folder) / "stderr"
        command = ForkedCommand(arguments, environment or os.environ, stdout, stderr, cwd)
        code = command.wait(PATIENCE)
        return subprocess.CompletedProcess(arguments, code, stdout.read_text(), stderr.read_text())


def run_here(
    arguments: Sequence[str],
    environment: Mapping[str, str],
    cwd: Path,
    stdout: Path,
    stderr: Path,
) -> None:
    """Be the command, as from a terminal of its own."""
    os.setsid()
    os.chdir(cwd)
    for number, path in ((1, stdout), (2, stderr)):
        with path.open("ab") as file:
            os.dup2(file.fileno(), number)
    os.environ.clear()
    os.environ.update(environment)
    fork_workers()
    sys.exit(main(list(arguments)))


def begin_worker_in(environment: Mapping[str, str]) -> None:
    """Begin a worker, which otherwise has the environment of the process that it is forked from."""
    os.environ.clear()
    os.environ.update(environment)
    worker._begin_worker()


def fork_workers() -> None:
    """Start this process's own fork server, for the workers of its jobs.

    Workers have environment, folder and streams of this process, as spawned ones have.
    """
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(arbitrary_address("AF_UNIX"))
    listener.listen()
    alive_reader, alive_writer = os.pipe()
    process = os.fork()
    if process == 0:
        os.close(alive_writer)
        forkserver.main(listener.detach(), alive_reader, None)
    fork_server._forkserver_address = listener.getsockname()
    fork_server._forkserver_alive_fd, fork_server._forkserver_pid = alive_writer, process
    os.close(alive_reader)
    listener.close()
    worker.START_METHOD = FORKSERVER.get_start_method()


class ForkedCall:
    """A function in a process of its own; ``stdout`` is what it prints."""

    def __init__(self, function: Callable[..., object], arguments: Sequence[object]) -> None:
        self._reader, writer = FORKSERVER.Pipe(duplex=False)
        given = (writer, dict(os.environ), function, tuple(arguments))
        self._process: Any = FORKSERVER.Process(target=call_here, args=given)
        self._process.start()
        writer.close()
        self.pid: int = self._process.pid
        self.stdout = open(self._reader.fileno(), closefd=False)  # noqa: SIM115

    def wait(self) -> int:
        """Wait for its end; returns the exit code, a signal's with a minus."""
        self._process.join(PATIENCE)
        assert self._process.exitcode is not None, "the function has not ended"
        return int(self._process.exitcode)

    def kill(self) -> None:
        """End it by SIGKILL, and wait; no error when it has ended already."""
        self._process.kill()
        self.wait()

    def close(self) -> None:
        self.kill()
        self.stdout.close()
        self._reader.close()


@contextmanager
def calling(function: Callable[..., object], *arguments: object) -> Iterator[ForkedCall]:
    """Run a function of a module beside this until the context ends, which kills it."""
    call = ForkedCall(function, arguments)
    try:
        yield call
    finally:
        call.close()


def call(function: Callable[..., object], *arguments: object) -> int:
    """Run a function in a process of its own to the end; returns the exit code."""
    with calling(function, *arguments) as running:
        return running.wait()


def call_here(
    writer: Connection,
    environment: Mapping[str, str],
    function: Callable[..., object],
    arguments: Sequence[object],
) -> None:
    """Be the process of a ``ForkedCall``."""
    os.dup2(writer.fileno(), 1)
    writer.close()
    os.environ.clear()
    os.environ.update(environment)
    function(*arguments)
