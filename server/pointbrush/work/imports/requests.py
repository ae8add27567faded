"""Requests of imports, as the jobs that carry them out keep them."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.formats.corrections import Corrections
from pointbrush.formats.timing import natural_key
from pointbrush.job import ENDED, Job
from pointbrush.labels.project_tables import FIRST

UPLOAD = "upload"
"""Of a job's request: the folder of its uploaded files, or None."""

IMPORT, SAMPLE, LABELS = "import", "sample", "labels"
"""Of a job's request: an import of paths, of the sample recording, or of labels made elsewhere."""


@dataclass(frozen=True)
class ImportRequest:
    """An import of files that are at absolute ``paths``."""

    paths: tuple[Path, ...]
    name: str | None = None
    fps: float | None = None
    chosen: Corrections = field(default_factory=Corrections)
    """Choices of a person on how the files are read."""
    roots: tuple[Path, ...] = ()
    """Folders outside which nothing is read, if any."""
    upload: Path | None = None
    """Folder of files that were uploaded for it, which goes when the import has ended."""
    project: str = FIRST
    """Id of the project that the recording joins."""

    @property
    def source(self) -> str:
        """Origin of the recording as its manifest says; of uploaded files their names alone."""
        shown = (path.name if self.upload else str(path) for path in self.paths)
        return ", ".join(shown)

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
            "project": self.project,
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
            kept.get("project", FIRST),
        )


def recordings_in(folder: Path) -> list[Path]:
    """Return the files and folders in a folder, each of which is to be a recording.

    Raises NotFoundError, BadInputError where there is none in it.
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
    """Remove the uploaded files of a job that has ended; another server may go on with it."""
    if upload is not None and job.state in ENDED:
        shutil.rmtree(upload, ignore_errors=True)


def drop_repeated(upload: Path | None, job: Job) -> None:
    """Remove uploaded files that ``job`` does not read, as it was begun with the first upload."""
    if upload is not None and (job.request or {}).get(UPLOAD) != str(upload):
        shutil.rmtree(upload, ignore_errors=True)
