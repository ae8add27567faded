"""Durable writes: files and folders that are whole after a crash, or absent."""

from __future__ import annotations

import errno
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from uuid import uuid4

from pointbrush.errors import ConflictError, PointbrushError, UnavailableError
from pointbrush.system.resources import FULL, process_alive

_TEMPORARY = re.compile(r"\.tmp-(\d+)-[0-9a-f]{32}")
_FULL = FULL | {errno.EROFS, errno.EIO}


def write_file(path: Path, data: bytes | memoryview) -> None:
    """Write and fsync a new file."""
    with path.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def write_all(descriptor: int, data: memoryview, offset: int) -> None:
    """Write all of ``data`` at ``offset``; the system may take several writes for it."""
    while len(data):
        written = os.pwrite(descriptor, data, offset)
        data, offset = data[written:], offset + written


def sync_folder(path: Path) -> None:
    """Make the names in a folder durable."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def replace_file(path: Path, data: bytes) -> None:
    """Put ``data`` in place of a file in one step: readers see the old bytes or the new."""
    temporary = path.with_name(f".{path.name}-{uuid4().hex}")
    try:
        write_file(temporary, data)
        temporary.replace(path)
        sync_folder(path.parent)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def staged(folder: Path) -> Iterator[Path]:
    """Give a path in ``folder`` that is not there yet; nothing stays of it after the block.

    ``clean_temporary`` removes it once this process is gone.
    """
    folder.mkdir(parents=True, exist_ok=True)
    temporary = folder / f".tmp-{os.getpid()}-{uuid4().hex}"
    try:
        yield temporary
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


@contextmanager
def room_for(name: str) -> Iterator[None]:
    """Raise UnavailableError when the disk has no room for ``name`` in the block."""
    try:
        yield
    except OSError as error:
        if error.errno in _FULL and not isinstance(error, PointbrushError):
            raise UnavailableError(
                f"expected room on disk for {name}, got: {error.strerror}"
            ) from error
        raise


@contextmanager
def new_folder(target: Path) -> Iterator[Path]:
    """A temporary folder that becomes ``target`` when the block ends, and vanishes if it raises.

    Raises ConflictError when ``target`` exists, UnavailableError when the disk is full.
    """
    if target.exists():
        raise ConflictError(f"expected a new sequence, but {target.name} exists")
    with room_for(target.name), staged(target.parent) as temporary:
        temporary.mkdir()
        yield temporary
        for folder in [*(p for p in temporary.rglob("*") if p.is_dir()), temporary]:
            sync_folder(folder)
        _rename(temporary, target)
        sync_folder(target.parent)


def _rename(temporary: Path, target: Path) -> None:
    try:
        temporary.rename(target)
    except OSError as error:
        if error.errno in (errno.ENOTEMPTY, errno.EEXIST, errno.ENOTDIR):
            raise ConflictError(f"expected a new sequence, but {target.name} exists") from error
        raise


def clean_temporary(folder: Path) -> list[Path]:
    """Remove the temporary folders of killed imports; keep the folders of running ones."""
    removed = []
    for path in folder.glob(".tmp-*"):
        match = _TEMPORARY.fullmatch(path.name)
        if match and not process_alive(int(match[1])):
            shutil.rmtree(path, ignore_errors=True)
            removed.append(path)
    return removed
