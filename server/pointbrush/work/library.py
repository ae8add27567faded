"""The recordings of a workspace: a folder each, kept open, looked over for what is missing."""

from __future__ import annotations

import itertools
import os
import re
import shutil
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pointbrush.errors import BadInputError, DamagedError, NotFoundError, ReadOnlyError
from pointbrush.permissions import writable
from pointbrush.sequences import Manifest, clean_temporary, open_sequence, update_manifest
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences.store import FRAMES

MANIFEST = "manifest.json"
LABELS_ALONE = "labels without their recording, whose files are missing"
NAMED = 3
"""Missing files that a sentence names."""
Stamp = tuple[int, int]
"""A file's inode and time: every change of a manifest puts a new file in its place."""


@dataclass(frozen=True, slots=True)
class Found:
    """A recording's folder: its manifest as far as it can be read, and what is wrong, or None."""

    id: str
    manifest: Manifest | None
    damaged: str | None


class Library:
    """Recordings under ``folder``; thread-safe."""

    def __init__(self, folder: Path) -> None:
        """Make or open the folder; raises BadInputError when it cannot be used."""
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BadInputError(
                f"workspace: expected a folder to write in, got {folder}: {error.strerror}"
            ) from None
        self._lock = threading.Lock()
        self._open: dict[str, tuple[Stamp, Recording]] = {}
        self._missing: dict[str, tuple[tuple[Stamp | None, Stamp | None], str | None]] = {}
        self.hidden: frozenset[str] = frozenset()
        """Ids of deleted recordings whose folders could not be moved away yet."""

    def require_writable(self) -> None:
        """Raise ReadOnlyError when no recording can be made, changed or removed here."""
        if not writable(self.folder):
            raise ReadOnlyError(
                "the workspace's folder is read-only here: recordings can be looked at and "
                "exported, not imported, changed or removed"
            )

    def manifests(self) -> list[Manifest]:
        """Manifests of the recordings that can be opened, by name."""
        found = [found.manifest for found in self.survey() if found.manifest is not None]
        return sorted(found, key=lambda manifest: manifest.name.lower())

    def survey(self) -> list[Found]:
        """Every folder that is, or should be, a recording."""
        names = [path.name for path in self.folder.iterdir() if path.is_dir()]
        return [self.look(name) for name in names if name[0] != "." and name not in self.hidden]

    def look(self, sequence: str) -> Found:
        """One of them; also the files of its frames must be there."""
        try:
            recording = self.recording(sequence)
        except (NotFoundError, DamagedError) as error:
            return Found(sequence, None, str(error))
        return Found(sequence, recording.manifest, self._missing_files(recording))

    def recording(self, sequence: str) -> Recording:
        """The stored recording; raises NotFoundError, DamagedError."""
        path = self.folder / sequence
        with self._lock:
            stamp = stamp_of(path / MANIFEST) if self._may_be(sequence) else None
            if stamp is None:
                self._open.pop(sequence, None)
                if self.has(sequence):
                    raise DamagedError(f"sequence: {sequence!r} is damaged, it has no {MANIFEST}")
                raise NotFoundError(f"sequence: expected a known id, got {sequence!r}")
            known = self._open.get(sequence)
            if known is None or known[0] != stamp:
                # Also another server may have changed it, or put another in its place.
                known = self._open[sequence] = (stamp, _opened(path))
            return known[1]

    def _may_be(self, sequence: str) -> bool:
        plain = (self.folder / sequence).parent == self.folder and not sequence.startswith(".")
        return plain and sequence not in self.hidden

    def has(self, sequence: str) -> bool:
        """Whether there is a folder of this id, whole or not."""
        return self._may_be(sequence) and (self.folder / sequence).is_dir()

    def _missing_files(self, recording: Recording) -> str | None:
        """A sentence about files of frames that are not there."""
        frames, name = recording.path / FRAMES, recording.path.name
        stamps = stamp_of(recording.path / MANIFEST), stamp_of(frames)
        known = self._missing.get(name)
        if known is None or known[0] != stamps:
            known = self._missing[name] = stamps, _missing_in(frames, len(recording))
        return known[1]

    def update(self, sequence: str, **fields: Any) -> Manifest:
        """Change ``name``, ``fps`` or ``room`` (4x4 T_room_local) of a recording."""
        self.recording(sequence)
        self.require_writable()
        with self._lock:
            update_manifest(self.folder / sequence, **fields)
            self._open.pop(sequence, None)
        return self.recording(sequence).manifest

    def clean(self) -> None:
        """Remove what an import that was killed has left."""
        clean_temporary(self.folder)
        for path in self.folder.glob(".deleted-*"):  # of versions that kept no deleted recordings
            shutil.rmtree(path, ignore_errors=True)

    def is_free(self, sequence: str) -> bool:
        """Whether nothing in the folder has this name."""
        return not os.path.lexists(self.folder / sequence)


def ids_for(name: str) -> Iterator[str]:
    """Readable, URL-safe ids made from ``name``, the best first."""
    slug = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:48] or "recording"
    return itertools.chain([slug], (f"{slug}-{number}" for number in itertools.count(2)))


def stamp_of(path: Path) -> Stamp | None:
    """Return the version of a file; None when there is no such file."""
    try:
        found = path.stat()
    except (FileNotFoundError, NotADirectoryError, ValueError):
        return None
    return found.st_ino, found.st_mtime_ns


def _opened(path: Path) -> Recording:
    try:
        recording = open_sequence(path)
    except BadInputError as error:
        raise DamagedError(f"sequence: {path.name!r} is damaged, {error}") from error
    except (OSError, KeyError, TypeError) as error:
        raise DamagedError(
            f"sequence: {path.name!r} is damaged, its {MANIFEST} cannot be read: {error}"
        ) from error
    if recording.manifest.id != path.name:
        raise DamagedError(
            f"sequence: {path.name!r} is damaged, its {MANIFEST} is of {recording.manifest.id!r}"
        )
    return recording


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
