"""Files of one recording, in a local folder or in a bucket (``bucket.py``)."""

from __future__ import annotations

import os
import shutil
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from pointbrush.sequences.octree.arrays import file_digest
from pointbrush.sequences.storage.checksums import CHECKSUMS, SENSOR, parse_checksums
from pointbrush.sequences.storage.files import replace_file
from pointbrush.sequences.storage.manifest import FILE, Manifest, read_manifest


class RecordingFiles(Protocol):
    """Files of one recording, named by their path in its folder; picklable, opened lazily.

    ``path``         folder of this machine with the files that are held.
    ``open_frames``  frames that may be open at once.
    """

    open_frames: int

    @property
    def path(self) -> Path:
        """See above; raises the errors of ``manifest``."""
        raise NotImplementedError

    def manifest(self) -> Manifest:
        """The manifest; raises NotFoundError when there is none, BadInputError when damaged."""
        raise NotImplementedError

    def checksums(self) -> dict[str, str] | None:
        """The checksums; None when they are missing or damaged."""
        raise NotImplementedError

    def hold(self, index: int, part: str) -> AbstractContextManager[object]:
        """Keep a frame's files under the folder ``part`` at ``path`` while the result exists.

        Raises DamagedError, NotFoundError, UnavailableError.
        """
        raise NotImplementedError

    def is_gone(self) -> bool:
        """Return whether the recording is known to be deleted; does not wait."""
        raise NotImplementedError

    def names(self) -> set[str]:
        """Return all files except the manifest, checksums and files that can be computed again."""
        raise NotImplementedError

    def digest(self, name: str) -> str:
        """Return the current checksum of a file."""
        raise NotImplementedError

    def write(self, name: str, data: bytes) -> None:
        """Put ``data`` in place of a file in one step."""
        raise NotImplementedError

    def copy_to(self, target: Path, earlier: Path | None = None) -> None:
        """Copy all files into the new folder ``target``.

        Files with the same checksum in ``earlier``, the folder of an earlier copy, become links
        to its files.
        """
        raise NotImplementedError


@dataclass(frozen=True)
class FolderFiles:
    """The files are in the folder ``path``."""

    path: Path
    open_frames = 256

    def manifest(self) -> Manifest:
        """See RecordingFiles."""
        return read_manifest(self.path)

    def checksums(self) -> dict[str, str] | None:
        """See RecordingFiles."""
        try:
            return parse_checksums((self.path / CHECKSUMS).read_bytes())
        except OSError:
            return None

    def hold(self, index: int, part: str) -> AbstractContextManager[object]:  # noqa: ARG002
        """See RecordingFiles; all of it is here."""
        return nullcontext()

    def is_gone(self) -> bool:
        """See RecordingFiles."""
        return not self.path.is_dir()

    def names(self) -> set[str]:
        """See RecordingFiles."""
        files = (file for file in self.path.rglob("*") if file.is_file())
        return {str(file.relative_to(self.path)) for file in files} - {CHECKSUMS, FILE, SENSOR}

    def digest(self, name: str) -> str:
        """See RecordingFiles."""
        return file_digest(self.path / name)

    def write(self, name: str, data: bytes) -> None:
        """See RecordingFiles."""
        replace_file(self.path / name, data)

    def copy_to(self, target: Path, earlier: Path | None = None) -> None:
        """See RecordingFiles."""
        kept = KeptFiles(self.checksums(), earlier)

        def copy(source: str, place: str) -> None:
            name = str(Path(source).relative_to(self.path))
            if not kept.link(name, Path(source).stat().st_size, Path(place)):
                shutil.copy2(source, place)

        shutil.copytree(self.path, target, copy_function=copy)


class KeptFiles:
    """The files of a recording that an earlier copy of it has."""

    def __init__(self, checksums: dict[str, str] | None, earlier: Path | None) -> None:
        """``checksums``: of the current files; ``earlier``: the folder of the copy."""
        self._folder = earlier
        self._now = checksums or {}
        self._then = {} if earlier is None else FolderFiles(earlier).checksums() or {}

    def link(self, name: str, size: int, place: Path) -> bool:
        """Link the copy's file to ``place`` and return True, if it is the same."""
        if self._folder is None or self._now.get(name, "") != self._then.get(name):
            return False
        file = self._folder / name
        try:
            if file.stat().st_size == size:
                os.link(file, place)
                return True
        except OSError:  # removed, or a disk without links, or too many links to one file
            pass
        return False


def files_of(place: Path | RecordingFiles) -> RecordingFiles:
    """Return the files of a recording that is in a folder, or ``place`` itself."""
    return FolderFiles(place) if isinstance(place, Path) else place
