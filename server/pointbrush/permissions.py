"""Permissions of files: may this process write there, may others read, and paths nobody is told."""

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
"""Error numbers of places where nothing may be written; a full disk has others."""
UMASK = 0o077
"""Files of a workspace and its backups are their owner's alone."""
UPLOAD = re.compile(r"\buploads/[^/\s]+/")


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


@contextlib.contextmanager
def private_files() -> Iterator[None]:
    """Have everything that is made meanwhile, by worker processes too, be its owner's alone."""
    before = os.umask(UMASK)
    try:
        yield
    finally:
        os.umask(before)


def make_private(folder: Path) -> None:
    """Take from others what they may do in ``folder``, as an earlier version left it.

    The folder itself comes last: once it is private, nothing in it needs a look again.  Does
    nothing to what belongs to another user, or lies on a disk that cannot be written.
    """
    if os.name != "posix" or not open_to_others(folder):
        return
    for path in sorted(folder.rglob("*"), reverse=True):
        _close(path)
    _close(folder)


def open_to_others(folder: Path) -> bool:
    """Return whether anybody but its owner may read, write or enter ``folder``."""
    return os.name == "posix" and bool(folder.stat().st_mode & UMASK)


def _close(path: Path) -> None:
    with contextlib.suppress(OSError):
        mode = path.lstat().st_mode
        if mode & UMASK and not stat.S_ISLNK(mode):
            path.chmod(stat.S_IMODE(mode) & ~UMASK)


class ServerPaths:
    """Folders of this machine, which are cut from what clients are told."""

    def __init__(self, *folders: Path) -> None:
        """``folders``: the workspace and where imports come from."""
        own = (Path.cwd(), Path.home(), Path(tempfile.gettempdir()), Path(__file__).parent)
        found = {folder.absolute() for folder in (*folders, *own, Path(sys.prefix))}
        found |= {folder.resolve() for folder in found}
        # The longest first: one may lie in another.
        self._cut = sorted(
            (f"{folder}{os.sep}" for folder in found if folder.parent != folder),
            key=len,
            reverse=True,
        )

    def hide(self, text: str) -> str:
        """Return ``text`` with files named by their place inside these folders."""
        for folder in self._cut:
            text = text.replace(folder, "")
        return UPLOAD.sub("", text)
