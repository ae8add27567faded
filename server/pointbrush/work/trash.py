"""Folders of deleted recordings, stored beside the others until they are purged or restored."""

from __future__ import annotations

import contextlib
import fcntl
import itertools
import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

from pointbrush.errors import PointbrushError
from pointbrush.labels import Known
from pointbrush.names import composed, is_plain
from pointbrush.sequences import Manifest, read_manifest, update_manifest
from pointbrush.sequences.storage.files import sync_folder

FOLDER = ".deleted"
LOCK = ".lock"
DOOMED = ".purged-"


class Trash:
    """Moves folders between a library's folder and ``.deleted`` in it.

    Folders are named by identity and number, so recordings with the same id do not collide.  Each
    step can be interrupted and repeated.
    """

    def __init__(self, library: Path) -> None:
        self._library, self._folder = library, library / FOLDER

    @contextlib.contextmanager
    def alone(self) -> Iterator[None]:
        """Exclude moves of folders by other processes."""
        self._folder.mkdir(exist_ok=True)
        with (self._folder / LOCK).open("a") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            yield

    def place(self, known: Known) -> Path:
        """Return the folder of a deleted recording; an invalid identity cannot escape it."""
        identity = known.identity if is_plain(known.identity) else "unknown"
        return self._folder / f"{identity}-{known.number}"

    def is_empty(self) -> bool:
        """Return whether it has no recordings."""
        return not any(path.is_dir() for path in self._folder.glob("*"))

    def _has(self, known: Known) -> bool:
        return self.place(known).is_dir()

    def is_unmoved(self, known: Known) -> bool:
        """Return whether a deleted recording is still among the others."""
        folder = self._library / known.id
        if not is_plain(known.id) or not folder.is_dir() or self._has(known):
            return False
        manifest = _manifest_or_none(folder)
        return manifest is None or manifest.identity == known.identity

    def is_in_trash(self, known: Known) -> bool:
        """Return whether a restored recording is still here and can be moved back."""
        return self._has(known) and self.has_room(known, known.id)

    def ids_for(self, known: Known) -> Iterator[str]:
        """Yield ids under which a recording can be restored, best first."""
        return itertools.chain([known.id], ids_for(known.id))

    def has_room(self, known: Known, sequence: str) -> bool:  # noqa: ARG002 - any id does
        """Return whether no files prevent its restoration under the id ``sequence``."""
        return is_plain(sequence) and not os.path.lexists(self._library / sequence)

    def manifest(self, known: Known) -> Manifest | None:
        """Return the manifest of a deleted recording, or None if it cannot be read."""
        return _manifest_or_none(self.place(known))

    def move_to_trash(self, known: Known) -> None:
        """Move a recording's folder here atomically."""
        self._move(self._library / known.id, self.place(known))

    def move_back(self, known: Known) -> None:
        """Move a recording's folder back; its manifest gets the current id."""
        manifest = self.manifest(known)
        if manifest is not None and manifest.id != known.id:
            update_manifest(self.place(known), id=known.id)
        self._move(self.place(known), self._library / known.id)

    def purge(self, known: Known) -> None:
        """Remove a folder permanently."""
        doomed = self._folder / f"{DOOMED}{known.number}"
        if self._has(known):
            # Renamed first, so that a partly removed folder does not look restorable.
            self.place(known).rename(doomed)
        shutil.rmtree(doomed, ignore_errors=True)

    def _move(self, source: Path, target: Path) -> None:
        source.rename(target)
        sync_folder(source.parent)
        sync_folder(target.parent)


def _manifest_or_none(folder: Path) -> Manifest | None:
    """Return a folder's manifest, or None if it cannot be read."""
    try:
        return read_manifest(folder)
    except (PointbrushError, OSError, KeyError, TypeError):
        return None


def ids_for(name: str) -> Iterator[str]:
    """Yield readable, URL-safe ids derived from ``name``, best first."""
    slug = re.sub(r"[^a-z0-9]+", "-", composed(name).lower()).strip("-")[:48] or "recording"
    return itertools.chain([slug], (f"{slug}-{number}" for number in itertools.count(2)))
