"""A job as it is seen from outside, and the memory of those that a process has."""

from __future__ import annotations

import threading
import time
import uuid
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Protocol

from pointbrush.errors import NotFoundError

JobKind = Literal["import", "tracking", "export", "prediction", "fitting"]
JobState = Literal["queued", "running", "done", "failed", "cancelled"]
ENDED: tuple[JobState, ...] = ("done", "failed", "cancelled")
MESSAGE = "message"
"""Key of a result that becomes the ended job's message."""
KEPT_JOBS = 1000
"""Ended jobs that are remembered; older ones are forgotten first."""


@dataclass(frozen=True)
class Job:
    """State of one job; a new value at every change."""

    kind: JobKind
    sequence: str | None
    id: str = field(default_factory=lambda: str(uuid.uuid4()))
    state: JobState = "queued"
    progress: float = 0.0
    message: str = ""
    result: dict[str, Any] | None = None
    error: str | None = None
    created: float = field(default_factory=time.time)
    owner: str | None = None
    """The person who started it."""
    edit: str | None = None
    """The edit that it makes, if any."""
    request: Mapping[str, Any] | None = None
    """Request that begins it again when its server has ended, as JSON; None when nothing does."""


class Book(Protocol):
    """Record of jobs, for whoever comes after this process."""

    def begun(self, job: Job) -> None:
        """Note a job before it is handed out; what this raises keeps it from being so."""

    def dropped(self, job: Job) -> None:
        """Forget a job that could not be begun."""

    def changed(self, job: Job) -> None:
        """Note that a job has changed."""


class KnownJobs:
    """Jobs of this process, as they are now; thread-safe."""

    def __init__(self, notify: Callable[[Job], None]) -> None:
        """``notify(job)`` is called at every change, from the threads that make it."""
        self._notify = notify
        self._lock = threading.Lock()
        self._jobs: dict[str, Job] = {}
        self.book: Book | None = None

    def all(self) -> list[Job]:
        """Return the remembered jobs, newest first."""
        with self._lock:
            return sorted(self._jobs.values(), key=lambda job: job.created, reverse=True)

    def get(self, job_id: str) -> Job:
        """Return one job; raises NotFoundError."""
        with self._lock:
            if job_id not in self._jobs:
                raise NotFoundError(f"job: expected the id of a known job, got {job_id!r}")
            return self._jobs[job_id]

    def add(self, job: Job) -> None:
        """Remember a job, and no more of those that have ended than KEPT_JOBS."""
        with self._lock:
            self._jobs[job.id] = job
            ended = [job_id for job_id, job in self._jobs.items() if job.state in ENDED]
            for job_id in ended[: max(0, len(self._jobs) - KEPT_JOBS)]:
                del self._jobs[job_id]

    def forget(self, job_id: str) -> None:
        """Remember a job no longer."""
        with self._lock:
            self._jobs.pop(job_id, None)

    def change(self, job_id: str, **fields: Any) -> None:
        """Change a job that has not ended, tell the book of it and whoever listens."""
        with self._lock:
            if job_id not in self._jobs or self._jobs[job_id].state in ENDED:
                return
            before, job = self._jobs[job_id], replace(self._jobs[job_id], **fields)
            self._jobs[job_id] = job
        if job == before:
            return
        if self.book is not None:
            self.book.changed(job)
        self._notify(job)
