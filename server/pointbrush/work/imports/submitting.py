"""Import jobs: files, or the sample, become a recording with the labels that came with it."""

from __future__ import annotations

import logging
import shutil
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from pointbrush.errors import NotFoundError, PointbrushError, ReadOnlyError, UnavailableError
from pointbrush.formats import source_name
from pointbrush.formats.corrections import Corrections
from pointbrush.jobs import Job, JobRunner
from pointbrush.labels import LabelStore
from pointbrush.labels.guards import Guard
from pointbrush.sequences import Manifest
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.events import Event, SequencesChanged
from pointbrush.work.imports import importing
from pointbrush.work.library import Library, ids_for
from pointbrush.worker import Work

log = logging.getLogger(__name__)


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
            recording = self._library.recording(manifest.id)
            importing.import_source_labels(self._store, recording)

    def of_paths(
        self,
        paths: Sequence[Path],
        *,
        name: str | None,
        fps: float | None,
        chosen: Corrections,
        cleanup: Path | None,
        roots: Sequence[Path],
        owner: str | None,
    ) -> Job:
        """See ``Workspace.import_paths``."""
        for path in paths:
            if not any(mark in str(path) for mark in "*?[") and not path.exists():
                raise NotFoundError(f"path: expected a file or folder, {path} does not exist")
        guard = self._reserve(name or source_name(paths))
        sequence = guard.sequence
        work = importing.ImportWork(
            paths=tuple(path.absolute() for path in paths),
            target=self._library.folder / sequence,
            sequence_id=sequence,
            name=name,
            fps=fps,
            chosen=chosen,
            max_points=self._max_points,
            roots=tuple(roots),
        )
        return self._submit(guard, work, importing.import_source_labels, cleanup, owner)

    def of_sample(self, frames: int, seed: int) -> Job:
        """See ``Workspace.import_sample``."""
        guard = self._reserve("juggling")
        sequence = guard.sequence
        work = importing.SampleWork(self._library.folder / sequence, sequence, frames, seed)
        return self._submit(guard, work, importing.create_sample_labels)

    def _reserve(self, name: str) -> Guard:
        """A readable, URL-safe id made from ``name``; nobody else gets it meanwhile."""
        self._library.require_writable()
        return self._store.guards.reserve(ids_for(name), self._library.is_free)

    def _submit(
        self,
        guard: Guard,
        work: Work,
        label: Callable[[LabelStore, Recording], None],
        cleanup: Path | None = None,
        owner: str | None = None,
    ) -> Job:
        sequence = guard.sequence
        warnings: list[str] = []

        def finish(_: Job, cancelled: bool) -> dict[str, Any]:
            if cancelled:
                return {}
            recording = self._library.recording(sequence)
            self._store.register(sequence, recording.manifest.points, recording.identity)
            label(self._store, recording)
            self._publish(SequencesChanged(sequence))
            return importing.result(recording, warnings)

        def done(_: Job) -> None:
            self._store.guards.end(guard)
            if cleanup is not None:
                shutil.rmtree(cleanup, ignore_errors=True)

        try:
            return self._runner.submit(
                "import",
                sequence,
                work,
                finish,
                on_item=lambda _, found: warnings.extend(found),
                done=done,
                owner=owner,
            )
        except BaseException:
            self._store.guards.end(guard)
            raise
