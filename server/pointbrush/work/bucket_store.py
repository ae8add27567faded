"""Recordings of a workspace in object storage; see ``sequences/storage/bucket.py``.

Another server's change of a name, rate or floor is visible within ``FRESH_SECONDS``.  While the
store does not answer, known recordings and cached frames are still served.
"""

from __future__ import annotations

import fcntl
import logging
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pointbrush.errors import PointbrushError, ReadOnlyError, UnavailableError
from pointbrush.labels import Known
from pointbrush.sequences import Manifest, clean_temporary
from pointbrush.sequences.storage.bucket import Bucket
from pointbrush.sequences.storage.bucket_files import BucketFiles
from pointbrush.sequences.storage.files import staged
from pointbrush.sequences.storage.manifest import (
    FILE,
    changed_manifest,
    encode_manifest,
    parse_manifest,
)
from pointbrush.sequences.storage.stored_files import RecordingFiles
from pointbrush.system.permissions import make_private
from pointbrush.work.folder_store import Progress, make_folder

log = logging.getLogger(__name__)

FRESH_SECONDS = 5.0
STAGING = "staging"
DELETED = ".deleted"
LOCK = ".lock"


@dataclass(frozen=True)
class BucketTarget:
    """A recording ``name`` that is built on this machine and then uploaded."""

    bucket: Bucket
    name: str

    @contextmanager
    def building(self, progress: Progress) -> Iterator[Path]:
        with _staging(self.bucket) as made:
            yield made
            self.bucket.publish(made, self.name, progress)


class BucketStore:
    """Recordings are objects in ``bucket``; see FolderStore."""

    at_once = 16

    def __init__(self, bucket: Bucket) -> None:
        """Raises UnavailableError when the bucket does not answer, BadInputError."""
        self._bucket, self.folder = bucket, bucket.cache.folder
        self._bucket.require_answer()
        make_folder("sequence_cache", self.folder)
        make_private(self.folder)
        self.deleted = _Deleted(self)
        self._versions: dict[str, tuple[float, str]] = {}
        self._lock = threading.Lock()

    def require_writable(self) -> None:
        """See FolderStore; missing permission is noticed at the first write."""

    def require_answer(self) -> None:
        self._bucket.require_answer()

    def ids(self) -> list[str]:
        names = [name for name in self._bucket.folders() if name[0] != "."]
        with ThreadPoolExecutor(self.at_once) as pool:
            versions = list(pool.map(self.version, names))
        return [name for name, version in zip(names, versions, strict=True) if version is not None]

    def version(self, sequence: str) -> str | None:
        now = time.monotonic()
        with self._lock:
            checked_at, known = self._versions.get(sequence, (float("-inf"), None))
            if known is not None:
                if now - checked_at < FRESH_SECONDS:
                    return known
                self._versions[sequence] = now, known  # other threads do not wait for this answer
        try:
            found = self._bucket.version(f"{sequence}/{FILE}")
        except UnavailableError as error:
            if known is None:
                raise
            log.warning("%s is served as it was: %s", sequence, error.whole)
            return known
        with self._lock:
            if found is None:
                self._versions.pop(sequence, None)
            else:
                self._versions[sequence] = time.monotonic(), found
        return found

    def forget(self, sequence: str) -> None:
        with self._lock:
            self._versions.pop(sequence, None)

    def has(self, sequence: str) -> bool:
        """See FolderStore; a recording has a manifest."""
        return self.version(sequence) is not None

    def is_free(self, sequence: str) -> bool:
        return not self._bucket.exists(sequence)

    def files(self, sequence: str) -> BucketFiles:
        return BucketFiles(self._bucket, sequence)

    def missing(self, files: RecordingFiles, frames: int) -> None:
        """See FolderStore; not checked, as it would list all objects of a recording each time."""

    def update(self, sequence: str, **fields: Any) -> None:
        manifest = changed_manifest(self.files(sequence).manifest(), **fields)
        self._bucket.write(f"{sequence}/{FILE}", encode_manifest(manifest))
        self.forget(sequence)

    def target(self, sequence: str) -> BucketTarget:
        return BucketTarget(self._bucket, sequence)

    def staging(self) -> AbstractContextManager[Path]:
        return _staging(self._bucket)

    def publish(self, made: Path, sequence: str) -> None:
        self._bucket.publish(made, sequence)
        self.forget(sequence)

    def clean(self) -> None:
        clean_temporary(self.folder / STAGING)

    def clear_remains(self, importing: Callable[[], set[str]]) -> None:
        # In this order: later imports are not in the list, and finished ones have a manifest.
        there = {name for name in self._bucket.folders() if name[0] != "."} - importing()
        alone = {name for name in there if self._is_alone(name)}
        for name in sorted(alone - self.deleted.names()):
            if self._is_alone(name):  # not restored meanwhile
                log.warning("removing what an import of %s that was stopped has left", name)
                try:
                    self._bucket.remove([name])
                except ReadOnlyError as error:  # another server has to
                    log.warning("it stays: %s", error.whole)

    def _is_alone(self, sequence: str) -> bool:
        """Return whether files have no manifest."""
        return self._bucket.version(f"{sequence}/{FILE}") is None


class _Deleted:
    """Deleted recordings of a bucket: their manifests are moved aside, their files stay in place.

    The time to delete or restore does not depend on a recording's size, and its id is reserved
    until it is purged.
    """

    def __init__(self, store: BucketStore) -> None:
        self._store, self._bucket = store, store._bucket

    @contextmanager
    def alone(self) -> Iterator[None]:
        with (self._store.folder / LOCK).open("a") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            yield

    def _place(self, known: Known) -> str:
        return f"{DELETED}/{known.identity}-{known.number}/{known.id}/{FILE}"

    def names(self) -> set[str]:
        """Return the names of recordings with manifests here."""
        return {place.split("/")[1] for place in self._bucket.sizes(DELETED)}

    def is_empty(self) -> bool:
        return not self._bucket.exists(DELETED)

    def is_unmoved(self, known: Known) -> bool:
        manifest = self._read(f"{known.id}/{FILE}", known.id)
        return manifest is not None and manifest.identity == known.identity

    def is_in_trash(self, known: Known) -> bool:
        return not self._store.has(known.id) and self._bucket.exists(self._place(known))

    def manifest(self, known: Known) -> Manifest | None:
        return self._read(self._place(known), known.id)

    def _read(self, place: str, name: str) -> Manifest | None:
        data = self._bucket.read(place)
        try:
            return None if data is None else parse_manifest(data, name)
        except (PointbrushError, KeyError, TypeError):
            return None

    def ids_for(self, known: Known) -> Iterator[str]:
        return iter([known.id])

    def has_room(self, known: Known, sequence: str) -> bool:
        return sequence == known.id and self._bucket.version(f"{sequence}/{FILE}") is None

    def move_to_trash(self, known: Known) -> None:
        self._move(f"{known.id}/{FILE}", self._place(known), known.id)

    def move_back(self, known: Known) -> None:
        self._move(self._place(known), f"{known.id}/{FILE}", known.id)

    def _move(self, source: str, target: str, name: str) -> None:
        data = self._bucket.read(source)
        if data is not None:  # None: another server has moved it
            self._bucket.write(target, data)
            self._bucket.remove([source])
        self._store.forget(name)

    def purge(self, known: Known) -> None:
        place = self._place(known)
        if self._bucket.exists(place) and not self._store.has(known.id):
            self._bucket.remove([known.id])
        self._bucket.remove([place])


def _staging(bucket: Bucket) -> AbstractContextManager[Path]:
    """Return the path of a new folder on the disk of the cache, as a context."""
    return staged(bucket.cache.folder / STAGING)
