"""Services that start jobs, and restart jobs of ended servers from their stored requests."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar, Generic, TypeVar

from pointbrush.database.job import Job
from pointbrush.jobs.runner import JobRunner, Receiver
from pointbrush.jobs.worker import Work
from pointbrush.labels import Commit
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.values.jobs import JobKind
from pointbrush.work.events import Event
from pointbrush.work.job_registry import JobRegistry
from pointbrush.work.job_request import JobRequest
from pointbrush.work.library import Library

Request = TypeVar("Request", bound=JobRequest)
Submission = tuple[Job, Work, Receiver]


@dataclass(frozen=True)
class JobContext:
    """The parts of a workspace that its jobs use."""

    library: Library
    store: WorkspaceStore
    runner: JobRunner
    jobs: JobRegistry
    publish: Callable[[Event], None]
    database: str = field(repr=False)  # may hold a password
    max_points: int
    """Limit of points in a frame."""


class JobService(ABC, Generic[Request]):
    """Starts and restarts jobs of one kind; thread-safe."""

    kind: ClassVar[JobKind]
    request: type[Request]

    def __init__(self, context: JobContext) -> None:
        self._context, self._store = context, context.store
        self._recording = context.library.recording

    def begin(
        self,
        sequence: str | None,
        request: Request,
        owner: str | None = None,
        job_id: str | None = None,
    ) -> Job:
        """Start a job, or return the job that ``owner`` has started with this id.

        ``job_id`` is also the id of the edit in ``sequence``.
        """

        def start(job_id: str) -> Job:
            self._check(request)
            edit = None if sequence is None else job_id
            kept = request.as_json()
            job = Job(
                kind=self.kind, sequence=sequence, id=job_id, owner=owner, edit=edit, request=kept
            )
            return self._context.runner.submit(*self._prepare(request, job))

        return self._context.jobs.begin_once(job_id, owner, start)

    def restart(self, job: Job) -> dict[str, Any] | None:
        """Restart a job of an ended server; return its result if it was already done.

        Raises the errors of ``begin``.
        """
        request = self.request.of_json(job.request or {})
        result = self._result(request, job)
        if result is None:
            self._context.runner.submit(*self._prepare(request, job))
        return result

    def _check(self, request: Request) -> None:
        """Raise the errors of a request that is not a repetition."""

    @abstractmethod
    def _result(self, request: Request, job: Job) -> dict[str, Any] | None:
        """Return the result of a job of an ended server if it was done."""

    @abstractmethod
    def _prepare(self, request: Request, job: Job) -> Submission:
        """Return the job to submit, its work, and the receiver of the work's items."""


class EditService(JobService[Request]):
    """Starts and restarts jobs that make one edit of a recording."""

    def _result(self, _request: Request, job: Job) -> dict[str, Any] | None:
        recording = self._recording(job.sequence or "")
        made = self._store.find(recording.manifest.id, job.edit or job.id)
        return None if made is None else self._committed(made)

    def _committed(self, made: Commit) -> dict[str, Any]:
        """Return the result of a committed edit."""
        return edit_result(made)


def edit_result(made: Commit) -> dict[str, Any]:
    """Return the fields of a job's result that describe its edit."""
    return {"edit": made.edit, "changed": made.changed, "revision": made.revision}
