"""A folder of dated backups: unchanged recordings are copied once, the oldest backups removed."""

from __future__ import annotations

import contextlib
import fcntl
import logging
import os
import re
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from pointbrush.errors import ConflictError, UnavailableError
from pointbrush.settings.settings import seconds_of
from pointbrush.work.backups.backup import is_backup

log = logging.getLogger(__name__)

Make = Callable[[Path, Path | None], None]
"""Makes a backup in a new folder, which may share files with an earlier backup."""
STAMP = "%Y-%m-%dT%H-%M-%S"
_DATED = re.compile(r"(\d{4}-\d\d-\d\dT\d\d-\d\d-\d\d)(?:\.(\d+))?")
UNFINISHED = ".unfinished"
"""Subfolder for backups that are being made or removed, including remains of killed processes."""
LOCK = ".lock"


@dataclass(frozen=True)
class BackupSeries:
    """The backups in ``folder`` with their times (UTC) as names; ``keep`` is their number.

    Folders with other names, or with a time in the future, are ignored.
    """

    folder: Path
    keep: int

    def made(self) -> list[Path]:
        """Return the backups, oldest first."""
        found = list(self.folder.iterdir()) if self.folder.is_dir() else []
        dated = [(order, path) for path in found if (order := _order(path.name)) is not None]
        return [path for _, path in sorted(dated) if is_backup(path)]

    def newest_at(self) -> float:
        """Return the time of the newest backup, seconds since 1970; 0 for none."""
        made = self.made()
        order = _order(made[-1].name) if made else None
        return 0.0 if order is None else order[0]

    def is_busy(self) -> bool:
        """Return whether a backup is being made."""
        try:
            with self._alone():
                return False
        except ConflictError:
            return True

    def add(self, make: Make, age: float | None = None) -> Path:
        """Make a backup and remove the oldest ones beyond ``keep``; return its folder.

        With an ``age``, seconds, wait for other processes that make one, and return the newest
        backup if it is younger.  Otherwise raises ConflictError while another process makes one.
        Raises UnavailableError if the folder cannot be written.
        """
        with self._alone(wait=age is not None):
            before = self.made()
            if age is not None and time.time() - self.newest_at() < age:
                return before[-1]
            unfinished = self.folder / UNFINISHED
            shutil.rmtree(unfinished, ignore_errors=True)
            target = self._free(datetime.now(UTC).strftime(STAMP))
            make(unfinished / target.name, before[-1] if before else None)
            (unfinished / target.name).rename(target)
            for old in self.made()[: -self.keep]:
                old.rename(unfinished / old.name)  # atomic: a partly removed backup is not listed
            shutil.rmtree(unfinished, ignore_errors=True)
            return target

    def _free(self, stamp: str) -> Path:
        number, target = 1, self.folder / stamp
        while target.exists():
            number, target = number + 1, self.folder / f"{stamp}.{number + 1}"
        return target

    @contextlib.contextmanager
    def _alone(self, *, wait: bool = False) -> Iterator[None]:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            file = (self.folder / LOCK).open("a")
        except OSError as error:
            raise UnavailableError(f"backup: {self.folder} cannot be written: {error}") from error
        with file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise ConflictError(
                    f"backup: expected no other that is being made in {self.folder}, there is one"
                ) from None
            yield


def _order(name: str) -> tuple[float, int] | None:
    """Parse the name of a backup: seconds since 1970, and its number in that second."""
    match = _DATED.fullmatch(name)
    if match is None:
        return None
    with contextlib.suppress(ValueError):
        at = datetime.strptime(match[1], STAMP).replace(tzinfo=UTC).timestamp()
        return (at, int(match[2] or 1)) if at <= time.time() else None
    return None


class BackupSchedule:
    """Adds to a series when its newest backup is old enough; servers can share a series.

    A separate process makes the backup, so that strokes are not delayed.
    """

    first_seconds = 20.0
    """Delay of the first check after the start, during which clients load the first pages."""
    look_seconds = 60.0
    """Longest interval between checks, as another server may make a backup."""
    retry_seconds = 600.0
    """Interval after a failure."""

    def __init__(self, series: BackupSeries, every: str, environment: Mapping[str, str]) -> None:
        """``every``: interval, for example 24h; ``environment``: added to that of the command.

        Raises BadInputError.
        """
        self.series, self.failures = series, 0
        self._every, self._seconds = every, seconds_of("backup_every", every)
        self._environment = {**os.environ, **environment}
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="backups", daemon=True)

    def begin(self) -> None:
        """Start the thread."""
        self._thread.start()

    def close(self) -> None:
        """Stop the thread; an unfinished backup is removed before the next one."""
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        wait = self.first_seconds
        while not self._ended.wait(wait):
            try:
                wait = self._due_in()
                if wait <= 0:
                    self._make()
            except (OSError, UnavailableError) as error:
                self._failed(str(error))
                wait = self.retry_seconds

    def _due_in(self) -> float:
        """Return the seconds until the next check; 0 or less: a backup is due."""
        left = self.series.newest_at() + self._seconds - time.time()
        if left <= 0 and self.series.is_busy():
            return self.look_seconds
        return min(left, self.look_seconds)

    def _make(self) -> None:
        begun = time.monotonic()
        process = subprocess.Popen(
            [sys.executable, "-m", "pointbrush.cli", "backup", "--if-older", self._every],
            env=self._environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        errors = None
        while errors is None:
            try:
                _, errors = process.communicate(timeout=0.5)
            except subprocess.TimeoutExpired:
                if self._ended.is_set():
                    process.kill()
        if self._ended.is_set() and process.returncode:
            return
        if process.returncode:
            reason = errors.strip().removeprefix("pointbrush: ")
            raise UnavailableError(reason or f"backup: ended with {process.returncode}")
        log.info("backup made in %.1f s", time.monotonic() - begun)

    def _failed(self, why: str) -> None:
        self.failures += 1
        log.warning("no backup was made: %s", why)
