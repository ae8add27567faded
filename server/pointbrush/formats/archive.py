"""Zip and tar archives of frames, unpacked into a temporary folder within limits."""

from __future__ import annotations

import lzma
import shutil
import tarfile
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path, PurePosixPath
from typing import IO

from pointbrush.errors import BadInputError, TooLargeError, UnavailableError
from pointbrush.formats.options import Limits

ENDINGS = (".zip", ".tar", ".tar.gz", ".tgz", ".tar.bz2", ".tbz2", ".tar.xz", ".txz")
# Small archives may pack well; above this size unpacked, the ratio counts.
RATIO_FROM = 1 << 28
DAMAGED = (zipfile.BadZipFile, tarfile.TarError, zlib.error, lzma.LZMAError, EOFError, OSError)


def is_archive(path: Path) -> bool:
    """Whether the name is that of an archive."""
    return path.name.lower().endswith(ENDINGS)


def unpack(path: Path, limits: Limits) -> Path:
    """Unpack into a new temporary folder, which the caller removes.

    Links and devices are passed over.  Raises BadInputError for a damaged or encrypted archive
    or a name that leads outside, TooLargeError beyond the limits, UnavailableError when the disk
    is too small; nothing stays behind then.
    """
    target = Path(tempfile.mkdtemp(prefix="pointbrush-"))
    try:
        _unpack_into(path, target, limits)
    except (NotImplementedError, RuntimeError, UnicodeError, *DAMAGED) as error:
        shutil.rmtree(target, ignore_errors=True)
        if isinstance(error, OSError) and error.errno == 28:
            raise UnavailableError(f"{path.name}: the disk is full, nothing was kept") from None
        raise BadInputError(f"{path.name}: expected a whole archive, {error}") from None
    except BaseException:
        shutil.rmtree(target, ignore_errors=True)
        raise
    return target


@contextmanager
def unpacked(place: Path, limits: Limits) -> Iterator[Path]:
    """Unpack an archive, or the only file of a folder that is one, while it is used.

    Yields a folder, or ``place`` itself where it is neither.  Raises as ``unpack``.
    """
    inner = list(place.iterdir()) if place.is_dir() else [place]
    if len(inner) != 1 or not inner[0].is_file() or not is_archive(inner[0]):
        yield place
        return
    folder = unpack(inner[0], limits)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _unpack_into(path: Path, target: Path, limits: Limits) -> None:
    packed = path.stat().st_size
    free = shutil.disk_usage(target).free
    total = 0
    entries = _zip_entries if path.name.lower().endswith(".zip") else _tar_entries
    for number, (name, size, opened) in enumerate(entries(path)):
        if number >= limits.max_files:
            raise TooLargeError(f"{path.name}: expected at most {limits.max_files} files, got more")
        total += size
        if total > limits.max_unpacked_bytes:
            raise TooLargeError(
                f"{path.name}: expected at most {limits.max_unpacked_bytes} bytes unpacked, got "
                f"{total} or more"
            )
        if total > RATIO_FROM and total > packed * limits.max_archive_ratio:
            raise TooLargeError(
                f"{path.name}: expected to unpack to at most {limits.max_archive_ratio} times its "
                f"{packed} bytes, got {total} or more"
            )
        if total > free:
            raise UnavailableError(f"{path.name}: needs {total} bytes of disk, {free} are free")
        _write(path.name, name, size, opened, target)


def _write(
    archive: str, name: str, size: int, opened: Callable[[], IO[bytes]], target: Path
) -> None:
    parts = PurePosixPath(name.replace("\\", "/")).parts
    if not parts or ".." in parts or parts[0] == "/" or ":" in parts[0] or "\0" in name:
        raise BadInputError(f"{archive}: expected names inside the archive, got {name[:80]!r}")
    destination = target.joinpath(*parts)
    destination.parent.mkdir(parents=True, exist_ok=True)
    with opened() as source, destination.open("wb") as file:
        left = size
        # The size was counted against the limits: what an entry holds beyond it is not written.
        while left > 0 and (block := source.read(min(left, 1 << 20))):
            file.write(block)
            left -= len(block)
    if left:
        raise BadInputError(f"{archive}: expected {size} bytes of {name[:80]!r}, it is cut off")


Entry = tuple[str, int, Callable[[], IO[bytes]]]


def _zip_entries(path: Path) -> Iterator[Entry]:
    with zipfile.ZipFile(path) as archive:
        for entry in archive.infolist():
            if not entry.is_dir():
                yield entry.filename, entry.file_size, partial(archive.open, entry)


def _tar_entries(path: Path) -> Iterator[Entry]:
    with tarfile.open(path) as archive:
        for entry in archive:
            if entry.isfile():
                yield entry.name, entry.size, partial(_member, archive, entry)


def _member(archive: tarfile.TarFile, entry: tarfile.TarInfo) -> IO[bytes]:
    file = archive.extractfile(entry)
    if file is None:
        raise tarfile.ReadError(f"{entry.name} is not a file")
    return file
