"""The recordings of a workspace, independent of their store, opened once."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from pointbrush.errors import BadInputError, DamagedError, NotFoundError
from pointbrush.names import SCRATCH, is_plain
from pointbrush.sequences import Manifest, open_sequence
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences.storage.manifest import FILE
from pointbrush.sequences.storage.stored_files import RecordingFiles
from pointbrush.work.folder_store import FolderStore, Version

if TYPE_CHECKING:
    from pointbrush.work.bucket_store import BucketStore

SequenceStore: TypeAlias = "FolderStore | BucketStore"

LABELS_ALONE = "labels without their recording, whose files are missing"


@dataclass(frozen=True, slots=True)
class Found:
    """A recording: its manifest if readable, and a sentence about damage, or None."""

    id: str
    manifest: Manifest | None
    damaged: str | None


class Library:
    """Recordings in ``store``; thread-safe."""

    def __init__(self, store: SequenceStore) -> None:
        self.store, self.folder = store, store.folder
        self._lock = threading.Lock()
        self._open: dict[str, tuple[Version, Recording]] = {}
        self.hidden: frozenset[str] = frozenset()
        """Ids of deleted recordings that could not be moved away yet."""

    def require_writable(self) -> None:
        """Raise ReadOnlyError if recordings cannot be added, changed or removed."""
        self.store.require_writable()

    def manifests(self) -> list[Manifest]:
        """Return the manifests of readable recordings, by name."""
        found = [found.manifest for found in self.survey() if found.manifest is not None]
        return sorted(found, key=lambda manifest: manifest.name.lower())

    def ids(self) -> list[str]:
        """Return the ids of all recordings, including damaged ones."""
        return [name for name in self.store.ids() if name not in self.hidden]

    def listed_ids(self) -> list[str]:
        """Return the ids of recordings for lists."""
        return [name for name in self.ids() if name != SCRATCH]

    def survey(self) -> list[Found]:
        """Return all recordings, including damaged ones."""
        names = self.ids()
        if self.store.at_once == 1:  # faster than threads
            return [self.look(name) for name in names]
        with ThreadPoolExecutor(self.store.at_once, "pointbrush-survey") as pool:
            return list(pool.map(self.look, names))

    def look(self, sequence: str) -> Found:
        """Return a recording and check that the files of its frames exist."""
        try:
            recording = self.recording(sequence)
        except (NotFoundError, DamagedError) as error:
            return Found(sequence, None, str(error))
        missing = self.store.missing(recording.files, len(recording))
        return Found(sequence, recording.manifest, missing)

    def recording(self, sequence: str) -> Recording:
        """Return a stored recording; raises NotFoundError, DamagedError, UnavailableError."""
        version = self.store.version(sequence) if self._may_be(sequence) else None
        with self._lock:
            if version is None:
                self._open.pop(sequence, None)
                known = None
            else:
                known = self._open.get(sequence)
        if version is None:
            if self.has(sequence):
                raise DamagedError(f"sequence: {sequence!r} is damaged, it has no {FILE}")
            raise NotFoundError(f"sequence: expected a known id, got {sequence!r}")
        if known is not None and known[0] == version:
            return known[1]
        # This or another server may have changed or replaced it.
        opened = _opened(self.store.files(sequence), sequence)
        with self._lock:
            known = self._open.get(sequence)
            if known is not None and known[0] == version:
                return known[1]  # opened by another thread
            self._open[sequence] = version, opened
        return opened

    def _may_be(self, sequence: str) -> bool:
        return is_plain(sequence) and sequence not in self.hidden

    def has(self, sequence: str) -> bool:
        """Return whether there is a recording with this id, even a damaged one."""
        return self._may_be(sequence) and self.store.has(sequence)

    def update(self, sequence: str, **fields: Any) -> Manifest:
        """Change fields of a recording's manifest; see ``changed_manifest``."""
        self.recording(sequence)
        self.require_writable()
        with self._lock:
            self.store.update(sequence, **fields)
            self._open.pop(sequence, None)
        return self.recording(sequence).manifest

    def clean(self) -> None:
        """Remove remains of killed imports on this machine."""
        self.store.clean()

    def is_free(self, sequence: str) -> bool:
        """Return whether this name is free."""
        return self.store.is_free(sequence)


def _opened(files: RecordingFiles, sequence: str) -> Recording:
    try:
        recording = open_sequence(files)
    except BadInputError as error:
        raise DamagedError(f"sequence: {sequence!r} is damaged, {error}") from error
    except (OSError, KeyError, TypeError) as error:
        raise DamagedError(
            f"sequence: {sequence!r} is damaged, its {FILE} cannot be read: {error}"
        ) from error
    if recording.manifest.id != sequence:
        raise DamagedError(
            f"sequence: {sequence!r} is damaged, its {FILE} is of {recording.manifest.id!r}"
        )
    return recording
