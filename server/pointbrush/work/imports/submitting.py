"""Import jobs, which create recordings with their labels from files or the sample."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pointbrush import formats
from pointbrush.database.guards import Guard
from pointbrush.database.project_tables import FIRST
from pointbrush.errors import (
    ConflictError,
    NotFoundError,
    PointbrushError,
    ReadOnlyError,
    UnavailableError,
)
from pointbrush.jobs.job import Job
from pointbrush.jobs.runner import JobRunner
from pointbrush.jobs.worker import Work
from pointbrush.lazy import once
from pointbrush.names import composed, require_visible
from pointbrush.sequences import Manifest
from pointbrush.sequences import Sequence as Recording
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.work.events import Event, SequencesChanged
from pointbrush.work.imports import importing
from pointbrush.work.imports.requests import SAMPLE, ImportRequest, drop_repeated, drop_upload
from pointbrush.work.imports.source_labels import SourceLabels
from pointbrush.work.job_book import JobBook
from pointbrush.work.library import Library
from pointbrush.work.trash import ids_for

if TYPE_CHECKING:
    from pointbrush.work.imports.annotating import LabelImports
    from pointbrush.work.imports.previewing import Preview, Previews

log = logging.getLogger(__name__)

WITHOUT_LABELS = "the recording was imported, but its labels were not imported"
"""Prefix of the error of an import that created a recording without its labels."""


class Imports:
    """Imports recordings and labels in jobs, and registers them; thread-safe."""

    def __init__(
        self,
        library: Library,
        store: WorkspaceStore,
        runner: JobRunner,
        jobs: JobBook,
        publish: Callable[[Event], None],
        max_points: int,
    ) -> None:
        """``max_points``: limit of points in a frame."""
        self._library, self._store, self._runner, self._jobs = library, store, runner, jobs
        self._publish, self._max_points = publish, max_points
        self.source_labels = SourceLabels(store)

    def complete(self, manifests: Iterable[Manifest]) -> None:
        """Complete imports of servers that were killed at the end of an import.

        A failure for one recording does not affect others; raises UnavailableError.
        """
        running = self._store.guards.importing()
        for manifest in manifests:
            if manifest.id in running:
                continue
            try:
                self._complete(manifest)
            except ReadOnlyError:
                log.warning("%s: its import was not completed, and cannot be here", manifest.id)
            except UnavailableError:
                raise
            except (PointbrushError, OSError, ValueError):
                log.exception("the labels that came with %s cannot be read", manifest.id)

    def _complete(self, manifest: Manifest) -> None:
        register(self._store, manifest)
        if "label" in manifest.fields and self._store.revision(manifest.id) == 0:
            self.source_labels.bring(self._library.recording(manifest.id))

    def begin(
        self,
        paths: Sequence[Path],
        *,
        owner: str | None = None,
        job_id: str | None = None,
        **request: Any,
    ) -> Job:
        """Import files as one sequence in a job.

        ``request``: fields of ``ImportRequest``.  ``owner``: account of the caller.  For the
        ``job_id`` of an earlier job of the same owner, that job is returned.  Raises ConflictError
        for another person's job, NotFoundError for an unknown project.
        """
        wanted = _request(paths, request)
        if wanted.project != FIRST:
            self._store.team.projects.get(wanted.project)

        def begin(job_id: str) -> Job:
            for path in wanted.paths:
                if not any(mark in str(path) for mark in "*?[") and not path.exists():
                    raise NotFoundError(f"path: expected a file or folder, {path} does not exist")
            kept = wanted.as_json()
            return self._begin(wanted, Job("import", None, job_id, owner=owner, request=kept))

        job = self._jobs.begin_once(job_id, owner, begin)
        drop_repeated(wanted.upload, job)
        return job

    def preview(self, paths: Sequence[Path], **request: Any) -> Preview:
        """Preview ``begin``; nothing is written.  Raises the errors of readers."""
        wanted = _request(paths, request)
        limits = formats.Limits(self._max_points, roots=wanted.roots)
        return self._previews.of(wanted, limits)

    def begin_sample(self, *, frames: int = 90, seed: int = 0, kind: str = "juggling") -> Job:
        """Generate a sample recording and import it in a job, with a palette for its objects.

        ``kind``: ``juggling`` or ``aerial``.
        """
        request = {"call": SAMPLE, "frames": frames, "seed": seed, "kind": kind}
        return self._begin_sample(frames, seed, kind, Job("import", None, request=request))

    def begin_labels(
        self,
        sequence: str,
        place: Path,
        author: str,
        *,
        job_id: str | None = None,
        **request: Any,
    ) -> Job:
        """Import labels from files as one edit, in a job with a report as its result.

        ``request``: fields of ``LabelRequest``; ``job_id``: see ``begin``.  Raises NotFoundError.
        """
        from pointbrush.work.imports.label_reading import LabelRequest

        wanted = LabelRequest(place=place.absolute(), **request)
        recording = self._library.recording(sequence)
        begin = partial(self._of_labels.start, recording, wanted, author)
        job = self._jobs.begin_once(job_id, author, begin)
        drop_repeated(wanted.upload, job)
        return job

    def labels_again(self, job: Job) -> dict[str, Any] | None:
        """Restart an import of labels; see ``LabelImports.again``."""
        return self._of_labels.again(self._library.recording(job.sequence or ""), job)

    def bring_labels(self, sequence: str, author: str) -> None:
        """Import labels from a recording's own files that its import has not imported.

        A repeated call has no effect.  Raises ConflictError if the files have none, and the errors
        of their import.
        """
        recording = self._library.recording(sequence)
        if "label" not in recording.manifest.fields:
            raise ConflictError(f"labels: expected some in the files of {sequence!r}, got none")
        register(self._store, recording.manifest)
        try:
            self.source_labels.bring(recording, author)
        finally:
            self._publish(SequencesChanged(sequence))

    def close(self) -> None:
        """End the process of previews, if there is one."""
        if Imports._previews.made(self):
            self._previews.close()

    @once
    def _previews(self) -> Previews:
        from pointbrush.work.imports.previewing import Previews

        return Previews()

    @once
    def _of_labels(self) -> LabelImports:
        from pointbrush.work.imports.annotating import LabelImports

        return LabelImports(self._store, self._runner, self._max_points)

    def again(self, job: Job) -> dict[str, Any] | None:
        """Restart an import of an ended server; return its result if it was already done.

        Raises the errors of the first call.
        """
        kept = job.request or {}
        request = None if kept["call"] == SAMPLE else ImportRequest.of_json(kept)
        source = importing.SAMPLE if request is None else request.source
        if job.sequence is not None and self._library.has(job.sequence):
            recording = self._library.recording(job.sequence)
            if recording.manifest.source.startswith(source):
                self.complete([recording.manifest])
                return importing.result(recording, [], _given_up(job))
        if request is None:
            self._begin_sample(kept["frames"], kept["seed"], kept.get("kind", "juggling"), job)
        else:
            self._begin(request, job)
        return None

    def _begin(self, request: ImportRequest, job: Job) -> Job:
        if request.name:
            require_visible("name", request.name)
        guard = self._reserve(request.name or formats.source_name(request.paths))
        work = importing.ImportWork(
            paths=request.paths,
            target=self._library.store.target(guard.sequence),
            sequence_id=guard.sequence,
            name=request.name,
            fps=request.fps,
            chosen=request.chosen,
            max_points=self._max_points,
            roots=request.roots,
            source=request.source,
            project=request.project,
        )
        return self._submit(guard, work, self.source_labels.bring, job, request.upload)

    def _begin_sample(self, frames: int, seed: int, kind: str, job: Job) -> Job:
        guard = self._reserve(kind)
        sequence = guard.sequence
        target = self._library.store.target(sequence)
        work = importing.SampleWork(target, sequence, frames, seed, kind)
        label = partial(importing.create_sample_labels, self._store, kind=kind)
        return self._submit(guard, work, label, job)

    def _reserve(self, name: str) -> Guard:
        """Reserve a readable, URL-safe id derived from ``name``."""
        self._library.require_writable()
        self._library.store.clear_remains(self._store.guards.importing)
        return self._store.guards.reserve(ids_for(name), self._library.is_free)

    def _submit(
        self,
        guard: Guard,
        work: Work,
        label: Callable[[Recording], list[str]],
        job: Job,
        upload: Path | None = None,
    ) -> Job:
        sequence = guard.sequence
        warnings: list[str] = []

        def finish(_: Job, cancelled: bool) -> dict[str, Any]:
            if cancelled:
                return {}
            recording = self._library.recording(sequence)
            register(self._store, recording.manifest)
            try:
                warnings.extend(label(recording))
            except Exception as error:
                raise PointbrushError(f"{WITHOUT_LABELS}: {error}") from error
            finally:
                self._publish(SequencesChanged(sequence))
            return importing.result(recording, warnings, _given_up(job))

        def done(ended: Job) -> None:
            self._store.guards.end(guard)
            drop_upload(upload, ended)

        try:
            return self._runner.submit(
                replace(job, sequence=sequence),
                work,
                finish,
                on_item=lambda _, found: warnings.extend(found),
                done=done,
            )
        except BaseException:
            self._store.guards.end(guard)
            raise


def register(store: WorkspaceStore, manifest: Manifest) -> None:
    """Make a recording known, in the project of its import if it is a new one."""
    store.recordings.register(
        manifest.id, manifest.points, manifest.identity, manifest.project or FIRST
    )


def _given_up(job: Job) -> str | None:
    """Return the up axis in the request of an import, or None."""
    up = (job.request or {}).get("chosen", {}).get("up")
    return None if up is None else str(up)


def _request(paths: Sequence[Path], fields: dict[str, Any]) -> ImportRequest:
    named = {"name": composed(fields["name"])} if fields.get("name") else {}
    return ImportRequest(tuple(path.absolute() for path in paths), **fields | named)
