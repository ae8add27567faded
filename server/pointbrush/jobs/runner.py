"""Jobs outside the server process, with progress, intermediate results, and cancellation.

Work runs on a ``concurrent.futures`` executor: local processes, or a Dask cluster.  Each running
job has one authenticated connection to its runner: it sends progress and items, and receives
cancellation requests.
"""

from __future__ import annotations

import logging
import multiprocessing
import secrets
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, Listener
from typing import Any

from pointbrush.database.job import ENDED, Job
from pointbrush.errors import CancelledError, ConflictError, NotFoundError, UnavailableError
from pointbrush.jobs.job import MESSAGE, KnownJobs
from pointbrush.jobs.worker import (
    DisconnectedError,
    Work,
    Workers,
    failure_message,
    run_work,
    send_command,
    shut_down,
    worker_lost,
)
from pointbrush.system.resources import shortage, shortages_as_unavailable
from pointbrush.values.jobs import JobState

logger = logging.getLogger(__name__)
DRAIN_SECONDS = 60
END_SECONDS = 2.0
"""Longest wait for work to end when the server stops."""
TRIES = 2
"""Limit of workers per job: if a worker dies, the job is restarted once."""
SUBMISSIONS = 5
"""Limit of submissions of work that no worker starts."""
SHORTAGE_SECONDS = 0.1
"""Pause after a connection failed because of a shortage of files or memory."""
LOOK_SECONDS = 1.0
"""Polling interval of a job that waits for a worker."""
SCHEDULER_UNREACHABLE = "waiting for the Dask scheduler, which does not answer"
SHORTAGE = "waiting for free files and memory for a worker"


class Receiver:
    """The server's part of a job: receives the items of its work and makes them the result.

    Its methods run in the server's process.
    """

    def __init__(self) -> None:
        self.items: list[Any] = []

    def receive(self, _job: Job, item: Any) -> None:
        """Take an item; items come in order."""
        self.items.append(item)

    def restart(self, _job: Job) -> None:
        """Drop all items, as the work is repeated after its worker died."""
        self.items.clear()

    def finish(self, _job: Job, _cancelled: bool) -> dict[str, Any]:
        """Return the job's result; also called for a cancelled job, but not if the work failed."""
        return {}

    def end(self, job: Job) -> None:
        """Release resources; called last in all cases.

        The job has not ended if its submission failed or another server continues it.
        """


@dataclass
class _Running:
    work: Work
    future: Future[Any] | None
    receiver: Receiver
    tries: int = 0
    """Number of workers that have started the work."""
    submissions: int = 1
    turn: int = 0
    """Number of the last submission of the work."""
    connection: Connection[Any, Any] | None = None
    cancelled: bool = False
    left: bool = False
    """Another server continues the job, so it ends here without a result."""
    fault: BaseException | None = None
    """Error of this process while receiving the work's items."""
    drained: threading.Event = field(default_factory=threading.Event)
    ended: threading.Event = field(default_factory=threading.Event)


class JobRunner:
    """Runs jobs on local processes or a Dask cluster, and keeps their states."""

    def __init__(
        self,
        notify: Callable[[Job], None],
        workers: int = 2,
        scheduler: str = "",
        public: Callable[[str], str] = str,
    ) -> None:
        """``notify(job)`` is called at every change, from the runner's threads.

        With a Dask ``scheduler`` (tcp://host:port) jobs run on its workers, which connect to this
        machine's address in that network; otherwise on ``workers`` processes of this machine.
        ``public`` removes private parts from an error's text.  Raises BadInputError or
        UnavailableError if the scheduler cannot be used.
        """
        self._public = public
        self.known = KnownJobs(notify)
        self._workers = Workers(workers, scheduler)
        self._key = secrets.token_bytes(32)
        self._listener = Listener((self._workers.host, 0), backlog=64, authkey=self._key)
        self._lock = threading.Lock()
        self._running: dict[str, _Running] = {}
        self._closed = False
        threading.Thread(target=self._accept, name="pointbrush-jobs", daemon=True).start()

    def submit(self, job: Job, work: Work, receiver: Receiver) -> Job:
        """Queue ``work``; its items and its end go to ``receiver``.

        If a worker dies, the work is restarted once; it must therefore be repeatable.  Raises
        UnavailableError once the runner is closed.
        """
        try:
            return self._submit(job, work, receiver)
        except BaseException:
            receiver.end(job)
            raise

    def _submit(self, job: Job, work: Work, receiver: Receiver) -> Job:
        self._require_open()
        if (storage := self.known.storage) is not None:
            storage.add(job)
        running = _Running(work, None, receiver)
        supervisor = threading.Thread(target=self._supervise, args=(job.id, running), daemon=True)
        try:
            with self._lock:
                self._require_open()
                self._running[job.id] = running
                self.known.add(job)
                running.future = self._submit_work(job.id, running)
            with shortages_as_unavailable():
                supervisor.start()
        except BaseException:
            self._forget(job.id)
            if storage is not None:
                storage.discard(job)
            raise
        return job

    def make_ready(self, function: Callable[[], None]) -> None:
        """Start a worker process, if there is none yet, and call ``function`` in it.

        Jobs then need not wait for its imports.  Workers of a cluster are started independently.
        """
        with self._lock, suppress(UnavailableError), shortages_as_unavailable():
            if not self._workers.has_started and not self._closed:
                self._workers.submit(function)

    def require_scheduler(self) -> None:
        """Raise UnavailableError if jobs run on a cluster that does not answer."""
        self._workers.require_answer()

    def cancel(self, job_id: str) -> Job:
        """Request the cancellation of a job; raises ConflictError if it has already ended."""
        job = self.known.get(job_id)
        with self._lock:
            running = self._running.get(job_id)
            if running is None:
                raise ConflictError(f"job {job_id}: expected a running job, it is {job.state}")
            running.cancelled = True
            if running.future is not None:
                running.future.cancel()
            if running.connection is not None:
                send_command(running.connection, "cancel")
        return job

    def wait(self, job_id: str, timeout: float | None = None) -> Job:
        """Wait until the job has ended (or ``timeout`` seconds) and return it."""
        deadline = None if timeout is None else time.monotonic() + timeout
        while (job := self.known.get(job_id)).state not in ENDED:
            if deadline is not None and time.monotonic() > deadline:
                break
            time.sleep(0.02)
        return job

    def leave(self, job_id: str) -> None:
        """Stop a job without a result, as another server continues it."""
        with self._lock:
            running = self._running.get(job_id)
            if running is not None:
                running.left = True
        with suppress(ConflictError, NotFoundError):  # it has ended
            self.cancel(job_id)

    def close(self) -> None:
        """Stop all jobs and end the worker processes.

        With a storage, jobs are left to other servers, or fail if they cannot be restarted; without
        one they are cancelled.
        """
        with self._lock:
            self._closed = True
        for job in self.known.all():
            if job.state in ENDED:
                continue
            if self.known.storage is not None and job.request is not None:
                self.leave(job.id)
                continue
            if self.known.storage is not None:
                self.known.change(
                    job.id, state="failed", error="the server was stopped; start the job again"
                )
            with suppress(ConflictError):  # it has ended
                self.cancel(job.id)
        with self._lock:
            supervised = list(self._running.values())
        deadline = time.monotonic() + END_SECONDS
        for running in supervised:
            running.ended.wait(deadline - time.monotonic())
        # Work does not check for cancellation within a step or its imports.
        self._workers.end()
        for running in supervised:
            running.ended.wait(END_SECONDS)
        self._listener.close()

    def _require_open(self) -> None:
        if self._closed:
            raise UnavailableError("jobs: expected a running server, it is being stopped")

    def _accept(self) -> None:
        while not self._closed:
            try:
                self._start_listening(self._listener.accept())
            except (EOFError, multiprocessing.AuthenticationError):
                continue
            except Exception as error:
                # A shortage of resources; the work is restarted.
                logger.warning("a worker cannot be heard now: %s", shortage(error) or error)
                time.sleep(SHORTAGE_SECONDS)

    def _start_listening(self, connection: Connection[Any, Any]) -> None:
        """Start a thread for a worker's connection; close it if the thread cannot start."""
        try:
            threading.Thread(target=self._listen, args=(connection,), daemon=True).start()
        except BaseException:
            connection.close()
            raise

    def _listen(self, connection: Connection[Any, Any]) -> None:
        try:
            job_id, turn = connection.recv()
        except (EOFError, OSError):
            return
        with self._lock:
            running = self._running.get(job_id)
            # A cluster may restart work of a dead worker more often than TRIES, and an earlier
            # submission without a free process may start late.
            if running is None or running.tries >= TRIES or running.turn != turn:
                connection.close()
                return
            running.tries += 1
            before, running.connection = running.connection, connection
        if before is not None:
            shut_down(before)
            running.drained.wait(DRAIN_SECONDS)
            running.drained.clear()
            running.receiver.restart(self.known.get(job_id))
        with self._lock:
            send_command(connection, "start")
            if running.cancelled:
                send_command(connection, "cancel")
        self.known.change(job_id, state="running", progress=0.0, message="")
        self._receive_all(connection, job_id, running)
        running.drained.set()

    def _receive_all(
        self, connection: Connection[Any, Any], job_id: str, running: _Running
    ) -> None:
        """Receive all messages of a worker about a job until the connection closes."""
        try:
            while True:
                kind, *values = connection.recv()
                if kind == "progress":
                    self.known.change(job_id, progress=float(values[0]), message=str(values[1]))
                elif kind == "item":
                    running.receiver.receive(self.known.get(job_id), values[0])
        except (EOFError, OSError):
            pass
        except Exception as error:  # such as no memory for an item
            running.fault = error
            shut_down(connection)

    def _supervise(self, job_id: str, running: _Running) -> None:
        job = self.known.get(job_id)
        try:
            self._run_to_end(job_id, running)
        except Exception as error:  # otherwise the job would never end
            self.known.change(job_id, state="failed", error=self._public(failure_message(error)))
        finally:
            with suppress(NotFoundError):  # another server continues it
                job = self.known.get(job_id)
            running.receiver.end(job)
            with self._lock:
                self._running.pop(job_id, None)
            running.ended.set()

    def _run_to_end(self, job_id: str, running: _Running) -> None:
        """Wait until the work has ended, restart it if necessary, and end the job."""
        error = self._wait_for_work(job_id, running)
        while self._resubmit_if_lost(job_id, running, error):
            error = self._wait_for_work(job_id, running)
        # Wait for pending items; failed work may not have connected.
        connected = error is None or running.connection is not None
        running.drained.wait(DRAIN_SECONDS if connected else 0)
        error = running.fault or error
        if running.left:
            self._forget(job_id)
        elif error is None:
            self._end(job_id, running, cancelled=False)
        elif running.cancelled or isinstance(error, CancelledError):
            self._end(job_id, running, cancelled=True)
        else:
            self.known.change(job_id, state="failed", error=self._public(failure_message(error)))

    def _submit_work(self, job_id: str, running: _Running) -> Future[Any] | None:
        """Submit work; return None if no worker can take it, or once the runner is closed.

        The reason is an unreachable scheduler, or a shortage of files or memory.  The lock must be
        held.
        """
        if self._closed:
            return None
        running.turn += 1
        try:
            address, turn = self._listener.address, running.turn
            return self._workers.submit(run_work, address, self._key, (job_id, turn), running.work)
        except Exception as error:
            if (short := shortage(error)) is None:
                raise
            logger.warning("a job waits: %s", short)
            running.turn += 1  # a pool may have kept the work and start it nevertheless
            return None

    def _wait_for_work(self, job_id: str, running: _Running) -> BaseException | None:
        """Wait until the work has ended or left the queue; return its error, or None."""
        while True:
            if running.future is None:
                if running.cancelled or self._closed:
                    return CancelledError("cancelled by the user")
                self.known.change(
                    job_id, message=SCHEDULER_UNREACHABLE if self._workers.unreachable else SHORTAGE
                )
                time.sleep(LOOK_SECONDS)
                self._workers.look_for_scheduler()
                with self._lock:
                    running.future = self._submit_work(job_id, running)
                continue
            try:
                running.future.result(LOOK_SECONDS)
                return None
            except TimeoutError as error:
                if running.future.done():
                    return error
                if self._workers.unreachable:
                    return DisconnectedError("the Dask scheduler restarted")
                if running.connection is None:
                    self.known.change(job_id, message=self._waiting_message())
            except BaseException as error:
                return error

    def _waiting_message(self) -> str:
        try:
            self.require_scheduler()
        except UnavailableError as error:
            return f"waiting: {error}"
        return "waiting for a worker"

    def _resubmit_if_lost(
        self, job_id: str, running: _Running, error: BaseException | None
    ) -> bool:
        """Resubmit work if its worker or scheduler was lost; return whether it was resubmitted."""
        if error is None or not worker_lost(error) or running.cancelled or self._closed:
            return False
        if running.tries >= TRIES or running.submissions >= SUBMISSIONS:
            return False
        running.submissions += 1
        self.known.change(
            job_id, state="queued", progress=0.0, message="the worker died; the job is tried again"
        )
        with self._lock:
            running.future = self._submit_work(job_id, running)
        return True

    def _end(self, job_id: str, running: _Running, *, cancelled: bool) -> None:
        try:
            summary = running.receiver.finish(self.known.get(job_id), cancelled)
        except Exception as error:
            self.known.change(job_id, state="failed", error=self._public(failure_message(error)))
        else:
            state: JobState = "cancelled" if cancelled else "done"
            job = self.known.get(job_id)
            progress = job.progress if cancelled else 1.0
            message = summary.get(MESSAGE, job.message)
            self.known.change(
                job_id, state=state, progress=progress, result=summary, message=message
            )

    def _forget(self, job_id: str) -> None:
        self.known.forget(job_id)
        with self._lock:
            self._running.pop(job_id, None)
