"""Recordings of a workspace in a folder."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pointbrush.errors import BadInputError, ReadOnlyError, UnavailableError
from pointbrush.sequences import clean_temporary, update_manifest
from pointbrush.sequences.storage.files import room_for, staged, sync_folder
from pointbrush.sequences.storage.frame_files import FRAMES
from pointbrush.sequences.storage.manifest import FILE
from pointbrush.sequences.storage.recording_files import FolderFiles
from pointbrush.sequences.storage.stored_files import RecordingFiles
from pointbrush.system.permissions import writable
from pointbrush.work.trash import Trash

Progress = Callable[[float, str], None]
Version = object
"""Opaque value that differs after each change of a manifest."""


@dataclass(frozen=True)
class FolderTarget:
    """The new folder ``path`` of a recording that does not exist yet; picklable."""

    path: Path

    @contextmanager
    def building(self, progress: Progress) -> Iterator[Path]:  # noqa: ARG002 - it needs no upload
        """Yield the path of a new folder, which becomes the recording when the block ends.

        It is removed if the block raises.  It gets its name once all files in it are complete.
        The id is reserved for this import, so an existing folder is from an earlier attempt of a
        process that died before it could report its end.
        """
        with room_for(self.path.name), staged(self.path.parent) as partial:
            yield partial / self.path.name
            shutil.rmtree(self.path, ignore_errors=True)
            (partial / self.path.name).rename(self.path)
            sync_folder(self.path.parent)


class FolderStore:
    """Recordings are folders in ``folder``, which has temporary files too.

    Every method raises UnavailableError if the folder is unreachable.
    """

    at_once = 1
    """Best number of recordings to read in parallel."""

    def __init__(self, folder: Path) -> None:
        """Create or open the folder; raises BadInputError if it cannot be used."""
        self.folder = folder
        make_folder("workspace", folder)
        self.deleted = Trash(folder)
        """Storage of deleted recordings."""
        self._root = os.fspath(folder)  # faster to join than paths
        self._missing: dict[str, tuple[tuple[Version | None, Version | None], str | None]] = {}

    def require_writable(self) -> None:
        """Raise ReadOnlyError if recordings cannot be added, changed or removed here."""
        if not writable(self.folder):
            raise ReadOnlyError(
                "the workspace's folder is read-only: recordings can be viewed and exported, not "
                "imported, changed or removed"
            )

    def require_answer(self) -> None:
        """Raise UnavailableError if the store is unreachable."""
        if not self.folder.is_dir():
            raise UnavailableError("expected the workspace's folder of recordings, it is missing")

    def ids(self) -> list[str]:
        """Return the ids of all recordings, including damaged ones."""
        with os.scandir(self.folder) as found:  # it knows folders without a stat of each
            return [each.name for each in found if each.name[0] != "." and each.is_dir()]

    def version(self, sequence: str) -> Version | None:
        """Return the version of a manifest; None: it does not exist."""
        return _stamp_of(f"{self._root}/{sequence}/{FILE}")

    def forget(self, sequence: str) -> None:
        """Drop the cache of a changed recording; there is none of a folder."""

    def has(self, sequence: str) -> bool:
        """Return whether there is a recording with this id, even a damaged one."""
        return (self.folder / sequence).is_dir()

    def is_free(self, sequence: str) -> bool:
        """Return whether this name is free."""
        return not os.path.lexists(self.folder / sequence)

    def files(self, sequence: str) -> FolderFiles:
        """Return the files of a recording."""
        return FolderFiles(self.folder / sequence)

    def missing(self, files: RecordingFiles, frames: int) -> str | None:
        """Return a sentence about missing files of frames, if a fast check finds any."""
        root = os.fspath(files.path)
        stamps = _stamp_of(f"{root}/{FILE}"), _stamp_of(f"{root}/{FRAMES}")
        known = self._missing.get(root)
        if known is None or known[0] != stamps:
            known = self._missing[root] = stamps, _missing_in(files.path / FRAMES, frames)
        return known[1]

    def update(self, sequence: str, **fields: Any) -> None:
        """Change fields of a manifest."""
        update_manifest(self.folder / sequence, **fields)

    def target(self, sequence: str) -> FolderTarget:
        """Return the target of a new recording with this id."""
        return FolderTarget(self.folder / sequence)

    def staging(self) -> AbstractContextManager[Path]:
        """Yield the path of a new temporary folder for ``publish``."""
        return staged(self.folder)

    def publish(self, made: Path, sequence: str) -> None:
        """Add the recording in the folder ``made`` to the store."""
        made.rename(self.folder / sequence)

    def clean(self) -> None:
        """Remove remains of killed imports on this machine."""
        clean_temporary(self.folder)
        for path in self.folder.glob(".deleted-*"):  # of early versions
            shutil.rmtree(path, ignore_errors=True)

    def clear_remains(self, importing: Callable[[], set[str]]) -> None:
        """Remove other remains of killed imports; there are none.

        ``importing()`` returns unfinished imports.
        """


def make_folder(name: str, folder: Path) -> None:
    """Create the folder of option ``name`` if it does not exist; raises BadInputError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(
            f"{name}: expected a folder to write in, got {folder}: {error.strerror}"
        ) from None


def _stamp_of(path: str) -> Version | None:
    """Return a file's inode and time, as each change of a manifest replaces its file."""
    with suppress(FileNotFoundError, NotADirectoryError, ValueError):
        found = os.stat(path)  # noqa: PTH116 - a Path would double the time
        return found.st_ino, found.st_mtime_ns
    return None


NAMED = 3
"""Limit of missing files named in a sentence."""


def _missing_in(frames: Path, count: int) -> str | None:
    try:
        there = {path.name for path in frames.iterdir()}
    except OSError:
        there = set()
    wanted = [name for i in range(count) for name in _files_of(i, there)]
    missing = [name for name in wanted if name not in there]
    if not missing:
        return None
    named = ", ".join(f"{FRAMES}/{name}" for name in missing[:NAMED])
    more = f" and {len(missing) - NAMED} more" if len(missing) > NAMED else ""
    return f"files of its frames are missing: {named}{more}"


def _files_of(frame: int, there: set[str]) -> tuple[str, str]:
    """Return the names of the two parts of a frame; an octree's points are a folder."""
    stem = f"{frame:06d}"
    return stem if stem in there else f"{stem}.points", f"{stem}.wire"
