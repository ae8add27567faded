"""Recordings and labels that come in: the part of the façade that imports."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from pointbrush import formats
from pointbrush.errors import ConflictError
from pointbrush.formats.corrections import Corrections
from pointbrush.formats.datasets import ClassName
from pointbrush.jobs import Job, JobRunner
from pointbrush.labels import LabelStore
from pointbrush.lazy import once
from pointbrush.sequences import Sequence as Recording
from pointbrush.settings import Settings
from pointbrush.work.imports.submitting import ImportRequest, Imports, drop_repeated
from pointbrush.work.job_book import JobBook
from pointbrush.work.library import Library

if TYPE_CHECKING:
    from pointbrush.work.imports.annotating import LabelImports
    from pointbrush.work.imports.previewing import Preview, Previews


class Importing(ABC):
    """Imports into a workspace, which ``Workspace`` is the whole of; thread-safe."""

    settings: Settings
    library: Library
    store: LabelStore
    runner: JobRunner
    _imports: Imports
    _job_book: JobBook

    @abstractmethod
    def recording(self, sequence: str) -> Recording:
        """The stored recording; raises NotFoundError, DamagedError."""

    def require_importable(self) -> None:
        """Raise ReadOnlyError where nothing can be imported: before an upload is taken in."""
        self.library.require_writable()

    def import_paths(
        self,
        paths: Sequence[Path],
        *,
        name: str | None = None,
        fps: float | None = None,
        chosen: Corrections | None = None,
        cleanup: Path | None = None,
        roots: Sequence[Path] = (),
        owner: str | None = None,
        job_id: str | None = None,
    ) -> Job:
        """Import files as one sequence in a job; ``cleanup`` is removed when it has ended.

        ``chosen`` is what a person says of the files.  With ``roots``, nothing that lies or leads
        outside them is read.  ``owner``: who asks.  With the ``job_id`` of a job that they have
        begun before, that job is returned and nothing is begun; raises ConflictError for another
        person's.
        """
        absolute = tuple(path.absolute() for path in paths)
        request = ImportRequest(absolute, name, fps, chosen or Corrections(), tuple(roots), cleanup)
        begin = partial(self._imports.of_paths, request, owner)
        job = self._job_book.begin_once(job_id, owner, begin)
        drop_repeated(cleanup, job)
        return job

    def preview(
        self,
        paths: Sequence[Path],
        *,
        name: str | None = None,
        fps: float | None = None,
        chosen: Corrections | None = None,
        roots: Sequence[Path] = (),
    ) -> Preview:
        """Preview ``import_paths``; nothing is written. Raises what readers raise."""
        from pointbrush.work.imports.previewing import PreviewRequest

        limits = formats.Limits(self.settings.max_frame_points, roots=tuple(roots))
        absolute = tuple(path.absolute() for path in paths)
        return self._previews.of(
            PreviewRequest(absolute, chosen or Corrections(), limits, name, fps)
        )

    def import_labels(
        self,
        sequence: str,
        place: Path,
        author: str,
        *,
        label_format: str | None = None,
        names: Mapping[int, ClassName] | None = None,
        dry_run: bool = False,
        no_ground: bool = False,
        by_order: bool = False,
        field: str | None = None,
        roots: Sequence[Path] = (),
        cleanup: Path | None = None,
        job_id: str | None = None,
    ) -> Job:
        """Import labels made elsewhere as one edit, in a job whose result reports what was found.

        ``names`` are class names by number; ``dry_run`` writes nothing; ``no_ground`` leaves the
        ground out of boxes; ``field`` names the field of points that is labels; ``cleanup`` is
        removed when the job has ended; ``job_id`` as of ``import_paths``.  Raises NotFoundError.
        """
        from pointbrush.work.imports.label_reading import LabelRequest

        request = LabelRequest(
            place.absolute(),
            label_format,
            dict(names or {}),
            dry_run,
            no_ground,
            by_order,
            field,
            tuple(roots),
            cleanup,
        )
        begin = partial(self._label_imports.start, self.recording(sequence), request, author)
        job = self._job_book.begin_once(job_id, author, begin)
        drop_repeated(cleanup, job)
        return job

    def import_source_labels(self, sequence: str, author: str) -> None:
        """Bring in the labels in a recording's own files, which did not come in with it.

        Where they did, nothing happens.  Raises ConflictError where the files have none, and what
        keeps them out.
        """
        recording = self.recording(sequence)
        if "label" not in recording.manifest.fields:
            raise ConflictError(f"labels: expected some in the files of {sequence!r}, got none")
        self._imports.complete_labels(recording, author)

    def import_sample(self, *, frames: int = 90, seed: int = 0) -> Job:
        """Make the sample recording and import it, with a palette for its objects."""
        return self._imports.of_sample(frames, seed)

    def import_roots(self, *, own: bool) -> list[Path]:
        """Folders that a caller over the network may import from.

        ``own``: where none are named, the current folder and the home folder; the caller is who
        started the server, on this machine.
        """
        return self.settings.roots or (self.settings.own_roots if own else [])

    def end_previews(self) -> None:
        """End the process of previews, if there is one."""
        if Importing._previews.made(self):
            self._previews.close()

    @once
    def _previews(self) -> Previews:
        from pointbrush.work.imports.previewing import Previews

        return Previews()

    @once
    def _label_imports(self) -> LabelImports:
        from pointbrush.work.imports.annotating import LabelImports

        return LabelImports(self.store, self.runner, self.settings.max_frame_points)
