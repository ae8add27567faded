"""Requests of imports, as stored with their jobs."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

from pointbrush.database.job import ENDED, Job
from pointbrush.database.project_tables import FIRST
from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.formats.times.timing import natural_key
from pointbrush.work.job_request import JobRequest

UPLOAD = "upload"
"""Key in a job's request: the folder of its uploaded files, or None."""

IMPORT, SAMPLE, LABELS = "import", "sample", "labels"
"""Calls in a job's request: an import of paths, of the sample recording, or of labels."""


@dataclass(frozen=True)
class ImportRequest(JobRequest):
    """An import of files at absolute ``paths``."""

    call = IMPORT
    paths: tuple[Path, ...]
    name: str | None = None
    fps: float | None = None
    chosen: Corrections = field(default_factory=Corrections)
    """Options for reading the files."""
    roots: tuple[Path, ...] = ()
    """Folders that must contain all files, if any."""
    upload: Path | None = None
    """Folder of its uploaded files, which is removed after the import."""
    project: str = FIRST
    """Id of the project that the recording joins."""

    @property
    def source(self) -> str:
        """Return the source for the recording's manifest; for uploaded files only their names."""
        shown = (path.name if self.upload else str(path) for path in self.paths)
        return ", ".join(shown)

    @property
    def readable(self) -> str:
        """Return the name from which the recording's id derives."""
        from pointbrush.formats import source_name  # slow to load

        return self.name or source_name(self.paths)

    @property
    def up(self) -> str | None:
        """Return the given axis that points up, or None."""
        return self.chosen.up


@dataclass(frozen=True)
class SampleRequest(JobRequest):
    """A generated recording of a ``kind``."""

    call = SAMPLE
    frames: int = 90
    seed: int = 0
    kind: str = "juggling"
    name: ClassVar[None] = None
    upload: ClassVar[None] = None
    up: ClassVar[None] = None
    source: ClassVar[str] = "sample recording"
    """First part of the source in the recording's manifest."""

    @property
    def readable(self) -> str:
        """Return the name from which the recording's id derives."""
        return self.kind


def recordings_in(folder: Path) -> list[Path]:
    """Return the files and folders in a folder, each for one recording.

    Raises NotFoundError, BadInputError for an empty folder.
    """
    if not folder.exists():
        raise NotFoundError(f"path: expected a folder, {folder} does not exist")
    inside = [path for path in folder.iterdir() if path.name[0] != "."] if folder.is_dir() else []
    if not inside:
        raise BadInputError(f"path: expected a folder of recordings, {folder} holds none")
    return sorted(inside, key=natural_key)


def bytes_of(path: Path) -> int:
    """Return the size of a file, or of all files in a folder."""
    files = path.rglob("*") if path.is_dir() else [path]
    return sum(file.stat().st_size for file in files if file.is_file())


def drop_upload(upload: Path | None, job: Job) -> None:
    """Remove the uploaded files of a job if it has ended, as another server may continue it."""
    if upload is not None and job.state in ENDED:
        shutil.rmtree(upload, ignore_errors=True)


def drop_repeated(upload: Path | None, job: Job) -> None:
    """Remove uploaded files of a repeated request, as ``job`` uses the first upload."""
    if upload is not None and (job.request or {}).get(UPLOAD) != str(upload):
        shutil.rmtree(upload, ignore_errors=True)
