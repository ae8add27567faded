"""Files that were sent to be previewed, until they are imported or an hour has gone by."""

from __future__ import annotations

import shutil
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from pointbrush.errors import NotFoundError

SECONDS = 3600.0
"""Time that files wait."""
MOST = 16
"""Uploads that wait on a server; the oldest make room."""


@dataclass(frozen=True)
class Upload:
    """Uploaded files: ``paths`` within ``folder``, called ``name`` where a folder was chosen.

    ``id`` is "" until they are kept, ``since`` when that was.
    """

    id: str
    owner: str
    folder: Path
    paths: tuple[Path, ...]
    name: str | None
    since: float = 0.0

    @property
    def kept(self) -> bool:
        """Whether they wait for another call."""
        return bool(self.id)


class KeptUploads:
    """The uploads that wait on this server; thread-safe."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._uploads: dict[str, Upload] = {}
        self._lock = threading.Lock()

    def keep(self, upload: Upload) -> Upload:
        """Keep files for later calls, and remove those that have waited too long."""
        now = self._clock()
        # A folder's name ends in 32 random hex digits.
        kept = replace(upload, id=upload.folder.name.rpartition(".")[2], since=now)
        with self._lock:
            self._uploads.pop(kept.id, None)
            self._uploads[kept.id] = kept
            waiting = [u for u in self._uploads.values() if u.id != kept.id]
            surplus = waiting[: max(0, len(self._uploads) - MOST)]
            old = {u.id: u for u in (*surplus, *(w for w in waiting if now - w.since > SECONDS))}
            for each in old:
                del self._uploads[each]
        for left in old.values():
            shutil.rmtree(left.folder, ignore_errors=True)
        return kept

    def find(self, upload: str, owner: str) -> Upload:
        """Return what ``owner`` sent; raises NotFoundError."""
        with self._lock:
            found = self._uploads.get(upload)
        if found is None or found.owner != owner or self._clock() - found.since > SECONDS:
            raise NotFoundError("upload: expected files that wait, there are none; send them again")
        return found

    def forget(self, upload: Upload) -> None:
        """Let files go to whoever imports or removes them."""
        with self._lock:
            self._uploads.pop(upload.id, None)
