"""Persistence of jobs, so that another server can restart jobs of an ended server."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pointbrush.database.job import ENDED, Job
from pointbrush.database.job_records import STALE_SECONDS, JobRecord, TaskPatch
from pointbrush.errors import ConflictError, NotFoundError, PointbrushError, UnavailableError
from pointbrush.jobs.runner import JobRunner
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.work.annotate.strokes import edit_id
from pointbrush.work.imports.requests import UPLOAD

log = logging.getLogger(__name__)

LOOK_SECONDS = 2.0
"""Polling interval for changes and requests of other servers."""
BEAT_SECONDS = 5.0
"""Interval at which a server stores the progress of its jobs."""
MOST_LOST = 3
"""Number of lost servers after which a job is not restarted, as it may have crashed them."""
RESTART_PENDING = "the server has ended; the job starts again"
NOT_RESTARTABLE = "the server ended before the job was done; start it again"

Begin = Callable[[Job], dict[str, Any] | None]
"""Submits another server's job to the runner, or returns its result if it was done.

Raises PointbrushError.
"""


class JobRegistry:
    """The jobs of all servers of one database; the runner has the jobs of this server."""

    def __init__(
        self,
        store: WorkspaceStore,
        runner: JobRunner,
        notify: Callable[[Job], None],
        begin: Mapping[str, Begin],
        keep: Callable[[str], None],
        public: Callable[[str], str] = str,
    ) -> None:
        """``begin`` has the function that restarts a job, by the ``call`` in its request.

        ``notify(job)`` is called when another server's job changes; ``keep(job_id)`` before a job
        is cancelled and its results are kept; ``public``: see the runner.
        """
        self._records, self._runner, self._notify = store.jobs, runner, notify
        self._begin, self._keep, self._public = begin, keep, public
        self._changed: dict[str, Job] = {}
        self._discarded: set[str] = set()
        """Ids of jobs that failed to start; their records will be removed."""
        self._seen: dict[str, Job] = {}
        self._waiting: dict[str, JobRecord] = {}
        self._lock = threading.Lock()
        self._stop, self._wake = threading.Event(), threading.Event()
        self._thread = threading.Thread(
            target=self._run, name="pointbrush-job-registry", daemon=True
        )
        self._beat = self._silent_since = time.monotonic()

    def open(self) -> None:
        """Start to store this server's jobs, and to restart jobs without a server."""
        self._runner.known.storage = self
        self._thread.start()

    def close(self) -> None:
        """Release unfinished jobs for other servers; the runner must have ended them."""
        self._stop.set()
        self._wake.set()
        if self._thread.ident is None:
            return
        self._thread.join()
        try:
            self._remove_discarded()
            self._write()
            own = [r.id for r in self._records.under_way() if r.server == self._records.owner]
            self._records.release(own, RESTART_PENDING)
        except UnavailableError as error:
            log.warning("jobs are begun again %.0f s later: %s", STALE_SECONDS, error)

    # ── for the runner ───────────────────────────────────────────────────────────────────

    def add(self, job: Job) -> None:
        """Store a job before it is submitted.

        Raises ConflictError if a job with its id exists, UnavailableError.
        """
        if job.id in self._discarded:
            self._remove_discarded()
        if job.id in self._waiting:
            return
        try:
            self._records.add(job)
        except UnavailableError:  # it may be stored: the answer to the commit may be lost
            self.discard(job)
            raise

    def discard(self, job: Job) -> None:
        """Remove a job that failed to start, except a job that will be restarted."""
        with self._lock:
            if job.id not in self._waiting:
                self._discarded.add(job.id)
        self._wake.set()

    def update(self, job: Job) -> None:
        """Record a change of a job; its progress is stored with the next beat."""
        with self._lock:
            before = self._changed.get(job.id)
            self._changed[job.id] = job
        if before is None or before.state != job.state:
            self._wake.set()

    # ── for people ───────────────────────────────────────────────────────────────────────

    def all(self) -> list[Job]:
        """Return the jobs of all servers, newest first."""
        own = {job.id: job for job in self._runner.known.all()}
        records = self._records.all()
        stored: dict[str, Job] = {job.id: job for job in records if job.id not in self._discarded}
        return sorted((stored | own).values(), key=lambda job: job.created, reverse=True)

    def get(self, job_id: str) -> Job:
        """Return a job of any server; raises NotFoundError."""
        try:
            return self._runner.known.get(job_id)
        except NotFoundError:
            record = self._records.find(job_id)
            if record is None or job_id in self._discarded:
                raise
            return record

    def begin_once(self, job_id: str | None, owner: str | None, begin: Callable[[str], Job]) -> Job:
        """Start a job by ``begin(id)``, or return the job that ``owner`` has started with this id.

        A call with a lost response can therefore be repeated.  Raises BadInputError for an id that
        is no UUID, ConflictError for the id of another person's job, and the errors of ``begin``.
        """
        wanted = edit_id(job_id)
        known = None if job_id is None else self._own(wanted, owner)
        if known is not None:
            return known
        try:
            return begin(wanted)
        except ConflictError:
            known = self._own(wanted, owner)  # concurrent repetition of the same call
            if known is None:
                raise
            return known

    def _own(self, job_id: str, owner: str | None) -> Job | None:
        try:
            job = self.get(job_id)
        except NotFoundError:
            return None
        if job.owner != owner:
            raise ConflictError("id: expected an id of your own jobs, another account uses it")
        return job

    def uploads(self) -> set[Path]:
        """Return the folders of uploaded files of unfinished jobs of all servers."""
        requests = (record.request or {} for record in self._records.under_way())
        return {Path(request[UPLOAD]) for request in requests if request.get(UPLOAD)}

    def cancel(self, job_id: str, *, keep: bool) -> Job:
        """Request the cancellation of a job of any server; raises ConflictError if it has ended.

        ``keep``: keep its results so far.
        """
        try:
            self._runner.known.get(job_id)
        except NotFoundError:
            return self._request_cancellation(job_id, keep=keep)
        if keep:
            self._keep(job_id)
        return self._runner.cancel(job_id)

    def _request_cancellation(self, job_id: str, *, keep: bool) -> Job:
        job = self.get(job_id)
        if job.state in ENDED:
            raise ConflictError(f"job {job_id}: expected a running job, it is {job.state}")
        self._records.ask(job_id, "keep" if keep else "cancel")
        return job

    # ── the thread ───────────────────────────────────────────────────────────────────────

    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                self._synchronize()
            except UnavailableError as error:
                # Other servers of the database cannot store heartbeats either.
                self._silent_since = time.monotonic()
                log.warning("jobs cannot be written down now: %s", error)
            except Exception:
                log.exception("jobs could not be looked after")
            self._wake.wait(LOOK_SECONDS)
            self._wake.clear()

    def _synchronize(self) -> None:
        self._remove_discarded()
        self._write()
        silent = time.monotonic() - self._silent_since > STALE_SECONDS
        self._waiting |= {record.id: record for record in self._records.claim(silent=silent)}
        for record in list(self._waiting.values()):
            self._restart(record)
        under_way = self._records.under_way()
        for record in under_way:
            if record.server == self._records.owner and record.wish:
                self._cancel_as_requested(record.id, record.wish)
        self._notify_changes([r for r in under_way if r.server != self._records.owner])

    def _remove_discarded(self) -> None:
        """Remove jobs that failed to start."""
        with self._lock:
            discarded = set(self._discarded)
        if not discarded:
            return
        # A concurrent repetition of the same call may have started the job.
        self._records.remove(discarded - {job.id for job in self._runner.known.all()})
        with self._lock:
            self._discarded -= discarded

    def _write(self) -> None:
        """Store changed jobs, and heartbeats of the others."""
        with self._lock:
            changed, self._changed = self._changed, {}
        running = {job.id: job for job in self._runner.known.all() if job.state not in ENDED}
        urgent = any(job.state != "running" or job.progress == 0.0 for job in changed.values())
        late = time.monotonic() - self._beat > BEAT_SECONDS
        wanted = running | changed
        if not wanted or not (urgent or late):
            with self._lock:
                self._changed = changed | self._changed
            return
        try:
            lost = self._records.update(wanted.values())
        except BaseException:
            with self._lock:
                self._changed = changed | self._changed
            raise
        self._beat = time.monotonic()
        for job_id in lost:
            log.warning("job %s was taken over by another server", job_id)
            self._runner.leave(job_id)

    def _restart(self, record: JobRecord) -> None:
        try:
            if record.lost >= MOST_LOST:
                raise ConflictError(
                    f"{record.lost} servers ended while the job ran; start it by hand"
                )
            if record.request is None:
                raise ConflictError(NOT_RESTARTABLE)
            log.info("job %s begins again", record.id)
            begin = self._begin[record.request["call"]]
            result = begin(replace(record, state="queued", message=""))
        except UnavailableError:
            raise  # the database or the scheduler is unavailable: retry later
        except PointbrushError as error:
            self._store_end(replace(record, state="failed", error=self._public(str(error))))
        else:
            if result is not None:
                self._store_end(replace(record, state="done", progress=1.0, result=result))
        self._waiting.pop(record.id, None)

    def _store_end(self, job: Job) -> None:
        self._records.update([job])
        self._notify(job)

    def _cancel_as_requested(self, job_id: str, wish: TaskPatch) -> None:
        if wish == "keep":
            self._keep(job_id)
        try:
            self._runner.cancel(job_id)
        except (ConflictError, NotFoundError):
            return  # it has ended

    def _notify_changes(self, elsewhere: Sequence[Job]) -> None:
        """Notify of changes of other servers' jobs."""
        now = {job.id: job for job in elsewhere}
        for job_id in self._seen.keys() - now.keys():
            record = self._records.find(job_id)
            if record is not None and record.server != self._records.owner:
                self._notify(record)
        for job in elsewhere:
            if self._seen.get(job.id) != job:
                self._notify(job)
        self._seen = now
