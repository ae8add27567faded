"""Mapped files and the page cache: whether reading a mapping would wait for the disk.

The thread that accesses mapped bytes outside memory waits until they are read.  An event loop must
not wait: it checks first, and lets a thread read missing bytes.
"""

from __future__ import annotations

import ctypes
import errno
import mmap
import os
import sys
from pathlib import Path

import numpy as np

from pointbrush.errors import DamagedError

PAGE = mmap.PAGESIZE
MADV_POPULATE_READ = 22
"""Linux 5.14: read all pages; unreadable pages give an error instead of a signal."""
LARGEST = 64 * 2**20
"""Most bytes of one query."""


def _system() -> ctypes.PyDLL | None:
    """Return the C library, called with the GIL held, because the calls take microseconds."""
    try:
        library = ctypes.PyDLL(None)
        library.mincore.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p]
    except (OSError, TypeError, AttributeError):
        return None  # Windows
    return library


_library = _system()


def can_tell(path: Path) -> bool:
    """Return whether ``in_memory`` works for a file; the system allows it to owner and writers."""
    if _library is None or sys.platform == "win32":
        return False
    try:
        return path.stat().st_uid == os.geteuid() or os.access(path, os.W_OK)
    except OSError:
        return False


def in_memory(view: memoryview) -> bool:
    """Return whether all pages of a mapped ``view`` are in the page cache; False if unknown."""
    if _library is None or not len(view):
        return not len(view)
    if len(view) > LARGEST:
        return False
    start, length = _pages(view)
    present = np.empty(-(-length // PAGE), np.uint8)
    if _library.mincore(start, length, present.ctypes.data):
        return False
    return bool((present & 1).all())


def read_in(view: memoryview) -> None:
    """Read all pages of a mapped ``view`` into memory; waits for the disk.

    Raises DamagedError when its file has been cut short.
    """
    if not len(view):
        return
    if sys.platform == "linux":
        start, length = _pages(view)
        # CDLL releases the GIL during the call.
        if not ctypes.CDLL(None, use_errno=True).madvise(
            ctypes.c_void_p(start), ctypes.c_size_t(length), MADV_POPULATE_READ
        ):
            return
        if ctypes.get_errno() == errno.EFAULT:  # accessing it would end the process
            raise DamagedError("expected mapped bytes, got a file that was cut short meanwhile")
    np.frombuffer(view, np.uint8)[::PAGE].sum()


def _pages(view: memoryview) -> tuple[int, int]:
    """Address of the first page of a view, and bytes from there to its end."""
    address = np.frombuffer(view, np.uint8).ctypes.data
    start = address - address % PAGE
    return start, address + len(view) - start
