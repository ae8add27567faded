"""Whether the workspace's disk can take more."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from pointbrush.errors import UnavailableError
from pointbrush.permissions import FORBIDDEN

LEAST_ROOM = 32 << 20
"""Bytes on the disk below which a server is not ready for new work."""


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
