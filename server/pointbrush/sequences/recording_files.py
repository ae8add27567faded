"""Files of one recording, wherever they are: in a folder here, or in a bucket (``bucket.py``)."""

from __future__ import annotations

import shutil
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from pointbrush.sequences.checksums import CHECKSUMS, SENSOR, parse_checksums
from pointbrush.sequences.files import replace_file
from pointbrush.sequences.manifest import FILE, Manifest, read_manifest
from pointbrush.sequences.octree.arrays import file_digest


class RecordingFiles(Protocol):
    """Files of one recording, named by their path in its folder; picklable, opened lazily.

    ``path``         folder of this machine where the files are, as far as they are held.
    ``open_frames``  frames that may be open at once.
    """

    open_frames: int

    @property
    def path(self) -> Path:
        """See above; raises what ``manifest`` raises."""
        raise NotImplementedError

    def manifest(self) -> Manifest:
        """The manifest; raises NotFoundError when there is none, BadInputError when damaged."""
        raise NotImplementedError

    def checksums(self) -> dict[str, str] | None:
        """The checksums; None when they are missing or damaged."""
        raise NotImplementedError

    def hold(self, index: int, part: str) -> AbstractContextManager[object]:
        """Have a frame's files under the folder ``part`` at ``path`` while the result is kept.

        Raises DamagedError, NotFoundError, UnavailableError.
        """
        raise NotImplementedError

    def is_gone(self) -> bool:
        """Whether the recording is known not to be there any more; does not wait for anything."""
        raise NotImplementedError

    def names(self) -> set[str]:
        """All files but the manifest, checksums and what is found again."""
        raise NotImplementedError

    def digest(self, name: str) -> str:
        """The checksum of a file as it is now."""
        raise NotImplementedError

    def write(self, name: str, data: bytes) -> None:
        """Put ``data`` in place of a file in one step."""
        raise NotImplementedError

    def copy_to(self, target: Path) -> None:
        """Copy all files into the new folder ``target``."""
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

    def copy_to(self, target: Path) -> None:
        """See RecordingFiles."""
        shutil.copytree(self.path, target)


def files_of(place: Path | RecordingFiles) -> RecordingFiles:
    """Return the files of a recording that is in a folder, or ``place`` itself."""
    return FolderFiles(place) if isinstance(place, Path) else place
