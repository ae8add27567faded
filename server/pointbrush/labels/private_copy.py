"""A SQLite database that this process may not write: a copy in the temporary folder.

SQLite needs files beside a database that has a write-ahead log, also for reading.  To open it as
``immutable`` needs none, but gives wrong answers once somebody writes after all: the folder may be
mounted for writing elsewhere.  So one consistent copy is made, and whoever writes is left alone.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import shutil
import sqlite3
import tempfile
from pathlib import Path

from pointbrush.errors import UnavailableError

TRIES = 5
"""Somebody may write while it is copied; then it is copied again."""
_PREFIX = "pointbrush-readonly-"
_NAME = re.compile(rf"{_PREFIX}(\d+)-.*")


class PrivateCopy:
    """The copy of ``source``, at ``path``; an empty database when there is no source."""

    def __init__(self, source: Path) -> None:
        """Raises UnavailableError when it cannot be read, or there is no room for a copy."""
        _clean()
        self._folder = Path(tempfile.mkdtemp(prefix=f"{_PREFIX}{os.getpid()}-"))
        self.path = self._folder / source.name
        try:
            if source.exists():
                _copy(source, self.path)
        except (OSError, sqlite3.Error) as error:
            self.close()
            room = isinstance(error, OSError) and error.errno == errno.ENOSPC
            what = "no room in the temporary folder" if room else str(error)
            raise UnavailableError(
                f"the labels may not be written, and expected to be copied: {what}"
            ) from error
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Remove the copy."""
        shutil.rmtree(self._folder, ignore_errors=True)


def _copy(source: Path, target: Path) -> None:
    for _ in range(TRIES):
        before = _state(source)
        log, index = before[1] is not None, before[2] is not None
        if log and index:
            # Somebody has it open, or had: SQLite itself knows how to read beside a writer.
            with contextlib.suppress(sqlite3.OperationalError):
                _back_up(f"file:{_quoted(source)}?mode=ro", target)
                return
        if not log and not _beside(source, "-journal").exists():
            _back_up(f"file:{_quoted(source)}?mode=ro&immutable=1", target)
        else:  # what a crash has left: the copy takes the log in when it is opened
            for suffix in ("", "-wal", "-journal"):
                with contextlib.suppress(FileNotFoundError):
                    shutil.copyfile(_beside(source, suffix), _beside(target, suffix))
        if _state(source) == before:
            return
    raise UnavailableError("the labels are being written all the time, and cannot be copied now")


def _back_up(address: str, target: Path) -> None:
    target.unlink(missing_ok=True)
    with (
        contextlib.closing(sqlite3.connect(address, uri=True)) as live,
        contextlib.closing(sqlite3.connect(target)) as copy,
    ):
        live.backup(copy)


def _state(source: Path) -> tuple[tuple[int, int, int] | None, ...]:
    """Return the versions of the database, its log and the log's index; None: not there."""
    found: list[tuple[int, int, int] | None] = []
    for suffix in ("", "-wal", "-shm"):
        try:
            status = _beside(source, suffix).stat()
            found.append((status.st_ino, status.st_size, status.st_mtime_ns))
        except FileNotFoundError:
            found.append(None)
    return tuple(found)


def _beside(path: Path, suffix: str) -> Path:
    return path.with_name(path.name + suffix)


def _quoted(path: Path) -> str:
    return path.absolute().as_uri().removeprefix("file://")


def _clean() -> None:
    """Remove copies of processes that were killed."""
    for folder in Path(tempfile.gettempdir()).glob(f"{_PREFIX}*"):
        match = _NAME.fullmatch(folder.name)
        if match and not Path(f"/proc/{match[1]}").exists() and Path("/proc/self").exists():
            shutil.rmtree(folder, ignore_errors=True)
