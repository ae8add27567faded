"""The recordings of a workspace: a folder each, kept open, renamed before they are removed."""

from __future__ import annotations

import re
import shutil
import threading
from pathlib import Path
from typing import Any

from pointbrush.errors import BadInputError, NotFoundError, ReadOnlyError
from pointbrush.permissions import writable
from pointbrush.sequences import Manifest, clean_temporary, open_sequence, update_manifest
from pointbrush.sequences import Sequence as Recording

MANIFEST = "manifest.json"
Stamp = tuple[int, int]
"""A file's inode and time: every change of a manifest puts a new file in its place."""


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
        self._reserved: set[str] = set()

    def require_writable(self) -> None:
        """Raise ReadOnlyError when no recording can be made, changed or removed here."""
        if not writable(self.folder):
            raise ReadOnlyError(
                "the workspace's folder is read-only here: recordings can be looked at and "
                "exported, not imported, changed or removed"
            )

    def manifests(self) -> list[Manifest]:
        """What each recording is, by name."""
        found = [
            self.recording(path.name).manifest
            for path in self.folder.iterdir()
            if not path.name.startswith(".") and (path / MANIFEST).is_file()
        ]
        return sorted(found, key=lambda manifest: manifest.name.lower())

    def recording(self, sequence: str) -> Recording:
        """The stored recording; raises NotFoundError."""
        path = self.folder / sequence
        plain = path.parent == self.folder and not sequence.startswith(".")
        with self._lock:
            stamp = stamp_of(path / MANIFEST) if plain else None
            if stamp is None:
                self._open.pop(sequence, None)
                raise NotFoundError(f"sequence: expected a known id, got {sequence!r}")
            known = self._open.get(sequence)
            if known is None or known[0] != stamp:
                # Also another server may have changed it, or put another in its place.
                known = self._open[sequence] = (stamp, open_sequence(path))
            return known[1]

    def update(self, sequence: str, **fields: Any) -> Manifest:
        """Change ``name``, ``fps`` or ``room`` (4x4 T_room_local) of a recording."""
        self.recording(sequence)
        self.require_writable()
        with self._lock:
            update_manifest(self.folder / sequence, **fields)
            self._open.pop(sequence, None)
        return self.recording(sequence).manifest

    def remove(self, sequence: str) -> None:
        """Delete a recording's folder."""
        self.recording(sequence)
        self.require_writable()
        # Renamed first: a half-deleted folder must never look like a recording.
        doomed = self.folder / f".deleted-{sequence}"
        shutil.rmtree(doomed, ignore_errors=True)
        with self._lock:
            (self.folder / sequence).rename(doomed)
            self._open.pop(sequence, None)
        shutil.rmtree(doomed, ignore_errors=True)

    def clean(self) -> None:
        """Remove what an import or a deletion that was killed has left."""
        clean_temporary(self.folder)
        for path in self.folder.glob(".deleted-*"):
            shutil.rmtree(path, ignore_errors=True)

    def reserve(self, name: str) -> str:
        """A readable, URL-safe id made from ``name``; nobody else gets it until released.

        Raises ReadOnlyError where nothing can be imported.
        """
        self.require_writable()
        slug = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:48] or "recording"
        with self._lock:
            candidate, number = slug, 1
            while candidate in self._reserved or (self.folder / candidate).exists():
                number += 1
                candidate = f"{slug}-{number}"
            self._reserved.add(candidate)
        return candidate

    def release(self, sequence: str) -> None:
        """Give a reserved id back."""
        with self._lock:
            self._reserved.discard(sequence)


def stamp_of(path: Path) -> Stamp | None:
    """Which state of a file this is; None when there is no such file."""
    try:
        found = path.stat()
    except (FileNotFoundError, NotADirectoryError, ValueError):
        return None
    return found.st_ino, found.st_mtime_ns
