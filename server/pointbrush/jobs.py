"""Long work outside the server process, with progress, findings on the way, and cancel.

Work runs on a ``concurrent.futures`` executor: local processes, or a Dask cluster.  Each running
job talks to its runner over one authenticated connection: progress and items go up, the wish to
cancel comes down.
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

from pointbrush.errors import CancelledError, ConflictError, NotFoundError, UnavailableError
from pointbrush.job import ENDED, MESSAGE, Job, JobState, KnownJobs
from pointbrush.system import shortage, shortages_in_words
from pointbrush.worker import (
    DisconnectedError,
    Work,
    Workers,
    cut_off,
    died,
    run_work,
    sentence,
    tell,
)

logger = logging.getLogger(__name__)
DRAIN_SECONDS = 60
END_SECONDS = 2.0
"""Time that the work of a server that is stopped may take to heed it."""
TRIES = 2
"""A job whose worker dies is begun once more."""
SUBMISSIONS = 5
"""Most times that work is handed out which no worker has come to begin."""
SHORTAGE_SECONDS = 0.1
"""Pause after a worker that could not be heard for want of files or memory."""
LOOK_SECONDS = 1.0
"""Interval of looks at what a job waits for that no worker has begun."""
SCHEDULER_AWAY = "waiting for the Dask scheduler, which does not answer"
SHORTAGE = "waiting for free files and memory for a worker"


@dataclass
class _Running:
    work: Work
    future: Future[Any] | None
    finish: Callable[[Job, bool], dict[str, Any]]
    on_item: Callable[[Job, Any], None] | None
    done: Callable[[Job], None] | None
    restart: Callable[[Job], None] | None
    tries: int = 0
    """Workers that have begun the work."""
    submissions: int = 1
    turn: int = 0
    """Number of the last time that the work was handed out."""
    connection: Connection[Any, Any] | None = None
    cancelled: bool = False
    left: bool = False
    """Another server does it from here on: it ends without a result."""
    fault: BaseException | None = None
    """Error that kept this process from taking in the work's findings."""
    drained: threading.Event = field(default_factory=threading.Event)
    ended: threading.Event = field(default_factory=threading.Event)


class JobRunner:
    """Runs jobs on ``executor`` (local processes unless given) and remembers them."""

    def __init__(
        self,
        notify: Callable[[Job], None],
        workers: int = 2,
        scheduler: str = "",
        public: Callable[[str], str] = str,
    ) -> None:
        """``notify(job)`` is called at every change, from the runner's threads.

        With a Dask ``scheduler`` (tcp://host:port) jobs run on its workers, which report to this
        machine's address on the way there; else on ``workers`` processes of this machine.
        ``public`` takes from an error's text what clients should not read.
        Raises BadInputError or UnavailableError when there is no such scheduler.
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

    def submit(
        self,
        job: Job,
        work: Work,
        finish: Callable[[Job, bool], dict[str, Any]],
        on_item: Callable[[Job, Any], None] | None = None,
        done: Callable[[Job], None] | None = None,
        restart: Callable[[Job], None] | None = None,
    ) -> Job:
        """Queue ``work``; its items come to ``on_item`` in order, then ``finish(job, cancelled)``.

        These run in this process.  ``finish`` gives the job's result, also when the job was
        cancelled, so that findings can be kept; not when the work failed.  ``done(job)`` runs last,
        however the job ended; it has not where another server goes on with it.  When a worker
        dies, the work is begun once more, after ``restart(job)``: it drops what came so far.  So
        ``work`` must be safe to begin again.  Raises UnavailableError once the runner is closed.
        """
        self._require_open()
        if (book := self.known.book) is not None:
            book.begun(job)
        running = _Running(work, None, finish, on_item, done, restart)
        supervisor = threading.Thread(target=self._supervise, args=(job.id, running), daemon=True)
        try:
            with self._lock:
                self._require_open()
                self._running[job.id] = running
                self.known.add(job)
                running.future = self._hand_out(job.id, running)
            with shortages_in_words():
                supervisor.start()
        except BaseException:
            self._forget(job.id)
            if book is not None:
                book.dropped(job)
            raise
        return job

    def make_ready(self, function: Callable[[], None]) -> None:
        """Begin a worker process, where there is none yet, and have it call ``function``.

        Jobs need not wait for its imports then.  Workers of a cluster begin by themselves.
        """
        with self._lock, suppress(UnavailableError), shortages_in_words():
            if not self._workers.begun and not self._closed:
                self._workers.submit(function)

    def require_scheduler(self) -> None:
        """Raise UnavailableError when jobs run on a cluster that does not answer."""
        self._workers.require_answer()

    def cancel(self, job_id: str) -> Job:
        """Ask a job to stop; raises ConflictError when it has already ended."""
        job = self.known.get(job_id)
        with self._lock:
            running = self._running.get(job_id)
            if running is None:
                raise ConflictError(f"job {job_id}: expected a running job, it is {job.state}")
            running.cancelled = True
            if running.future is not None:
                running.future.cancel()
            if running.connection is not None:
                tell(running.connection, "cancel")
        return job

    def wait(self, job_id: str, timeout: float | None = None) -> Job:
        """Block until the job has ended (or ``timeout`` seconds passed) and return it."""
        deadline = None if timeout is None else time.monotonic() + timeout
        while (job := self.known.get(job_id)).state not in ENDED:
            if deadline is not None and time.monotonic() > deadline:
                break
            time.sleep(0.02)
        return job

    def leave(self, job_id: str) -> None:
        """Stop a job without a result: another server has it, or will."""
        with self._lock:
            running = self._running.get(job_id)
            if running is not None:
                running.left = True
        with suppress(ConflictError, NotFoundError):  # it ended by itself meanwhile
            self.cancel(job_id)

    def close(self) -> None:
        """Stop what runs and end the worker processes.

        Jobs in a book are left to the next server, or fail where nothing begins them again; others
        are cancelled.
        """
        with self._lock:
            self._closed = True
        for job in self.known.all():
            if job.state in ENDED:
                continue
            if self.known.book is not None and job.request is not None:
                self.leave(job.id)
                continue
            if self.known.book is not None:
                self.known.change(
                    job.id, state="failed", error="the server was stopped; start the job again"
                )
            with suppress(ConflictError):  # it ended by itself meanwhile
                self.cancel(job.id)
        with self._lock:
            supervised = list(self._running.values())
        deadline = time.monotonic() + END_SECONDS
        for running in supervised:
            running.ended.wait(deadline - time.monotonic())
        # A step of work, or what makes a process ready, may take as long as it likes.
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
                self._hear(self._listener.accept())
            except (EOFError, multiprocessing.AuthenticationError):
                continue
            except Exception as error:
                # Of a shortage; its work is begun again.
                logger.warning("a worker cannot be heard now: %s", shortage(error) or error)
                time.sleep(SHORTAGE_SECONDS)

    def _hear(self, connection: Connection[Any, Any]) -> None:
        """Listen to a worker in a thread; one that cannot begin leaves it nobody to wait for."""
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
            # A cluster runs work again by itself whose worker died, more often than wanted.
            # And what was handed out in vain, for want of a process say, may begin late.
            if running is None or running.tries >= TRIES or running.turn != turn:
                connection.close()
                return
            running.tries += 1
            before, running.connection = running.connection, connection
        if before is not None:
            cut_off(before)
            running.drained.wait(DRAIN_SECONDS)
            running.drained.clear()
            if running.restart is not None:
                running.restart(self.known.get(job_id))
        with self._lock:
            tell(connection, "start")
            if running.cancelled:
                tell(connection, "cancel")
        self.known.change(job_id, state="running", progress=0.0, message="")
        self._hear_out(connection, job_id, running)
        running.drained.set()

    def _hear_out(self, connection: Connection[Any, Any], job_id: str, running: _Running) -> None:
        """Take in all that a worker says of a job, until it says no more."""
        try:
            while True:
                kind, *values = connection.recv()
                if kind == "progress":
                    self.known.change(job_id, progress=float(values[0]), message=str(values[1]))
                elif kind == "item" and running.on_item is not None:
                    running.on_item(self.known.get(job_id), values[0])
        except (EOFError, OSError):
            pass
        except Exception as error:  # such as no memory for what came
            running.fault = error
            cut_off(connection)

    def _supervise(self, job_id: str, running: _Running) -> None:
        job = self.known.get(job_id)
        try:
            self._see_through(job_id, running)
        except Exception as error:  # nobody else would end it
            self.known.change(job_id, state="failed", error=self._public(sentence(error)))
        finally:
            with suppress(NotFoundError):  # another server goes on with it
                job = self.known.get(job_id)
            if running.done is not None:
                running.done(job)
            with self._lock:
                self._running.pop(job_id, None)
            running.ended.set()

    def _see_through(self, job_id: str, running: _Running) -> None:
        """Wait until the work has ended, begin it again where it must be, and end the job."""
        error = self._outcome(job_id, running)
        while self._again(job_id, running, error):
            error = self._outcome(job_id, running)
        # Items that are still on their way; work that failed may not have come to connect.
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
            self.known.change(job_id, state="failed", error=self._public(sentence(error)))

    def _hand_out(self, job_id: str, running: _Running) -> Future[Any] | None:
        """Give work to a worker; None while nobody can take it, and once this is closed.

        Then the scheduler is away, or there are no files or no memory for a worker.  The lock must
        be held.
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
            running.turn += 1  # a pool may have kept the work and begin it all the same
            return None

    def _outcome(self, job_id: str, running: _Running) -> BaseException | None:
        """Wait until the work has ended or was taken off the queue; return its error, or None."""
        while True:
            if running.future is None:
                if running.cancelled or self._closed:
                    return CancelledError("cancelled by the user")
                self.known.change(
                    job_id, message=SCHEDULER_AWAY if self._workers.away else SHORTAGE
                )
                time.sleep(LOOK_SECONDS)
                self._workers.look_for_scheduler()
                with self._lock:
                    running.future = self._hand_out(job_id, running)
                continue
            try:
                running.future.result(LOOK_SECONDS)
                return None
            except TimeoutError as error:
                if running.future.done():
                    return error
                if self._workers.away:
                    return DisconnectedError("the Dask scheduler restarted")
                if running.connection is None:
                    self.known.change(job_id, message=self._waits_for())
            except BaseException as error:
                return error

    def _waits_for(self) -> str:
        try:
            self.require_scheduler()
        except UnavailableError as error:
            return f"waiting: {error}"
        return "waiting for a worker"

    def _again(self, job_id: str, running: _Running, error: BaseException | None) -> bool:
        """Hand work out again whose worker died, or that a lost scheduler has forgotten."""
        if error is None or not died(error) or running.cancelled or self._closed:
            return False
        if running.tries >= TRIES or running.submissions >= SUBMISSIONS:
            return False
        running.submissions += 1
        self.known.change(
            job_id, state="queued", progress=0.0, message="the worker died; the job is tried again"
        )
        with self._lock:
            running.future = self._hand_out(job_id, running)
        return True

    def _end(self, job_id: str, running: _Running, *, cancelled: bool) -> None:
        try:
            summary = running.finish(self.known.get(job_id), cancelled)
        except Exception as error:
            self.known.change(job_id, state="failed", error=self._public(sentence(error)))
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
