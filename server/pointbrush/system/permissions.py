"""Permissions of files: write access, access of other users, and paths hidden from clients."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import stat
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

FORBIDDEN = (errno.EROFS, errno.EACCES, errno.EPERM)
"""Error numbers of read-only places; a full disk has other ones."""
UMASK = 0o077
"""Umask for files of a workspace and its backups, which only their owner may access."""
UPLOAD = re.compile(r"\buploads/[^/\s]+/")


def writable(folder: Path) -> bool:
    """Return whether files can be created in ``folder``, tested with an unnamed file."""
    try:
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError as error:
        return error.errno not in FORBIDDEN


def file_writable(path: Path) -> bool:
    """Return whether an existing file can be written, and files created beside it."""
    return os.access(path, os.W_OK) and writable(path.parent)


@contextlib.contextmanager
def private_files() -> Iterator[None]:
    """Create private files in this context, also in worker processes."""
    before = os.umask(UMASK)
    try:
        yield
    finally:
        os.umask(before)


def make_private(folder: Path) -> None:
    """Remove permissions of other users in ``folder``, which earlier versions granted.

    The folder itself is changed last: once it is private, its content is not checked again.  Files
    of another user or on a read-only disk are skipped.
    """
    if os.name != "posix" or not open_to_others(folder):
        return
    for path in sorted(folder.rglob("*"), reverse=True):
        _close(path)
    _close(folder)


def open_to_others(folder: Path) -> bool:
    """Return whether other users than the owner may read, write or enter ``folder``."""
    return os.name == "posix" and bool(folder.stat().st_mode & UMASK)


def _close(path: Path) -> None:
    with contextlib.suppress(OSError):
        mode = path.lstat().st_mode
        if mode & UMASK and not stat.S_ISLNK(mode):
            path.chmod(stat.S_IMODE(mode) & ~UMASK)


class ServerPaths:
    """Folders of this machine, which are removed from texts for clients."""

    def __init__(self, *folders: Path) -> None:
        """``folders``: the workspace and the sources of imports."""
        own = (Path.cwd(), Path.home(), Path(tempfile.gettempdir()), Path(__file__).parents[1])
        found = {folder.absolute() for folder in (*folders, *own, Path(sys.prefix))}
        found |= {folder.resolve() for folder in found}
        # Longest first, as folders may be nested.
        self._cut = sorted(
            (f"{folder}{os.sep}" for folder in found if folder.parent != folder),
            key=len,
            reverse=True,
        )

    def hide(self, text: str) -> str:
        """Return ``text`` with paths relative to these folders."""
        for folder in self._cut:
            text = text.replace(folder, "")
        return UPLOAD.sub("", text)
