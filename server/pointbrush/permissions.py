"""May this process write in a folder?"""

from __future__ import annotations

import errno
import os
import tempfile
from pathlib import Path

FORBIDDEN = (errno.EROFS, errno.EACCES, errno.EPERM)
"""Error numbers of places where nothing may be written; a full disk has others."""


def writable(folder: Path) -> bool:
    """Whether files can be made in ``folder``, found by making one that has no name."""
    try:
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError as error:
        return error.errno not in FORBIDDEN


def file_writable(path: Path) -> bool:
    """Whether a file that is there may be written, and others made beside it."""
    return os.access(path, os.W_OK) and writable(path.parent)
