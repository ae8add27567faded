"""Requests of imports, as stored with their jobs."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from pointbrush.database.project_tables import FIRST
from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.formats.times.timing import natural_key
from pointbrush.jobs.job import ENDED, Job

UPLOAD = "upload"
"""Key in a job's request: the folder of its uploaded files, or None."""

IMPORT, SAMPLE, LABELS = "import", "sample", "labels"
"""Calls in a job's request: an import of paths, of the sample recording, or of labels."""


@dataclass(frozen=True)
class ImportRequest:
    """An import of files at absolute ``paths``."""

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

    def as_json(self) -> dict[str, Any]:
        """Return the record from which ``Imports.again`` can restart a job."""
        return {
            "call": IMPORT,
            "paths": [str(path) for path in self.paths],
            "name": self.name,
            "fps": self.fps,
            "chosen": asdict(self.chosen),
            "roots": [str(root) for root in self.roots],
            UPLOAD: str(self.upload) if self.upload else None,
            "project": self.project,
        }

    @classmethod
    def of_json(cls, kept: Mapping[str, Any]) -> ImportRequest:
        """Return the request for ``kept`` of ``as_json``."""
        chosen = kept["chosen"] | {"columns": tuple(kept["chosen"]["columns"])}
        return cls(
            tuple(map(Path, kept["paths"])),
            kept["name"],
            kept["fps"],
            Corrections(**chosen),
            tuple(map(Path, kept["roots"])),
            Path(kept[UPLOAD]) if kept.get(UPLOAD) else None,
            kept.get("project", FIRST),
        )


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
