"""The interface of stores of a workspace's recordings, and the store in a folder."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from pointbrush.errors import BadInputError, ReadOnlyError, UnavailableError
from pointbrush.labels import Known
from pointbrush.sequences import Manifest, clean_temporary, update_manifest
from pointbrush.sequences.storage.files import room_for, staged, sync_folder
from pointbrush.sequences.storage.frame_files import FRAMES
from pointbrush.sequences.storage.manifest import FILE
from pointbrush.sequences.storage.recording_files import FolderFiles, RecordingFiles
from pointbrush.system.permissions import writable
from pointbrush.work.trash import Trash

Progress = Callable[[float, str], None]
Version = object
"""Opaque value that differs after each change of a manifest."""


class ImportTarget(Protocol):
    """Place of a recording that does not exist yet; picklable."""

    def building(self, progress: Progress) -> AbstractContextManager[Path]:
        """Yield the path of a new folder, which becomes the recording when the block ends.

        It is removed if the block raises.
        """
        raise NotImplementedError


class DeletedPlace(Protocol):
    """Storage of deleted recordings; each step can be interrupted and repeated."""

    def alone(self) -> AbstractContextManager[None]:
        """Exclude moves of recordings by other processes of this machine."""
        raise NotImplementedError

    def is_empty(self) -> bool:
        """Return whether it has no recordings."""
        raise NotImplementedError

    def is_unmoved(self, known: Known) -> bool:
        """Return whether a deleted recording is still among the others."""
        raise NotImplementedError

    def is_in_trash(self, known: Known) -> bool:
        """Return whether a restored recording is still here and can be moved back."""
        raise NotImplementedError

    def manifest(self, known: Known) -> Manifest | None:
        """Return the manifest of a deleted recording, or None if it cannot be read."""
        raise NotImplementedError

    def ids_for(self, known: Known) -> Iterator[str]:
        """Yield ids under which a recording can be restored, best first."""
        raise NotImplementedError

    def has_room(self, known: Known, sequence: str) -> bool:
        """Return whether no files prevent its restoration under the id ``sequence``."""
        raise NotImplementedError

    def move_to_trash(self, known: Known) -> None:
        """Move a recording away from the others."""
        raise NotImplementedError

    def move_back(self, known: Known) -> None:
        """Move a recording back to the others, under its current id."""
        raise NotImplementedError

    def purge(self, known: Known) -> None:
        """Remove a deleted recording permanently."""
        raise NotImplementedError


class SequenceStore(Protocol):
    """A store of recordings, each with an id, files and a required manifest.

    ``folder`` folder of this machine for temporary files.
    ``deleted``  storage of deleted recordings.
    ``at_once`` best number of recordings to read in parallel.
    Every method raises UnavailableError if the store is unreachable.
    """

    folder: Path
    at_once: int

    @property
    def deleted(self) -> DeletedPlace:
        """Return the storage of deleted recordings."""
        raise NotImplementedError

    def require_writable(self) -> None:
        """Raise ReadOnlyError if recordings cannot be added, changed or removed here."""
        raise NotImplementedError

    def require_answer(self) -> None:
        """Raise UnavailableError if the store is unreachable."""
        raise NotImplementedError

    def ids(self) -> list[str]:
        """Return the ids of all recordings, including damaged ones."""
        raise NotImplementedError

    def version(self, sequence: str) -> Version | None:
        """Return the version of a manifest; None: it does not exist."""
        raise NotImplementedError

    def forget(self, sequence: str) -> None:
        """Drop the cache of a changed recording."""
        raise NotImplementedError

    def has(self, sequence: str) -> bool:
        """Return whether there is a recording with this id, even a damaged one."""
        raise NotImplementedError

    def is_free(self, sequence: str) -> bool:
        """Return whether this name is free."""
        raise NotImplementedError

    def files(self, sequence: str) -> RecordingFiles:
        """Return the files of a recording."""
        raise NotImplementedError

    def missing(self, files: RecordingFiles, frames: int) -> str | None:
        """Return a sentence about missing files of frames, if a fast check finds any."""
        raise NotImplementedError

    def update(self, sequence: str, **fields: Any) -> None:
        """Change fields of a manifest."""
        raise NotImplementedError

    def target(self, sequence: str) -> ImportTarget:
        """Return the target of a new recording with this id."""
        raise NotImplementedError

    def staging(self) -> AbstractContextManager[Path]:
        """Yield the path of a new temporary folder for ``publish``."""
        raise NotImplementedError

    def publish(self, made: Path, sequence: str) -> None:
        """Add the recording in the folder ``made`` to the store."""
        raise NotImplementedError

    def clean(self) -> None:
        """Remove remains of killed imports on this machine."""
        raise NotImplementedError

    def clear_remains(self, importing: Callable[[], set[str]]) -> None:
        """Remove other remains of killed imports; ``importing()`` returns unfinished imports."""
        raise NotImplementedError


@dataclass(frozen=True)
class FolderTarget:
    """The new folder ``path``."""

    path: Path

    @contextmanager
    def building(self, progress: Progress) -> Iterator[Path]:  # noqa: ARG002 - it needs no upload
        """See ImportTarget; the folder gets its name once all files in it are complete.

        The id is reserved for this import, so an existing folder is from an earlier attempt of a
        process that died before it could report its end.
        """
        with room_for(self.path.name), staged(self.path.parent) as partial:
            yield partial / self.path.name
            shutil.rmtree(self.path, ignore_errors=True)
            (partial / self.path.name).rename(self.path)
            sync_folder(self.path.parent)


class FolderStore:
    """Recordings are folders in ``folder``; see SequenceStore."""

    at_once = 1

    def __init__(self, folder: Path) -> None:
        """Create or open the folder; raises BadInputError if it cannot be used."""
        self.folder = folder
        make_folder("workspace", folder)
        self.deleted = Trash(folder)
        self._root = os.fspath(folder)  # faster to join than paths
        self._missing: dict[str, tuple[tuple[Version | None, Version | None], str | None]] = {}

    def require_writable(self) -> None:
        """See SequenceStore."""
        if not writable(self.folder):
            raise ReadOnlyError(
                "the workspace's folder is read-only: recordings can be viewed and exported, not "
                "imported, changed or removed"
            )

    def require_answer(self) -> None:
        """See SequenceStore."""
        if not self.folder.is_dir():
            raise UnavailableError("expected the workspace's folder of recordings, it is missing")

    def ids(self) -> list[str]:
        """See SequenceStore."""
        with os.scandir(self.folder) as found:  # it knows folders without a stat of each
            return [each.name for each in found if each.name[0] != "." and each.is_dir()]

    def version(self, sequence: str) -> Version | None:
        """See SequenceStore."""
        return _stamp_of(f"{self._root}/{sequence}/{FILE}")

    def forget(self, sequence: str) -> None:
        """See SequenceStore; nothing is cached."""

    def has(self, sequence: str) -> bool:
        """See SequenceStore."""
        return (self.folder / sequence).is_dir()

    def is_free(self, sequence: str) -> bool:
        """See SequenceStore."""
        return not os.path.lexists(self.folder / sequence)

    def files(self, sequence: str) -> FolderFiles:
        """See SequenceStore."""
        return FolderFiles(self.folder / sequence)

    def missing(self, files: RecordingFiles, frames: int) -> str | None:
        """See SequenceStore."""
        root = os.fspath(files.path)
        stamps = _stamp_of(f"{root}/{FILE}"), _stamp_of(f"{root}/{FRAMES}")
        known = self._missing.get(root)
        if known is None or known[0] != stamps:
            known = self._missing[root] = stamps, _missing_in(files.path / FRAMES, frames)
        return known[1]

    def update(self, sequence: str, **fields: Any) -> None:
        """See SequenceStore."""
        update_manifest(self.folder / sequence, **fields)

    def target(self, sequence: str) -> FolderTarget:
        """See SequenceStore."""
        return FolderTarget(self.folder / sequence)

    def staging(self) -> AbstractContextManager[Path]:
        """See SequenceStore."""
        return staged(self.folder)

    def publish(self, made: Path, sequence: str) -> None:
        """See SequenceStore."""
        made.rename(self.folder / sequence)

    def clean(self) -> None:
        """See SequenceStore."""
        clean_temporary(self.folder)
        for path in self.folder.glob(".deleted-*"):  # of early versions
            shutil.rmtree(path, ignore_errors=True)

    def clear_remains(self, importing: Callable[[], set[str]]) -> None:
        """See SequenceStore; there are none elsewhere."""


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
