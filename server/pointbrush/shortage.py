"""Error numbers of a system that has no more: room on a disk, or files for a process."""

from __future__ import annotations

import errno
import sys

from pointbrush.errors import UnavailableError

FULL = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
FILES = frozenset({errno.EMFILE, errno.ENFILE})
RESERVED = 256
"""Files that connections leave to the database, to recordings and to worker processes."""


def shortage(error: OSError) -> UnavailableError | None:
    """Return the error in our words when it is about a shortage that may pass, or None."""
    if error.errno in FULL:
        return UnavailableError(
            f"the disk has no room for this, nothing was changed: {error.strerror}"
        )
    if error.errno in FILES:
        return UnavailableError(
            "the server has too many files open to do this now, nothing was changed; "
            "try again when fewer people are connected"
        )
    return None


def most_connections() -> int:
    """Return how many connections leave files for the work that they ask for."""
    if sys.platform == "win32":
        return sys.maxsize
    import resource

    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return sys.maxsize if soft == resource.RLIM_INFINITY else soft - min(RESERVED, soft // 2)
