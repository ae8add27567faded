"""A copy, in the temporary folder, of a SQLite database without write permission.

SQLite needs files beside a database with a write-ahead log, also for reading.  Opening it as
``immutable`` needs no files, but gives wrong results if another machine writes to the folder.
Therefore one consistent copy is made, without disturbing a writer.
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
"""Attempts to copy; a write during the copy requires another attempt."""
_PREFIX = "pointbrush-readonly-"
_NAME = re.compile(rf"{_PREFIX}(\d+)-.*")


class PrivateCopy:
    """The copy of ``source``, at ``path``; an empty database if the source does not exist."""

    def __init__(self, source: Path) -> None:
        """Copy the database; raises UnavailableError if it cannot be read or the disk is full."""
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
            # Another process has, or had, it open: SQLite itself can read beside a writer.
            with contextlib.suppress(sqlite3.OperationalError):
                _back_up(f"file:{_quoted(source)}?mode=ro", target)
                return
        if not log and not _beside(source, "-journal").exists():
            _back_up(f"file:{_quoted(source)}?mode=ro&immutable=1", target)
        else:  # files of a crashed process: opening the copy applies its log
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
