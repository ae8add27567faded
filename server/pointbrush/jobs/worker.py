"""The worker of a job: a process of this machine, or of a Dask cluster.

It covers the submission of work, its connection to the runner, and the start and end of workers.
"""

from __future__ import annotations

import importlib
import logging
import multiprocessing
import os
import signal
import socket
import tempfile
import threading
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from concurrent.futures import CancelledError as FutureCancelledError
from contextlib import suppress
from functools import partial
from multiprocessing.connection import Client, Connection
from typing import Any, TypeAlias, TypeVar
from urllib.parse import urlsplit

from pointbrush.errors import BadInputError, CancelledError, PointbrushError, UnavailableError
from pointbrush.system.permissions import private_files
from pointbrush.system.resources import shortage

logger = logging.getLogger(__name__)

NICENESS = 5
"""Niceness of workers, so that strokes on the server have priority over jobs."""
START_METHOD = "spawn"
"""Not fork, which would copy threads and locks of the server in an inconsistent state."""
T = TypeVar("T")
CONNECT_SECONDS = 10


class Channel:
    """The connection to the runner, on the side of the work."""

    def __init__(self, connection: Connection[Any, Any]) -> None:
        self._connection = connection
        self._cancelled = False

    def progress(self, fraction: float, message: str = "") -> None:
        """Report progress 0..1; raises CancelledError if the user has cancelled."""
        self._connection.send(("progress", fraction, message))
        self.check()

    def item(self, value: object) -> None:
        """Send a picklable result to the runner at once; raises CancelledError."""
        self._connection.send(("item", value))
        self.check()

    def check(self) -> None:
        """Raise CancelledError if the user has cancelled."""
        while not self._cancelled and self._connection.poll():
            self._cancelled = self._connection.recv() == "cancel"
        if self._cancelled:
            raise CancelledError("cancelled by the user")


Work: TypeAlias = Callable[[Channel], Any]
"""Picklable work: runs in another process, reports on a channel and returns a picklable result."""


def local_processes(workers: int) -> ProcessPoolExecutor:
    """Return an executor with ``workers`` processes of this machine."""
    # The workers share the cores, so several threads of BLAS per worker would be slower.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    context = multiprocessing.get_context(START_METHOD)
    return ProcessPoolExecutor(max_workers=workers, mp_context=context, initializer=_begin_worker)


def end_processes(executor: Executor) -> None:
    """Terminate the worker processes of this machine at once."""
    if isinstance(executor, ProcessPoolExecutor):
        # terminate_workers exists from Python 3.14 on.
        for process in list((executor._processes or {}).values()):
            process.terminate()


def _begin_worker() -> None:
    # Ctrl+C signals all processes of a terminal; the server itself ends its workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    _end_with_parent()


def _end_with_parent() -> None:
    """End a worker if its server is killed, as it would wait for the pool's queue forever."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=(parent,), daemon=True).start()


def _end_after(parent: Any) -> None:
    parent.join()
    os._exit(1)


def run_work(address: tuple[str, int], key: bytes, turn: tuple[str, int], work: Work) -> Any:
    """Run a job's work in this process, connected to its runner at ``address``.

    ``turn``: the job's id, and the number of the submission.
    """
    with private_files(), Client(address, authkey=key) as connection:
        connection.send(turn)
        connection.recv()  # "start"; EOFError if the job is no longer wanted
        return work(Channel(connection))


def _with_temporary(folder: str, done: Callable[[], T]) -> T:
    """Call ``done`` in a worker of a cluster with the server's ``folder`` for temporary files.

    It is on the workspace's disk, while a worker's own folder is often in memory, which an archive
    would fill.  A TMPDIR set for the worker has precedence.
    """
    before = tempfile.tempdir
    if "TMPDIR" not in os.environ and os.access(folder, os.W_OK):
        tempfile.tempdir = folder
    try:
        return done()
    finally:
        tempfile.tempdir = before


class BriefFormatter(logging.Formatter):
    """Formats a record as one line, without a traceback."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the line."""
        plain = logging.makeLogRecord(record.__dict__ | {"exc_info": None, "exc_text": None})
        line = super().format(plain).partition("\n")[0]
        if not record.exc_info or record.exc_info[1] is None:
            return line
        error = record.exc_info[1]
        return f"{line} ({type(error).__name__}: {str(error).partition(chr(10))[0]})"


def brief_logs() -> None:
    """Shorten Dask's log of lost connections to one line each."""
    form = BriefFormatter("%(name)s: %(message)s")
    for name in ("distributed", "tornado"):
        known = [each for each in logging.Logger.manager.loggerDict if f"{each}.".startswith(name)]
        for logger in map(logging.getLogger, known):
            for handler in logger.handlers:
                handler.setFormatter(form)


class DisconnectedError(Exception):
    """The scheduler is unreachable or was restarted, so its work is lost."""


class DaskExecutor(Executor):
    """Runs work on the workers of a scheduler; they need pointbrush and the workspace's folder.

    Raises BadInputError for an invalid address or without ``distributed``, UnavailableError if the
    scheduler does not answer.
    """

    def __init__(self, address: str) -> None:
        require_address(address)
        try:
            distributed: Any = importlib.import_module("distributed")
        except ImportError:
            raise BadInputError(
                "scheduler: expected Dask to be installed: pip install 'pointbrush[dask]'"
            ) from None
        brief_logs()
        try:
            self._client = distributed.Client(
                address, timeout=CONNECT_SECONDS, set_as_default=False
            )
        except (OSError, ValueError) as error:
            raise UnavailableError(
                f"scheduler: expected a Dask scheduler at {address}: {error}"
            ) from None
        self._pool = self._client.get_executor(pure=False)

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Run ``fn`` on a worker once; raises DisconnectedError if the scheduler is lost."""
        if self._client.status != "running":
            raise DisconnectedError
        done = partial(fn, *args, **kwargs)
        future: Future[T] = self._pool.submit(
            _with_temporary, tempfile.gettempdir(), done, retries=0
        )
        return future

    @property
    def connected(self) -> bool:
        """Return whether the client is still connected to its scheduler."""
        return bool(self._client.status == "running")

    def require_answer(self) -> None:
        """Raise UnavailableError unless the scheduler answers and has workers."""
        try:
            workers = self._client.scheduler_info(n_workers=-1)["workers"]
            alive = self._client.status == "running"
        except Exception:
            alive, workers = False, {}
        if not alive:
            raise UnavailableError(
                "expected the Dask scheduler to answer; the connection is tried again"
            )
        if not workers:
            raise UnavailableError("expected workers at the Dask scheduler, there are none")

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Disconnect from the cluster, which continues to run."""
        try:
            self._pool.shutdown(wait=wait and not cancel_futures)
            self._client.close()
        except Exception as error:  # a lost client cannot disconnect
            logger.info("the connection to the Dask scheduler had ended: %s", error)


def require_address(address: str) -> tuple[str, int]:
    """Return host and port of ``tcp://host:port`` or ``tls://host:port``; raises BadInputError."""
    parts = urlsplit(address)
    try:
        host, port = parts.hostname, parts.port
    except ValueError:
        host, port = None, None
    if parts.scheme not in ("tcp", "tls") or host is None or port is None:
        raise BadInputError(f"scheduler: expected tcp://host:port, got {address!r}")
    return host, port


def own_host(address: str) -> str:
    """Return this machine's address in the scheduler's network, to which workers connect."""
    host, port = require_address(address)
    try:
        family, kind, proto, _, target = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        with socket.socket(family, kind, proto) as probe:
            probe.connect(target)  # sends nothing, only selects the route
            return str(probe.getsockname()[0])
    except OSError as error:
        raise UnavailableError(f"scheduler: expected a way to {address}: {error}") from None


class Workers:
    """Workers for jobs; lost ones are replaced.  Thread-safe."""

    def __init__(self, count: int, scheduler: str) -> None:
        """Use ``count`` processes of this machine, or a Dask ``scheduler`` (tcp://host:port).

        Raises BadInputError or UnavailableError when there is no such scheduler.
        """
        self._make: Callable[[], Executor]
        self._executor: Executor | None = None
        self._lock, self._connecting = threading.Lock(), threading.Lock()
        self.host = "127.0.0.1"
        """Address of this machine to which workers connect."""
        if scheduler:
            self._make = lambda: DaskExecutor(scheduler)
            # At once, so that a wrong address is noticed at the start.
            self._executor, self.host = self._make(), own_host(scheduler)
        else:
            self._make = lambda: local_processes(count)

    def submit(self, function: Callable[..., Any], *args: Any) -> Future[Any] | None:
        """Submit work; return None while the scheduler is unreachable."""
        with self._lock:
            if self._executor is None:
                self._executor = self._make()
            try:
                return self._executor.submit(function, *args)
            except DisconnectedError:
                return None
            except BrokenExecutor:
                # A worker died during an earlier job; later jobs get new workers.
                self._executor = self._make()
                return self._executor.submit(function, *args)

    @property
    def has_started(self) -> bool:
        """Return whether workers were started."""
        return self._executor is not None

    @property
    def unreachable(self) -> bool:
        """Return whether the scheduler is unreachable or was restarted."""
        return isinstance(self._executor, DaskExecutor) and not self._executor.connected

    def require_answer(self) -> None:
        """Raise UnavailableError if a scheduler does not answer."""
        if isinstance(self._executor, DaskExecutor):
            self._executor.require_answer()

    def look_for_scheduler(self) -> None:
        """Connect to a restarted scheduler; work can be submitted meanwhile."""
        with self._connecting:
            lost = self._executor
            if lost is None or not self.unreachable:
                return
            with suppress(UnavailableError):
                found = self._make()
                with self._lock:
                    self._executor = found
                lost.shutdown(wait=False, cancel_futures=True)

    def end(self) -> None:
        """Terminate the processes of this machine, or disconnect from the cluster."""
        if self._executor is not None:
            end_processes(self._executor)
            self._executor.shutdown(wait=True, cancel_futures=True)


def worker_lost(error: BaseException) -> bool:
    """Return whether work ended because its process or its scheduler was lost."""
    if isinstance(error, PointbrushError):
        return False
    lost = (BrokenExecutor, EOFError, ConnectionError, FutureCancelledError, DisconnectedError)
    # Dask's errors are recognized by name, as it need not be installed.
    return isinstance(error, lost) or type(error).__name__ in (
        "KilledWorker",
        "FutureCancelledError",
    )


def shut_down(connection: Connection[Any, Any]) -> None:
    """Shut down a connection, so that its reader gets EOFError."""
    with suppress(OSError), socket.socket(fileno=os.dup(connection.fileno())) as link:
        link.shutdown(socket.SHUT_RDWR)


def send_command(connection: Connection[Any, Any], command: str) -> None:
    """Send the work a message, if it is still connected."""
    try:
        connection.send(command)
    except OSError:
        return  # the work has just ended


def failure_message(error: BaseException) -> str:
    """Return the message of a failed job; unexpected errors are logged."""
    if isinstance(error, PointbrushError):
        return str(error)
    if (short := shortage(error)) is not None:
        return str(short)
    if worker_lost(error):
        return "the worker process died, twice (out of memory, or a fault in a native decoder)"
    # An unexpected error: the log gets the traceback, the user a short message.
    logger.error("a job failed unexpectedly", exc_info=error)
    return f"failed unexpectedly ({type(error).__name__}); the server's log has the reason"
