"""The system under this process: room on its disk, files it may open, memory, other processes."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from pointbrush.errors import UnavailableError
from pointbrush.system.permissions import FORBIDDEN

FULL = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
FILES = frozenset({errno.EMFILE, errno.ENFILE})
NO_THREAD = "can't start new thread"
NO_MAPPING = ("failed to map segment", os.strerror(errno.ENOMEM))
"""Words of the errors of Python and of the system's loader of libraries, which have no number."""
RESERVED = 256
"""Files that connections leave to the database, to recordings and to worker processes."""
LEAST_ROOM = 32 << 20
"""Bytes on the disk below which a server is not ready for new work."""


def shortage(error: BaseException) -> UnavailableError | None:
    """Return the error in our words when it is about a shortage that may pass, or None."""
    number, message = error.errno if isinstance(error, OSError) else None, str(error)
    if number in FULL and isinstance(error, OSError):
        return UnavailableError(
            f"the disk has no room for this, nothing was changed: {error.strerror}"
        )
    unread = isinstance(error, ImportError) or (isinstance(error, OSError) and number is None)
    if number in FILES or (unread and os.strerror(errno.EMFILE) in message):
        return UnavailableError(
            "the server has too many files open to do this now, nothing was changed; "
            "try again when fewer people are connected"
        )
    if (
        isinstance(error, MemoryError)
        or number == errno.ENOMEM
        or (unread and any(words in message for words in NO_MAPPING))
        or (isinstance(error, RuntimeError) and message == NO_THREAD)
    ):
        return UnavailableError(
            "the server has too little memory to do this now, nothing was changed; "
            "try again in a moment"
        )
    return None


@contextlib.contextmanager
def shortages_as_unavailable() -> Iterator[None]:
    """Raise UnavailableError in place of errors about a shortage that may pass."""
    try:
        yield
    except Exception as error:
        if (short := shortage(error)) is None:
            raise
        raise short from error


def most_connections() -> int:
    """Return the number of connections that leave files for the work that they ask for."""
    if sys.platform == "win32":
        return sys.maxsize
    import resource

    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return sys.maxsize if soft == resource.RLIM_INFINITY else soft - min(RESERVED, soft // 2)


def require_room(folder: Path) -> None:
    """Raise UnavailableError unless ``folder`` has room, or is read-only; names no path."""
    try:
        free = shutil.disk_usage(folder).free
        if free < LEAST_ROOM:
            raise UnavailableError(
                f"expected {LEAST_ROOM >> 20} MB of room on the workspace's disk, "
                f"got {free >> 20} MB"
            )
        with tempfile.TemporaryFile(dir=folder) as probe:
            probe.write(bytes(4096))
    except OSError as error:
        if error.errno in FORBIDDEN:
            return  # served for viewing: no new work will need room
        raise UnavailableError(
            f"expected a workspace that can be written: {error.strerror}"
        ) from None


def process_alive(process: int) -> bool:
    """Return whether a process of this machine, by its number, still runs."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:  # a process of another user
        return True
    return True
