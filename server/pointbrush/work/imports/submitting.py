"""Import jobs, which create recordings with their labels from files or the sample."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pointbrush import formats
from pointbrush.database.job import Job
from pointbrush.database.project_tables import FIRST
from pointbrush.errors import (
    ConflictError,
    PointbrushError,
    ReadOnlyError,
    UnavailableError,
)
from pointbrush.lazy import once
from pointbrush.names import composed
from pointbrush.sequences import Manifest
from pointbrush.work.events import SequencesChanged
from pointbrush.work.imports.new_recordings import FileImports, SampleImports, register
from pointbrush.work.imports.requests import ImportRequest, SampleRequest, drop_repeated
from pointbrush.work.imports.source_labels import SourceLabels
from pointbrush.work.job_service import JobContext

if TYPE_CHECKING:
    from pointbrush.values.imports import Preview
    from pointbrush.work.imports.annotating import LabelImports
    from pointbrush.work.imports.previewing import Previews

log = logging.getLogger(__name__)


class Imports:
    """Imports recordings and labels in jobs, and registers them; thread-safe."""

    def __init__(self, context: JobContext) -> None:
        self._context, self._store, self._library = context, context.store, context.library
        self.source_labels = SourceLabels(context.store)
        self.files = FileImports(context, self.complete, self.source_labels)
        self.samples = SampleImports(context, self.complete)

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
            self.source_labels.import_into(self._library.recording(manifest.id))

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
        job = self.files.begin(None, wanted, owner, job_id)
        drop_repeated(wanted.upload, job)
        return job

    def preview(self, paths: Sequence[Path], **request: Any) -> Preview:
        """Preview ``begin``; nothing is written.  Raises the errors of readers."""
        wanted = _request(paths, request)
        limits = formats.Limits(self._context.max_points, roots=wanted.roots)
        return self._previews.of(wanted, limits)

    def begin_sample(self, *, frames: int = 90, seed: int = 0, kind: str = "juggling") -> Job:
        """Generate a sample recording and import it in a job, with a palette for its objects.

        ``kind``: ``juggling`` or ``aerial``.
        """
        return self.samples.begin(None, SampleRequest(frames, seed, kind))

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
        job = self.labels.begin(sequence, wanted, author, job_id)
        drop_repeated(wanted.upload, job)
        return job

    @once
    def labels(self) -> LabelImports:
        """Return the service for imports of labels."""
        from pointbrush.work.imports.annotating import LabelImports

        return LabelImports(self._context)

    def import_source_labels(self, sequence: str, author: str) -> None:
        """Import labels from a recording's own files that its import has not imported.

        A repeated call has no effect.  Raises ConflictError if the files have none, and the errors
        of their import.
        """
        recording = self._library.recording(sequence)
        if "label" not in recording.manifest.fields:
            raise ConflictError(f"labels: expected some in the files of {sequence!r}, got none")
        register(self._store, recording.manifest)
        try:
            self.source_labels.import_into(recording, author)
        finally:
            self._context.publish(SequencesChanged(sequence))

    def close(self) -> None:
        """End the process of previews, if there is one."""
        if Imports._previews.made(self):
            self._previews.close()

    @once
    def _previews(self) -> Previews:
        from pointbrush.work.imports.previewing import Previews

        return Previews()


def _request(paths: Sequence[Path], fields: dict[str, Any]) -> ImportRequest:
    named = {"name": composed(fields["name"])} if fields.get("name") else {}
    return ImportRequest(tuple(path.absolute() for path in paths), **fields | named)
