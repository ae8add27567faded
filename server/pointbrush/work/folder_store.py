"""Stores of a workspace's recordings, and the one that needs nothing else: a folder."""

from __future__ import annotations

import os
import shutil
import uuid
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from pointbrush.errors import BadInputError, ReadOnlyError, UnavailableError
from pointbrush.labels import Known
from pointbrush.permissions import writable
from pointbrush.sequences import Manifest, clean_temporary, update_manifest
from pointbrush.sequences.frame_files import FRAMES
from pointbrush.sequences.manifest import FILE
from pointbrush.sequences.recording_files import FolderFiles, RecordingFiles
from pointbrush.work.trash import Trash

Progress = Callable[[float, str], None]
Version = object
"""Another one after every change of a manifest; compared, and nothing else."""


class ImportTarget(Protocol):
    """Place of a recording that does not exist yet; picklable."""

    def building(self, progress: Progress) -> AbstractContextManager[Path]:
        """Give the path of a new folder, which is the recording once the block ends.

        Nothing stays of it when the block raises.
        """
        raise NotImplementedError


class DeletedPlace(Protocol):
    """Keeps deleted recordings; each step can be repeated, stopped anywhere."""

    def alone(self) -> AbstractContextManager[None]:
        """No other process of this machine moves recordings meanwhile."""
        raise NotImplementedError

    def is_empty(self) -> bool:
        """Whether nothing is kept here."""
        raise NotImplementedError

    def is_left(self, known: Known) -> bool:
        """Whether a deleted recording is still among the others."""
        raise NotImplementedError

    def is_away(self, known: Known) -> bool:
        """Whether a restored recording is still here, and could come back."""
        raise NotImplementedError

    def manifest(self, known: Known) -> Manifest | None:
        """The manifest of a deleted recording, or None when it cannot be read."""
        raise NotImplementedError

    def ids_for(self, known: Known) -> Iterator[str]:
        """Ids that a recording may come back under, the best first."""
        raise NotImplementedError

    def has_room(self, known: Known, sequence: str) -> bool:
        """Whether it may come back under the id ``sequence``, as far as files are concerned."""
        raise NotImplementedError

    def put_away(self, known: Known) -> None:
        """Take a recording from the others."""
        raise NotImplementedError

    def bring_back(self, known: Known) -> None:
        """Put a recording back among the others, under the id that it has now."""
        raise NotImplementedError

    def purge(self, known: Known) -> None:
        """Remove a deleted recording for good."""
        raise NotImplementedError


class SequenceStore(Protocol):
    """Recordings: each has an id, files and a manifest, without which it is none.

    ``folder``   folder of this machine that is written to meanwhile.
    ``deleted``  where deleted ones are.
    ``at_once``  recordings that are best looked at at once.
    Every method raises UnavailableError when the place cannot be reached.
    """

    folder: Path
    at_once: int

    @property
    def deleted(self) -> DeletedPlace:
        """See above."""
        raise NotImplementedError

    def require_writable(self) -> None:
        """Raise ReadOnlyError when no recording can be made, changed or removed here."""
        raise NotImplementedError

    def require_answer(self) -> None:
        """Raise UnavailableError unless the place can be reached."""
        raise NotImplementedError

    def ids(self) -> list[str]:
        """Ids of all that are, or should be, recordings."""
        raise NotImplementedError

    def version(self, sequence: str) -> Version | None:
        """Version of a manifest; None where there is none."""
        raise NotImplementedError

    def forget(self, sequence: str) -> None:
        """Look anew at a recording that somebody has changed."""
        raise NotImplementedError

    def has(self, sequence: str) -> bool:
        """Whether there is a recording of this id, whole or not."""
        raise NotImplementedError

    def is_free(self, sequence: str) -> bool:
        """Whether nothing at all has this name."""
        raise NotImplementedError

    def files(self, sequence: str) -> RecordingFiles:
        """The files of a recording."""
        raise NotImplementedError

    def missing(self, files: RecordingFiles, frames: int) -> str | None:
        """A sentence about files of frames that are not there, as far as it is known at once."""
        raise NotImplementedError

    def update(self, sequence: str, **fields: Any) -> None:
        """Change what may change of a manifest."""
        raise NotImplementedError

    def target(self, sequence: str) -> ImportTarget:
        """Place of a new recording of this id."""
        raise NotImplementedError

    def staging(self) -> AbstractContextManager[Path]:
        """Give the path of a temporary folder, not there yet, for ``publish``."""
        raise NotImplementedError

    def publish(self, made: Path, sequence: str) -> None:
        """Make the recording in the folder ``made`` one of these."""
        raise NotImplementedError

    def clean(self) -> None:
        """Remove what an import that was killed has left on this machine."""
        raise NotImplementedError

    def clear_remains(self, importing: Callable[[], set[str]]) -> None:
        """Remove what killed imports have left elsewhere; ``importing()`` are those under way."""
        raise NotImplementedError


@dataclass(frozen=True)
class FolderTarget:
    """The new folder ``path``."""

    path: Path

    @contextmanager
    def building(self, progress: Progress) -> Iterator[Path]:  # noqa: ARG002 - it is there at once
        """See ImportTarget; what imports into the folder makes it whole or not at all.

        The id is reserved for this work: a recording of that id is of an earlier try, whose process
        died before it could report that it was done.
        """
        shutil.rmtree(self.path, ignore_errors=True)
        yield self.path


class FolderStore:
    """Recordings are folders in ``folder``; see SequenceStore."""

    at_once = 1

    def __init__(self, folder: Path) -> None:
        """Make or open the folder; raises BadInputError when it cannot be used."""
        self.folder = folder
        make_folder("workspace", folder)
        self.deleted = Trash(folder)
        self._root = os.fspath(folder)  # joining names to it is quicker than making paths of both
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
        with os.scandir(self.folder) as found:  # it knows folders without a look at each
            return [each.name for each in found if each.name[0] != "." and each.is_dir()]

    def version(self, sequence: str) -> Version | None:
        """See SequenceStore."""
        return _stamp_of(f"{self._root}/{sequence}/{FILE}")

    def forget(self, sequence: str) -> None:
        """See SequenceStore; a folder is looked at each time."""

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

    @contextmanager
    def staging(self) -> Iterator[Path]:
        """See SequenceStore."""
        partial = temporary_in(self.folder)
        try:
            yield partial
        finally:
            shutil.rmtree(partial, ignore_errors=True)

    def publish(self, made: Path, sequence: str) -> None:
        """See SequenceStore."""
        made.rename(self.folder / sequence)

    def clean(self) -> None:
        """See SequenceStore."""
        clean_temporary(self.folder)
        for path in self.folder.glob(".deleted-*"):  # of versions that kept no deleted recordings
            shutil.rmtree(path, ignore_errors=True)

    def clear_remains(self, importing: Callable[[], set[str]]) -> None:
        """See SequenceStore; there are none elsewhere."""


def make_folder(name: str, folder: Path) -> None:
    """Make the folder of option ``name``, unless it is there; raises BadInputError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(
            f"{name}: expected a folder to write in, got {folder}: {error.strerror}"
        ) from None


def temporary_in(folder: Path) -> Path:
    """Return a new path in ``folder``, for ``clean_temporary`` once this process is gone."""
    return folder / f".tmp-{os.getpid()}-{uuid.uuid4().hex}"


def _stamp_of(path: str) -> Version | None:
    """Return a file's inode and time, as each change of a manifest puts a new file in its place."""
    with suppress(FileNotFoundError, NotADirectoryError, ValueError):
        found = os.stat(path)  # noqa: PTH116 - a path is made as slowly as the look takes
        return found.st_ino, found.st_mtime_ns
    return None


NAMED = 3
"""Missing files that a sentence names."""


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
    """The two parts of a frame; an octree's points are a folder."""
    stem = f"{frame:06d}"
    return stem if stem in there else f"{stem}.points", f"{stem}.wire"
