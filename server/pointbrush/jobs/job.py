"""The states of a process's jobs."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Protocol

from pointbrush.database.job import ENDED, Job
from pointbrush.errors import NotFoundError

MESSAGE = "message"
"""Key of a result that becomes the ended job's message."""
KEPT_JOBS = 1000
"""Limit of ended jobs in memory; the oldest are removed first."""


class JobStorage(Protocol):
    """Storage of jobs, which outlives this process."""

    def add(self, job: Job) -> None:
        """Store a job before it is submitted; an error prevents the submission."""

    def discard(self, job: Job) -> None:
        """Remove a job that failed to start."""

    def update(self, job: Job) -> None:
        """Store a change of a job."""


class KnownJobs:
    """Current states of this process's jobs; thread-safe."""

    def __init__(self, notify: Callable[[Job], None]) -> None:
        """``notify(job)`` is called at every change, from the thread of the change."""
        self._notify = notify
        self._lock = threading.Lock()
        self._jobs: dict[str, Job] = {}
        self.storage: JobStorage | None = None

    def all(self) -> list[Job]:
        """Return the jobs, newest first."""
        with self._lock:
            return sorted(self._jobs.values(), key=lambda job: job.created, reverse=True)

    def get(self, job_id: str) -> Job:
        """Return one job; raises NotFoundError."""
        with self._lock:
            if job_id not in self._jobs:
                raise NotFoundError(f"job: expected the id of a known job, got {job_id!r}")
            return self._jobs[job_id]

    def add(self, job: Job) -> None:
        """Add a job, and remove ended jobs beyond KEPT_JOBS."""
        with self._lock:
            self._jobs[job.id] = job
            ended = [job_id for job_id, job in self._jobs.items() if job.state in ENDED]
            for job_id in ended[: max(0, len(self._jobs) - KEPT_JOBS)]:
                del self._jobs[job_id]

    def forget(self, job_id: str) -> None:
        """Remove a job."""
        with self._lock:
            self._jobs.pop(job_id, None)

    def change(self, job_id: str, **fields: Any) -> None:
        """Change a job that has not ended, store the change and notify the subscribers."""
        with self._lock:
            if job_id not in self._jobs or self._jobs[job_id].state in ENDED:
                return
            before, job = self._jobs[job_id], replace(self._jobs[job_id], **fields)
            self._jobs[job_id] = job
        if job == before:
            return
        if self.storage is not None:
            self.storage.update(job)
        self._notify(job)
