"""Mapped files and the page cache: whether looking at a mapping would wait for the disk.

Mapped bytes that are not in memory are read when they are looked at, by whoever looks, who waits.
An event loop must not: it asks first, and has a thread read what is missing.
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
"""Linux 5.14: read all pages; what cannot be read is an error and no signal."""
LARGEST = 64 * 2**20
"""Bytes that are asked about at once."""


def _system() -> ctypes.PyDLL | None:
    """The C library, called with Python's lock held: what is asked takes microseconds."""
    try:
        library = ctypes.PyDLL(None)
        library.mincore.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p]
    except (OSError, TypeError, AttributeError):
        return None  # Windows
    return library


_library = _system()


def can_tell(path: Path) -> bool:
    """Whether ``in_memory`` knows about a file: others than its owner and writers may not ask."""
    if _library is None or sys.platform == "win32":
        return False
    try:
        return path.stat().st_uid == os.geteuid() or os.access(path, os.W_OK)
    except OSError:
        return False


def in_memory(view: memoryview) -> bool:
    """Whether all pages of a mapped ``view`` are in the page cache; False: nobody knows."""
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
        # Through CDLL, which lets go of Python's lock.
        if not ctypes.CDLL(None, use_errno=True).madvise(
            ctypes.c_void_p(start), ctypes.c_size_t(length), MADV_POPULATE_READ
        ):
            return
        if ctypes.get_errno() == errno.EFAULT:  # looking at it would end the process
            raise DamagedError("expected mapped bytes, got a file that was cut short meanwhile")
    np.frombuffer(view, np.uint8)[::PAGE].sum()


def _pages(view: memoryview) -> tuple[int, int]:
    """Address of the first page of a view, and bytes from there to its end."""
    address = np.frombuffer(view, np.uint8).ctypes.data
    start = address - address % PAGE
    return start, address + len(view) - start
