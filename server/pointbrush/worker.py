"""A job's own process: how work reports to its runner, and how such a process begins and ends."""

from __future__ import annotations

import multiprocessing
import os
import threading
from concurrent.futures import Executor, ProcessPoolExecutor
from multiprocessing.connection import Client, Connection
from typing import Any, Protocol

from pointbrush.errors import CancelledError
from pointbrush.private import private_files

NICENESS = 5
"""By how much workers give way to the server: a stroke that waits is felt, a longer run is not."""


class Channel:
    """The work's side of its connection to the runner."""

    def __init__(self, connection: Connection[Any, Any]) -> None:
        self._connection = connection
        self._cancelled = False

    def progress(self, fraction: float, message: str = "") -> None:
        """Report progress 0..1; raises CancelledError when the user has cancelled."""
        self._connection.send(("progress", fraction, message))
        self.check()

    def item(self, value: object) -> None:
        """Hand a picklable finding to the runner at once; raises CancelledError."""
        self._connection.send(("item", value))
        self.check()

    def check(self) -> None:
        """Raise CancelledError when the user has cancelled."""
        while not self._cancelled and self._connection.poll():
            self._cancelled = self._connection.recv() == "cancel"
        if self._cancelled:
            raise CancelledError("cancelled by the user")


class Work(Protocol):
    """Picklable work: runs in another process and returns a picklable result."""

    def __call__(self, channel: Channel) -> Any:
        """Do the work, reporting on ``channel``."""


def local_processes(workers: int) -> ProcessPoolExecutor:
    """So many worker processes of this machine."""
    # The workers share the cores: threads of BLAS in each of them would wait for one another.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Not fork: the server's threads and locks must not be copied half-way into a worker.
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(max_workers=workers, mp_context=context, initializer=_begin_worker)


def end_processes(executor: Executor) -> None:
    """End the worker processes of this machine at once, whatever they do."""
    if isinstance(executor, ProcessPoolExecutor):
        # Its own way to do so, terminate_workers, comes with Python 3.14.
        for process in list((executor._processes or {}).values()):
            process.terminate()


def _begin_worker() -> None:
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    _end_with_parent()


def _end_with_parent() -> None:
    """Let a worker end when its server is killed: the pool's queue would keep it waiting."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=(parent,), daemon=True).start()


def _end_after(parent: Any) -> None:
    parent.join()
    os._exit(1)


def run_work(address: tuple[str, int], key: bytes, job_id: str, work: Work) -> Any:
    """Do a job's work in this process, which talks to its runner at ``address``."""
    with private_files(), Client(address, authkey=key) as connection:
        connection.send(job_id)
        connection.recv()  # "start"; EOFError when the job is no longer wanted
        return work(Channel(connection))
