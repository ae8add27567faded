"""Archives of frames, unpacked into a temporary folder within limits, nested ones included.

Zip and tar archives, and bags that rosbag2 has compressed with Zstandard.
"""

from __future__ import annotations

import lzma
import shutil
import tarfile
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path, PurePosixPath
from typing import IO

import zstandard

from pointbrush.errors import BadInputError, TooLargeError, UnavailableError
from pointbrush.formats.options import Limits

PACKED = (".db3.zstd", ".mcap.zstd")
"""Endings of separately compressed files of a bag."""
ENDINGS = (".zip", ".tar", ".tar.gz", ".tgz", ".tar.bz2", ".tbz2", ".tar.xz", ".txz", *PACKED)
# Small archives may pack well; above this size unpacked, the ratio counts.
RATIO_FROM = 1 << 28
MOST_NESTED = 3
"""Greatest depth of nested archives."""
BLOCK = 1 << 20
"""Bytes of one write."""
DAMAGED = (
    *(zipfile.BadZipFile, tarfile.TarError, zlib.error, lzma.LZMAError, zstandard.ZstdError),
    *(NotImplementedError, RuntimeError, UnicodeError, EOFError, OSError),
)


def is_archive(path: Path) -> bool:
    """Return whether a file's name is that of an archive, or a folder has a compressed bag."""
    return bool(_packed_bags(path)) if path.is_dir() else path.name.lower().endswith(ENDINGS)


def _packed_bags(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.name.lower().endswith(PACKED))


def unpack(path: Path, limits: Limits) -> Path:
    """Unpack into a folder of the archive's name in a new folder, which the caller removes.

    Nested archives become folders of their names.  Links and devices are skipped.  Raises
    BadInputError for a damaged or encrypted archive or a name outside the folder, TooLargeError
    beyond the limits, UnavailableError when the disk is too small; after an error, no file stays.
    """
    temporary = Path(tempfile.mkdtemp(prefix="pointbrush-"))
    target = temporary / path.name
    try:
        target.mkdir()
        packed = sum(file.stat().st_size for file in _files(path))
        _Unpacking(path.name, limits, packed, shutil.disk_usage(target).free).fill(path, target)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        raise
    return target


@contextmanager
def unpacked(place: Path, limits: Limits) -> Iterator[Path]:
    """Unpack an archive, or a folder's only file if it is one, while the context is open.

    Yields a folder, or ``place`` itself if it is neither.  Raises as ``unpack``.
    """
    inner = list(place.iterdir()) if place.is_dir() else [place]
    if len(inner) != 1 or not inner[0].is_file() or not is_archive(inner[0]):
        yield place
        return
    folder = unpack(inner[0], limits)
    try:
        yield folder
    finally:
        shutil.rmtree(folder.parent, ignore_errors=True)


Entry = tuple[str, int | None, Callable[[], IO[bytes]]]
"""Name, size where it is known, and content of a file in an archive."""


@dataclass
class _Unpacking:
    """Counts of the files and bytes that are unpacked so far, nested archives included.

    ``name`` is the name of the outermost archive, which has ``packed`` bytes; ``free`` bytes were
    free on the disk.
    """

    name: str
    limits: Limits
    packed: int
    free: int
    files: int = 0
    total: int = 0

    def fill(self, archive: Path, target: Path, level: int = 0) -> None:
        """Unpack an archive into a folder, then the archives inside it."""
        where = f"{self.name}: expected a whole archive" + (f" {archive.name!r}" if level else "")
        try:
            written = [self._write(entry, target) for entry in _entries(archive)]
        except DAMAGED as error:
            if isinstance(error, OSError) and error.errno == 28:
                raise UnavailableError(f"{self.name}: the disk is full, nothing was kept") from None
            # The text of a system's error would contain the temporary folder.
            reason = error.strerror if isinstance(error, OSError) and error.strerror else error
            raise BadInputError(f"{where}, {reason}") from None
        for path in written:
            if is_archive(path) and not path.name.startswith("."):
                self._fill_from(path, level + 1)

    def _fill_from(self, inner: Path, level: int) -> None:
        if level > MOST_NESTED:
            raise TooLargeError(
                f"{self.name}: expected archives nested at most {MOST_NESTED} deep, got more "
                f"({inner.name})"
            )
        lower = inner.name.lower()
        folder = inner.parent
        if not lower.endswith(PACKED):
            ending = max((e for e in ENDINGS if lower.endswith(e)), key=len)
            folder = inner.with_name(inner.name[: -len(ending)] or inner.name + "~")
            if folder.exists():
                folder = inner.with_name(inner.name + "~")
        self.fill(inner, folder, level)
        inner.unlink()

    def _write(self, entry: Entry, target: Path) -> Path:
        name, size, opened = entry
        parts = PurePosixPath(name.replace("\\", "/")).parts
        if not parts or ".." in parts or parts[0] == "/" or ":" in parts[0] or "\0" in name:
            raise BadInputError(
                f"{self.name}: expected names inside the archive, got {name[:80]!r}"
            )
        self.files += 1
        if self.files > self.limits.max_files:
            raise TooLargeError(
                f"{self.name}: expected at most {self.limits.max_files} files, got more"
            )
        self._count(size or 0)
        destination = target.joinpath(*parts)
        destination.parent.mkdir(parents=True, exist_ok=True)
        left = size
        with opened() as source, destination.open("wb") as file:
            # The stated size was counted against the limits; bytes beyond it are not written.
            while block := source.read(BLOCK if left is None else min(left, BLOCK)):
                file.write(block)
                if left is None:
                    self._count(len(block))
                else:
                    left -= len(block)
        if left:
            raise BadInputError(
                f"{self.name}: expected {size} bytes of {name[:80]!r}, it is cut off"
            )
        return destination

    def _count(self, size: int) -> None:
        """Add bytes that are written next; raises TooLargeError, UnavailableError."""
        self.total += size
        total, limits = self.total, self.limits
        if total > limits.max_unpacked_bytes:
            raise TooLargeError(
                f"{self.name}: expected at most {limits.max_unpacked_bytes} bytes unpacked, got "
                f"{total} or more"
            )
        if total > RATIO_FROM and total > self.packed * limits.max_archive_ratio:
            raise TooLargeError(
                f"{self.name}: expected to unpack to at most {limits.max_archive_ratio} times its "
                f"{self.packed} bytes, got {total} or more"
            )
        if total > self.free:
            raise UnavailableError(
                f"{self.name}: needs {total} bytes of disk, {self.free} are free"
            )


def _files(path: Path) -> list[Path]:
    return _packed_bags(path) if path.is_dir() else [path]


def _entries(path: Path) -> Iterator[Entry]:
    for file in _files(path):
        lower = file.name.lower()
        if lower.endswith(PACKED):
            yield file.stem, None, partial(_zstd, file)
        else:
            yield from (_zip_entries if lower.endswith(".zip") else _tar_entries)(file)


def _zstd(path: Path) -> IO[bytes]:
    decompressor = zstandard.ZstdDecompressor(max_window_size=1 << 27)
    return decompressor.stream_reader(path.open("rb"), read_across_frames=True, closefd=True)


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
