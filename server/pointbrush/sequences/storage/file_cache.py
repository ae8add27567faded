"""Whole files kept on this machine's disk, within a bound; several processes may share the folder.

A reader holds a file by a shared ``flock`` on it, and held files stay; of the other files, the
least recently used are removed first.  One process at a time fetches a file, under a temporary
name, so that it appears whole.  Files never change: a copy of the right length is valid.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import time
import uuid
import weakref
from collections.abc import Callable, Iterator
from hashlib import blake2b
from pathlib import Path
from typing import Self

from pointbrush.errors import DamagedError

PARTIAL = ".part-"
LOCKS = ".locks"
USED = ".used"
STRIPES = 256
"""Number of locks for fetching files; files with the same lock wait for each other."""
FULL_SHARE = 0.9
"""Share of the bound that stays in use after files were removed."""


class Hold:
    """Files that stay in place until the context ends or the object is deleted."""

    def __init__(self, descriptors: list[int]) -> None:
        self._close = weakref.finalize(self, _close_all, descriptors)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._close()


class FileCache:
    """Files under ``folder``, at most ``capacity`` bytes unless more are held; thread-safe."""

    def __init__(self, folder: Path, capacity: int) -> None:
        self.folder, self.capacity = folder, capacity

    def __reduce__(self) -> tuple[type[FileCache], tuple[Path, int]]:
        return FileCache, (self.folder, self.capacity)

    def hold(self, path: Path, nbytes: int, fetch: Callable[[Path], None]) -> int:
        """Return a descriptor that holds the file of ``nbytes`` at ``path``, which is under folder.

        ``fetch(partial)`` writes it to another path if it is missing or of another length.
        Raises DamagedError if the fetched file is of another length, and the errors of ``fetch``.
        """
        descriptor = held(path, nbytes)
        if descriptor is not None:
            return descriptor
        with self._alone(path):
            descriptor = held(path, nbytes)
            if descriptor is not None:
                return descriptor
            descriptor = _fetched(path, nbytes, fetch)
        self._note(nbytes)
        return descriptor

    def adopt(self, made: Path, target: Path) -> None:
        """Move a folder of files that were made here to ``target``, unless there is one."""
        target.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(OSError):
            made.rename(target)
            self._note(sum(file.stat().st_size for file in _files(target)))

    @contextlib.contextmanager
    def _alone(self, path: Path) -> Iterator[None]:
        """Keep all other threads and processes from fetching this file."""
        name = blake2b(str(path).encode(), digest_size=8).digest()
        number = int.from_bytes(name, "big") % STRIPES
        with _locked(self.folder / LOCKS / f"{number:03d}"):
            yield

    def _note(self, nbytes: int) -> None:
        """Count fetched bytes, and make room for them."""
        path = self.folder / USED
        with _locked(path):
            known = path.read_text()
            used = int(known) + nbytes if known.isdecimal() else self.capacity + 1
            if used > self.capacity:
                used = self._prune()
            path.write_text(str(used))

    def _prune(self) -> int:
        """Remove files until the rest is within the bound; return the bytes of the rest."""
        found = []
        for file in _files(self.folder):
            with contextlib.suppress(FileNotFoundError):
                state = file.stat()
                found.append((state.st_atime_ns, state.st_size, file))
        used = sum(size for _, size, _ in found)
        if used <= self.capacity:
            return used
        for _, size, file in sorted(found, key=lambda each: each[0]):
            if used <= FULL_SHARE * self.capacity:
                break
            if _removed(file):
                used -= size
        return used


def held(path: Path, nbytes: int) -> int | None:
    """Return a descriptor that holds a whole file, which is then the last one used, or None."""
    try:
        descriptor = os.open(path, os.O_RDONLY)
    except FileNotFoundError:
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH)
        state = os.fstat(descriptor)
        # The file may have been removed between the two calls.
        if state.st_nlink == 0 or state.st_size != nbytes:
            os.close(descriptor)
            return None
        os.utime(descriptor, ns=(time.time_ns(), state.st_mtime_ns))
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def _fetched(path: Path, nbytes: int, fetch: Callable[[Path], None]) -> int:
    path.parent.mkdir(parents=True, exist_ok=True)
    partial, descriptor = _partial(path)
    try:
        fetch(partial)
        if (got := os.fstat(descriptor).st_size) != nbytes:
            raise DamagedError(f"expected {nbytes:,} bytes of {path.name}, got {got:,}")
        fcntl.flock(descriptor, fcntl.LOCK_SH)
        partial.replace(path)
    except BaseException:
        partial.unlink(missing_ok=True)
        os.close(descriptor)
        raise
    return descriptor


def _partial(path: Path) -> tuple[Path, int]:
    """Make an empty file beside ``path``, and a descriptor that keeps `_removed` from it."""
    while True:
        partial = path.with_name(f"{PARTIAL}{uuid.uuid4().hex}")
        descriptor = os.open(partial, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        # Another process that made room may have removed it before it was locked.
        if os.fstat(descriptor).st_nlink:
            return partial, descriptor
        os.close(descriptor)


def _removed(path: Path) -> bool:
    """Remove a file unless it is held; return whether it is removed."""
    try:
        descriptor = os.open(path, os.O_RDONLY)
    except FileNotFoundError:
        return True
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        path.unlink(missing_ok=True)
    except BlockingIOError:
        return False
    finally:
        os.close(descriptor)
    return True


def _files(folder: Path) -> Iterator[Path]:
    """Yield all files of a folder except locks and the count, including leftovers of a fetch."""
    for place, folders, names in os.walk(folder):
        if LOCKS in folders:
            folders.remove(LOCKS)
        yield from (Path(place, name) for name in names if name != USED)


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[None]:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _close_all(descriptors: list[int]) -> None:
    for descriptor in descriptors:
        os.close(descriptor)
