"""Files of one recording, in a local folder or in a bucket (``bucket.py``)."""

from __future__ import annotations

import os
import shutil
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path

from pointbrush.sequences.octree.arrays import file_digest
from pointbrush.sequences.storage.checksums import CHECKSUMS, SENSOR, parse_checksums
from pointbrush.sequences.storage.files import replace_file
from pointbrush.sequences.storage.manifest import FILE, Manifest, read_manifest


@dataclass(frozen=True)
class FolderFiles:
    """Files in a folder, named by their path in it; picklable, opened lazily."""

    path: Path
    """Folder of this machine with the files that are held."""
    open_frames = 256
    """Frames that may be open at once."""

    def manifest(self) -> Manifest:
        """The manifest; raises NotFoundError when there is none, BadInputError when damaged."""
        return read_manifest(self.path)

    def checksums(self) -> dict[str, str] | None:
        """The checksums; None when they are missing or damaged."""
        try:
            return parse_checksums((self.path / CHECKSUMS).read_bytes())
        except OSError:
            return None

    def hold(self, index: int, part: str) -> AbstractContextManager[object]:  # noqa: ARG002
        """Keep a frame's files under the folder ``part`` at ``path`` while the result exists.

        Raises DamagedError, NotFoundError, UnavailableError.
        """
        return nullcontext()

    def is_gone(self) -> bool:
        """Return whether the recording is known to be deleted; does not wait."""
        return not self.path.is_dir()

    def names(self) -> set[str]:
        """Return all files except the manifest, checksums and files that can be computed again."""
        files = (file for file in self.path.rglob("*") if file.is_file())
        return {str(file.relative_to(self.path)) for file in files} - {CHECKSUMS, FILE, SENSOR}

    def digest(self, name: str) -> str:
        """Return the current checksum of a file."""
        return file_digest(self.path / name)

    def write(self, name: str, data: bytes) -> None:
        """Put ``data`` in place of a file in one step."""
        replace_file(self.path / name, data)

    def copy_to(self, target: Path, earlier: Path | None = None) -> None:
        """Copy all files into the new folder ``target``.

        Files with the same checksum in ``earlier``, the folder of an earlier copy, become links
        to its files.
        """
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
