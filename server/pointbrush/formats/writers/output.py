"""Target of an export: a folder, a zip, a single file or a stream, written atomically."""

from __future__ import annotations

import shutil
import tempfile
import zipfile
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import BinaryIO, Protocol, cast

from pointbrush.errors import BadInputError, UnavailableError

LEVEL = 1
"""Level of deflate: higher ones save nothing on noise and take several times as long."""


class Output(Protocol):
    """Takes files by relative name."""

    def file(self, name: str) -> AbstractContextManager[BinaryIO]:
        """Open ``name`` for writing; parents are made."""


class _Folder:
    def __init__(self, root: Path) -> None:
        self.root = root

    @contextmanager
    def file(self, name: str) -> Iterator[BinaryIO]:
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("wb") as file:
            yield file


class _Zip:
    def __init__(self, archive: zipfile.ZipFile) -> None:
        self.archive = archive

    @contextmanager
    def file(self, name: str) -> Iterator[BinaryIO]:
        # Compressed already: deflating again costs time and gains nothing.
        packed = name.endswith((".npz", ".laz", ".png"))
        info = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
        info.compress_type = zipfile.ZIP_STORED if packed else zipfile.ZIP_DEFLATED
        info.external_attr = 0o644 << 16
        # An entry described by hand ignores the archive's level; there is no public name for it.
        info._compresslevel = LEVEL  # type: ignore[attr-defined]
        # Spooled first: writers like LAS seek, entries of an archive do not.
        with tempfile.SpooledTemporaryFile(1 << 25) as spool:
            yield cast(BinaryIO, spool)
            spool.seek(0)
            with self.archive.open(info, "w", force_zip64=True) as entry:
                shutil.copyfileobj(spool, entry, 1 << 20)


class _Single:
    """The only file of points, at ``path``; other files are beside it, named after it."""

    def __init__(self, path: Path, scratch: Path) -> None:
        self.path = path
        self.scratch = scratch
        self.names: list[str] = []

    @contextmanager
    def file(self, name: str) -> Iterator[BinaryIO]:
        if name.endswith(self.path.suffix.lower()):
            if self.path.name in self.names:
                raise BadInputError(
                    "out: expected a folder or a .zip for more than one frame, got "
                    f"{self.path.name}"
                )
            target = self.path.name
        else:
            target = f"{self.path.stem}.{name.replace('/', '.')}"
        self.names.append(target)
        with (self.scratch / target).open("wb") as file:
            yield file


def stream_output(stream: BinaryIO) -> AbstractContextManager[Output]:
    """Write files into a zip on ``stream``, which need not support seek."""

    @contextmanager
    def opened() -> Iterator[Output]:
        with zipfile.ZipFile(stream, "w") as archive:
            yield _Zip(archive)

    return opened()


@contextmanager
def folder_output(target: Path) -> Iterator[Output]:
    """A new folder ``target``; raises BadInputError when it exists and is not empty."""
    if target.exists() and (not target.is_dir() or any(target.iterdir())):
        raise BadInputError(f"out: expected a new or an empty folder, {target} is not")
    with _scratch(target) as scratch:
        yield _Folder(scratch)
        if target.exists():
            target.rmdir()
        scratch.chmod(0o755)
        scratch.rename(target)


@contextmanager
def single_output(target: Path) -> Iterator[Output]:
    """A .zip of everything, or the one file of points at ``target`` with the palette beside."""
    if target.is_dir():
        raise BadInputError(f"out: expected a file, {target} is a folder")
    with _scratch(target) as scratch:
        if target.suffix.lower() == ".zip":
            with zipfile.ZipFile(scratch / target.name, "w") as archive:
                yield _Zip(archive)
            names = [target.name]
        else:
            single = _Single(target, scratch)
            yield single
            names = single.names
        for name in names:
            (scratch / name).replace(target.parent / name)


@contextmanager
def _scratch(target: Path) -> Iterator[Path]:
    """A folder beside ``target``, on the same disk so that renaming is atomic."""
    try:
        target.absolute().parent.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=f".{target.name}.", dir=target.absolute().parent))
    except OSError as error:
        raise BadInputError(
            f"out: expected a place to write, got {target}: {error.strerror}"
        ) from None
    try:
        yield scratch
    except OSError as error:
        if error.errno == 28:
            raise UnavailableError(f"out: the disk is full, {target} was not written") from None
        raise
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
