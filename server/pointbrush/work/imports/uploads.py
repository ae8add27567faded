"""Folders of running servers: each keeps a heartbeat, and what has none is nobody's any more."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
import threading
import uuid
from collections.abc import Callable, Iterable
from pathlib import Path

from pointbrush.errors import UnavailableError
from pointbrush.labels.guards import host
from pointbrush.system import process_alive

BEAT_SECONDS = 5.0
STALE_SECONDS = 60.0
"""A server whose heartbeat is older has ended without a word."""
ALIVE = "alive"
"""Heartbeat: its time is the last beat's, its text names the machine and the process."""


class Uploads:
    """One server's uploads and temporary files, on the workspace's own disk.

    ``uploads/OWNER.ID`` waits for its import; ``servers/OWNER`` holds the heartbeat and temporary
    files.  Several servers on a workspace leave each other's alone, and what a job needs that goes
    on at another one.
    """

    def __init__(self, workspace: Path, needed: Callable[[], Iterable[Path]] = tuple) -> None:
        """``needed`` gives the uploads of all jobs that have not ended; UnavailableError."""
        self._needed = needed
        self._servers, self._uploads = workspace / "servers", workspace / "uploads"
        self.owner = uuid.uuid4().hex
        self.temporary = self._servers / self.owner / "temporary"
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="pointbrush-beat", daemon=True)

    def open(self) -> None:
        """Begin the heartbeat, and remove what servers without one have left."""
        if self._beat():
            self.clean()
        self._thread.start()

    def close(self) -> None:
        """End the heartbeat; nothing of this server stays but what its jobs need."""
        self._stop.set()
        self._thread.join()
        self._remove(self._uploads.glob(f"{self.owner}.*"))
        shutil.rmtree(self._servers / self.owner, ignore_errors=True)

    def new(self) -> Path:
        """Return the folder for one upload, which is not there yet."""
        return self._uploads / f"{self.owner}.{uuid.uuid4().hex}"

    def clean(self) -> None:
        """Remove what belongs to no server that is alive."""
        # Times of the same disk are compared, whatever the clocks of its servers say.
        now = (self._servers / self.owner / ALIVE).stat().st_mtime
        alive = {self.owner}
        for server in self._servers.iterdir():
            if _is_alive(server, now):
                alive.add(server.name)
            elif server.name != self.owner:
                shutil.rmtree(server, ignore_errors=True)
        if self._uploads.is_dir():
            uploads = self._uploads.iterdir()
            self._remove(each for each in uploads if each.name.partition(".")[0] not in alive)

    def _remove(self, uploads: Iterable[Path]) -> None:
        """Remove uploads that no job needs; none while the database cannot say."""
        unowned = list(uploads)
        try:
            needed = {each.name for each in self._needed()} if unowned else set()
        except UnavailableError:
            return
        for upload in unowned:
            if upload.name not in needed:
                shutil.rmtree(upload, ignore_errors=True)

    def _beat(self) -> bool:
        """Write the heartbeat; False where the disk cannot be written."""
        try:
            self.temporary.mkdir(parents=True, exist_ok=True)
            heartbeat = self._servers / self.owner / ALIVE
            if heartbeat.exists():
                heartbeat.touch()
            else:
                heartbeat.write_text(f"{host()} {os.getpid()}", encoding="utf-8")
        except OSError:
            return False
        return True

    def _run(self) -> None:
        while not self._stop.wait(BEAT_SECONDS):
            # A full disk takes no new heartbeat for a while; the next one may fit.
            with contextlib.suppress(OSError):
                if self._beat():
                    self.clean()


def any_alive(workspace: Path) -> bool:
    """Return whether a server runs on a workspace, as far as heartbeats tell."""
    servers = workspace / "servers"
    if not servers.is_dir():
        return False
    with tempfile.TemporaryDirectory(dir=servers, prefix=".clock-") as clock:
        now = Path(clock).stat().st_mtime
        return any(
            _is_alive(server, now)
            for server in servers.iterdir()
            if not server.name.startswith(".")
        )


def _is_alive(server: Path, now: float) -> bool:
    """Tell by the heartbeat at ``now`` of the disk's clock, or by the process, if it is here."""
    if now - _last_beat(server) >= STALE_SECONDS:
        return False
    with contextlib.suppress(OSError, ValueError):
        place, _, process = (server / ALIVE).read_text(encoding="utf-8").rpartition(" ")
        if place == host():
            return process_alive(int(process))
    return True


def _last_beat(server: Path) -> float:
    try:
        return (server / ALIVE).stat().st_mtime
    except OSError:
        return _made(server)


def _made(server: Path) -> float:
    """A server that begins has its folder before its first heartbeat."""
    try:
        return server.stat().st_mtime
    except OSError:
        return float("-inf")
