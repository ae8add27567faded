"""Folders of running servers with heartbeats; folders without one are removed."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
import threading
import uuid
from collections.abc import Callable, Iterable
from pathlib import Path

from pointbrush.database.guards import host
from pointbrush.errors import UnavailableError
from pointbrush.system.resources import process_alive

BEAT_SECONDS = 5.0
STALE_SECONDS = 60.0
"""Age of a heartbeat after which its server counts as ended."""
ALIVE = "alive"
"""Heartbeat file: its time is the last beat, its text the machine and the process."""


class Uploads:
    """One server's uploads and temporary files, on the workspace's own disk.

    ``uploads/OWNER.ID`` is an upload for an import; ``servers/OWNER`` has the heartbeat and
    temporary files.  Servers of a workspace do not remove files of other running servers, nor files
    of jobs that another server continues.
    """

    def __init__(self, workspace: Path, needed: Callable[[], Iterable[Path]] = tuple) -> None:
        """``needed`` returns the uploads of all unfinished jobs; raises UnavailableError."""
        self._needed = needed
        self._servers, self._uploads = workspace / "servers", workspace / "uploads"
        self.owner = uuid.uuid4().hex
        self.temporary = self._servers / self.owner / "temporary"
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="pointbrush-beat", daemon=True)

    def open(self) -> None:
        """Start the heartbeat, and remove files of servers without one."""
        if self._beat():
            self.clean()
        self._thread.start()

    def close(self) -> None:
        """End the heartbeat, and remove files of this server that its jobs do not need."""
        self._stop.set()
        self._thread.join()
        self._remove(self._uploads.glob(f"{self.owner}.*"))
        shutil.rmtree(self._servers / self.owner, ignore_errors=True)

    def new(self) -> Path:
        """Return the path of a new folder for one upload."""
        return self._uploads / f"{self.owner}.{uuid.uuid4().hex}"

    def clean(self) -> None:
        """Remove files that belong to no running server."""
        # Only times of the same disk are compared, independent of the servers' clocks.
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
        """Remove uploads that no job needs; none while the database is unavailable."""
        unowned = list(uploads)
        try:
            needed = {each.name for each in self._needed()} if unowned else set()
        except UnavailableError:
            return
        for upload in unowned:
            if upload.name not in needed:
                shutil.rmtree(upload, ignore_errors=True)

    def _beat(self) -> bool:
        """Write the heartbeat; return False if the disk cannot be written."""
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
            # A full disk prevents a heartbeat; the next one may succeed.
            with contextlib.suppress(OSError):
                if self._beat():
                    self.clean()


def any_alive(workspace: Path) -> bool:
    """Return whether a server runs on a workspace, according to heartbeats."""
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
    """Return whether a server has a recent heartbeat and, on this machine, a running process."""
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
    """Return the time of a server's folder, which exists before its first heartbeat."""
    try:
        return server.stat().st_mtime
    except OSError:
        return float("-inf")
