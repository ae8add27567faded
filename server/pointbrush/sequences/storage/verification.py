"""Comparison of a recording's files with the checksums of their import, once in each process.

A file is compared again after a change (of inode, size or time).  Small files are compared before
they are used; large files, and files for lookups, by a thread in the background.
"""

from __future__ import annotations

import logging
import queue
import threading
import time
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from pointbrush.cache import Cache
from pointbrush.errors import DamagedError, UnavailableError
from pointbrush.system.resources import shortage

log = logging.getLogger(__name__)

PIECE_BYTES = 1 << 22
BACKGROUND_SHARE = 0.25
"""Share of one core and of the disk's time for comparison in the background."""
REMEMBERED = 65_536
"""Number of files with a remembered result; about 250 bytes each."""


class Stamp(NamedTuple):
    """Version of a file, by its times and size."""

    inode: int
    size: int
    time: int


def stamp_of(path: Path) -> Stamp:
    """Return the state of a file; raise DamagedError if it is missing or unreadable."""
    try:
        found = path.stat()
    except OSError as error:
        raise DamagedError(f"expected the file {path.name}, got: {error.strerror}") from error
    return Stamp(found.st_ino, found.st_size, found.st_mtime_ns)


_SOUND = Stamp(0, 0, 0), ""


class Verifier:
    """Remembers which files are as they were imported; thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._outcomes: Cache[Path, tuple[Stamp, str]] = Cache(REMEMBERED)
        self._later: queue.SimpleQueue[tuple[Path, str]] = queue.SimpleQueue()
        self._queued: set[Path] = set()
        self._thread: threading.Thread | None = None

    def refuse_damaged(self, path: Path) -> None:
        """Raise DamagedError if a file is known to be damaged; takes one table lookup."""
        stamp, problem = self._outcomes.known(path) or _SOUND
        if problem and stamp_of(path) == stamp:
            raise DamagedError(problem)
        if problem:
            self._outcomes.drop(path)

    def suspects(self, path: Path) -> bool:
        """Whether a file was found to be damaged in this or an earlier state."""
        return bool((self._outcomes.known(path) or _SOUND)[1])

    def knows(self, path: Path, stamp: Stamp) -> bool:
        """Whether the file in this state was compared; raises DamagedError when it is damaged."""
        outcome = self._outcomes.known(path)
        if outcome is None or outcome[0] != stamp:
            return False
        if outcome[1]:
            raise DamagedError(outcome[1])
        return True

    def require(self, path: Path, checksum: str | None) -> Stamp:
        """Compare a file unless it was; raise DamagedError.  Without checksum, it must exist.

        Two threads may compare the same file at once.
        """
        stamp = stamp_of(path)
        if checksum is not None and not self.knows(path, stamp):
            self._compare(path, checksum, stamp, share=1.0)
            self.refuse_damaged(path)
        return stamp

    def require_bytes(self, path: Path, stamp: Stamp, data: bytes, checksum: str | None) -> None:
        """Compare the bytes read of a file in the state ``stamp``; raise DamagedError."""
        if checksum is None or self.knows(path, stamp):
            return
        self._remember(path, stamp, sha256(data).hexdigest(), checksum)
        self.knows(path, stamp)

    def soon(self, path: Path, checksum: str | None) -> None:
        """Compare a file in the background, unless it was; ``refuse_damaged`` then knows."""
        if checksum is None or self.knows(path, stamp_of(path)):
            return
        with self._lock:
            if path in self._queued:
                return
            self._queued.add(path)
            if self._thread is None:
                self._thread = threading.Thread(
                    target=self._run, name="pointbrush-verifier", daemon=True
                )
                self._thread.start()
        self._later.put((path, checksum))

    def _run(self) -> None:
        while True:
            path, checksum = self._later.get()
            try:
                stamp = stamp_of(path)
                if not self.knows(path, stamp):
                    self._compare(path, checksum, stamp, BACKGROUND_SHARE)
            except DamagedError:
                pass  # the file was deleted, or another thread found the damage
            except UnavailableError as error:
                log.warning("%s is compared when it is used next: %s", path, error)
            except Exception:
                log.exception("%s could not be compared with its checksum", path)
            with self._lock:
                self._queued.discard(path)

    def _compare(self, path: Path, checksum: str, stamp: Stamp, share: float) -> None:
        """Read the whole file, taking ``share`` of the time, and store the result."""
        found = sha256()
        try:
            with path.open("rb") as file:
                started = time.monotonic()
                while piece := file.read(PIECE_BYTES):
                    found.update(piece)
                    if share < 1.0:
                        time.sleep((time.monotonic() - started) * (1 / share - 1))
                        started = time.monotonic()
        except OSError as error:
            if (short := shortage(error)) is not None:
                raise short from error
            raise DamagedError(f"expected the file {path.name}, got: {error.strerror}") from error
        self._remember(path, stamp, found.hexdigest(), checksum)

    def _remember(self, path: Path, stamp: Stamp, found: str, checksum: str) -> None:
        problem = ""
        if found != checksum:
            problem = f"the bytes of {path.name} are not those that were imported"
            log.info("%s: expected checksum %s, got %s", path, checksum, found)
        self._outcomes.put(path, (stamp, problem))


verifier = Verifier()
"""The verifier of this process."""
