"""Import jobs: files, or the sample, become a recording with the labels that came with it."""

from __future__ import annotations

import logging
import shutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from pointbrush import formats
from pointbrush.errors import NotFoundError, PointbrushError, ReadOnlyError, UnavailableError
from pointbrush.formats.corrections import Corrections
from pointbrush.jobs import ENDED, Job, JobRunner
from pointbrush.labels import LabelStore
from pointbrush.labels.guards import Guard
from pointbrush.names import require_visible
from pointbrush.sequences import Manifest
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.events import Event, SequencesChanged
from pointbrush.work.imports import importing
from pointbrush.work.imports.source_labels import SourceLabels
from pointbrush.work.library import Library
from pointbrush.work.trash import ids_for
from pointbrush.worker import Work

log = logging.getLogger(__name__)

UPLOAD = "upload"
"""Of a job's request: the folder of its uploaded files, or None."""

WITHOUT_LABELS = "the recording is there, but its labels did not come in"
"""Beginning of the error of an import that made a recording and not its labels."""

IMPORT, SAMPLE, LABELS = "import", "sample", "labels"
"""Of a job's request: an import of paths, of the sample recording, or of labels made elsewhere."""


@dataclass(frozen=True)
class ImportRequest:
    """An import of files that are at absolute ``paths``; see ``Workspace.import_paths``."""

    paths: tuple[Path, ...]
    name: str | None = None
    fps: float | None = None
    chosen: Corrections = field(default_factory=Corrections)
    roots: tuple[Path, ...] = ()
    upload: Path | None = None
    """Folder of files that were uploaded for it, which goes when the import has ended."""

    @property
    def source(self) -> str:
        """Origin of the recording as its manifest says."""
        return importing.source_of(self.paths)

    def as_json(self) -> dict[str, Any]:
        """Return the record a job keeps, to be begun again by ``Imports.again``."""
        return {
            "call": IMPORT,
            "paths": [str(path) for path in self.paths],
            "name": self.name,
            "fps": self.fps,
            "chosen": asdict(self.chosen),
            "roots": [str(root) for root in self.roots],
            UPLOAD: str(self.upload) if self.upload else None,
        }

    @classmethod
    def of_json(cls, kept: Mapping[str, Any]) -> ImportRequest:
        """Return the request that ``as_json`` made ``kept`` of."""
        chosen = kept["chosen"] | {"columns": tuple(kept["chosen"]["columns"])}
        return cls(
            tuple(map(Path, kept["paths"])),
            kept["name"],
            kept["fps"],
            Corrections(**chosen),
            tuple(map(Path, kept["roots"])),
            Path(kept[UPLOAD]) if kept.get(UPLOAD) else None,
        )


def drop_upload(upload: Path | None, job: Job) -> None:
    """Remove the uploaded files of a job that has ended; another server may go on with it."""
    if upload is not None and job.state in ENDED:
        shutil.rmtree(upload, ignore_errors=True)


def drop_repeated(upload: Path | None, job: Job) -> None:
    """Remove uploaded files that ``job`` does not read, as it was begun with the first upload."""
    if upload is not None and (job.request or {}).get(UPLOAD) != str(upload):
        shutil.rmtree(upload, ignore_errors=True)


class Imports:
    """Starts imports into a library, and makes what they bring known."""

    def __init__(
        self,
        library: Library,
        store: LabelStore,
        runner: JobRunner,
        publish: Callable[[Event], None],
        max_points: int,
    ) -> None:
        """``max_points``: most points of a frame that is read."""
        self._library, self._store, self._runner = library, store, runner
        self._publish, self._max_points = publish, max_points
        self.source_labels = SourceLabels(store)

    def complete(self, manifests: Iterable[Manifest]) -> None:
        """Do what a server that was killed as an import ended has left out.

        One recording that cannot be completed keeps no other from it; raises UnavailableError.
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
        self._store.register(manifest.id, manifest.points, manifest.identity)
        if "label" in manifest.fields and self._store.revision(manifest.id) == 0:
            self.source_labels.bring(self._library.recording(manifest.id))

    def complete_labels(self, recording: Recording, author: str) -> None:
        """See ``Workspace.import_source_labels``."""
        sequence = recording.manifest.id
        self._store.register(sequence, recording.manifest.points, recording.identity)
        try:
            self.source_labels.bring(recording, author)
        finally:
            self._publish(SequencesChanged(sequence))

    def of_paths(self, request: ImportRequest, owner: str | None, job_id: str) -> Job:
        """See ``Workspace.import_paths``."""
        for path in request.paths:
            if not any(mark in str(path) for mark in "*?[") and not path.exists():
                raise NotFoundError(f"path: expected a file or folder, {path} does not exist")
        kept = request.as_json()
        return self._begin(request, Job("import", None, job_id, owner=owner, request=kept))

    def of_sample(self, frames: int, seed: int) -> Job:
        """See ``Workspace.import_sample``."""
        request = {"call": SAMPLE, "frames": frames, "seed": seed}
        return self._begin_sample(frames, seed, Job("import", None, request=request))

    def again(self, job: Job) -> dict[str, Any] | None:
        """Begin an import again that another server has left; return its result if it was done.

        Raises what the first call raises.
        """
        kept = job.request or {}
        request = None if kept["call"] == SAMPLE else ImportRequest.of_json(kept)
        source = importing.SAMPLE if request is None else request.source
        if job.sequence is not None and self._library.has(job.sequence):
            recording = self._library.recording(job.sequence)
            if recording.manifest.source.startswith(source):
                return importing.result(recording, [])
        if request is None:
            self._begin_sample(kept["frames"], kept["seed"], job)
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
        )
        return self._submit(guard, work, self.source_labels.bring, job, request.upload)

    def _begin_sample(self, frames: int, seed: int, job: Job) -> Job:
        guard = self._reserve("juggling")
        sequence = guard.sequence
        target = self._library.store.target(sequence)
        work = importing.SampleWork(target, sequence, frames, seed)
        label = partial(importing.create_sample_labels, self._store)
        return self._submit(guard, work, label, job)

    def _reserve(self, name: str) -> Guard:
        """A readable, URL-safe id made from ``name``; nobody else gets it meanwhile."""
        self._library.require_writable()
        self._library.store.clear_remains(self._store.guards.importing)
        return self._store.guards.reserve(ids_for(name), self._library.is_free)

    def _submit(
        self,
        guard: Guard,
        work: Work,
        label: Callable[[Recording], None],
        job: Job,
        upload: Path | None = None,
    ) -> Job:
        sequence = guard.sequence
        warnings: list[str] = []

        def finish(_: Job, cancelled: bool) -> dict[str, Any]:
            if cancelled:
                return {}
            recording = self._library.recording(sequence)
            self._store.register(sequence, recording.manifest.points, recording.identity)
            try:
                label(recording)
            except Exception as error:
                raise PointbrushError(f"{WITHOUT_LABELS}: {error}") from error
            finally:
                self._publish(SequencesChanged(sequence))
            return importing.result(recording, warnings)

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
