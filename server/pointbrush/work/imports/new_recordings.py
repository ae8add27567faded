"""Jobs that create recordings with their labels, from files or a generator."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar

from pointbrush.database.guards import Guard
from pointbrush.database.job import Job
from pointbrush.database.project_tables import FIRST
from pointbrush.errors import NotFoundError, PointbrushError
from pointbrush.jobs.runner import Receiver
from pointbrush.jobs.worker import Work
from pointbrush.names import require_visible
from pointbrush.sequences import Manifest
from pointbrush.sequences import Sequence as Recording
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.work.events import SequencesChanged
from pointbrush.work.imports import importing
from pointbrush.work.imports.requests import ImportRequest, SampleRequest, drop_upload
from pointbrush.work.imports.source_labels import SourceLabels
from pointbrush.work.job_service import JobContext, JobService, Submission
from pointbrush.work.trash import ids_for

WITHOUT_LABELS = "the recording was imported, but its labels were not imported"
"""Prefix of the error of an import that created a recording without its labels."""

Request = TypeVar("Request", ImportRequest, SampleRequest)
Complete = Callable[[Iterable[Manifest]], None]


class NewRecordings(JobService[Request]):
    """Starts and restarts jobs that create recordings; thread-safe."""

    kind = "import"

    def __init__(self, context: JobContext, complete: Complete) -> None:
        """``complete``: completes imports of servers that were killed at the end of an import."""
        super().__init__(context)
        self._complete, self._library = complete, context.library

    @abstractmethod
    def _work(self, request: Request, sequence: str) -> Work:
        """Return the work that creates the recording ``sequence``."""

    @abstractmethod
    def _label(self, request: Request, recording: Recording) -> list[str]:
        """Label the created recording; return warnings."""

    def _result(self, request: Request, job: Job) -> dict[str, Any] | None:
        if job.sequence is None or not self._library.has(job.sequence):
            return None
        recording = self._recording(job.sequence)
        if not recording.manifest.source.startswith(request.source):
            return None
        self._complete([recording.manifest])
        return importing.result(recording, [], request.up)

    def _prepare(self, request: Request, job: Job) -> Submission:
        if request.name:
            require_visible("name", request.name)
        self._library.require_writable()
        self._library.store.clear_remains(self._store.guards.importing)
        guard = self._store.guards.reserve(ids_for(request.readable), self._library.is_free)
        work = self._work(request, guard.sequence)
        receiver = _NewRecording(self._context, request, guard, partial(self._label, request))
        return replace(job, sequence=guard.sequence), work, receiver


class _NewRecording(Receiver):
    """Registers a created recording with its labels; the items are lists of warnings."""

    def __init__(
        self,
        context: JobContext,
        request: ImportRequest | SampleRequest,
        guard: Guard,
        label: Callable[[Recording], list[str]],
    ) -> None:
        super().__init__()
        self._context, self._request, self._guard = context, request, guard
        self._label = label

    def finish(self, _job: Job, cancelled: bool) -> dict[str, Any]:
        if cancelled:
            return {}
        recording = self._context.library.recording(self._guard.sequence)
        register(self._context.store, recording.manifest)
        warnings = [warning for found in self.items for warning in found]
        try:
            warnings += self._label(recording)
        except Exception as error:
            raise PointbrushError(f"{WITHOUT_LABELS}: {error}") from error
        finally:
            self._context.publish(SequencesChanged(self._guard.sequence))
        return importing.result(recording, warnings, self._request.up)

    def end(self, job: Job) -> None:
        self._context.store.guards.end(self._guard)
        drop_upload(self._request.upload, job)


class FileImports(NewRecordings[ImportRequest]):
    """Imports of files."""

    request = ImportRequest

    def __init__(self, context: JobContext, complete: Complete, labels: SourceLabels) -> None:
        super().__init__(context, complete)
        self._labels = labels

    def _check(self, request: ImportRequest) -> None:
        for path in request.paths:
            if not any(mark in str(path) for mark in "*?[") and not path.exists():
                raise NotFoundError(f"path: expected a file or folder, {path} does not exist")

    def _work(self, request: ImportRequest, sequence: str) -> Work:
        target = self._library.store.target(sequence)
        return importing.ImportWork(request, target, sequence, self._context.max_points)

    def _label(self, _request: ImportRequest, recording: Recording) -> list[str]:
        return self._labels.import_into(recording)


class SampleImports(NewRecordings[SampleRequest]):
    """Generation of sample recordings."""

    request = SampleRequest

    def _work(self, request: SampleRequest, sequence: str) -> Work:
        return importing.SampleWork(self._library.store.target(sequence), sequence, request)

    def _label(self, request: SampleRequest, recording: Recording) -> list[str]:
        importing.create_sample_labels(self._store, recording, request.kind)
        return []


def register(store: WorkspaceStore, manifest: Manifest) -> None:
    """Make a recording known, in the project of its import if it is a new one."""
    store.recordings.register(
        manifest.id, manifest.points, manifest.identity, manifest.project or FIRST
    )
