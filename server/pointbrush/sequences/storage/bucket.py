"""Recordings in object storage: objects under a URL, read through a cache of whole files.

A recording's objects are named as its files in a folder are, so that copying a folder of
recordings to a bucket, or back, is all it takes to move them.  The manifest comes last and goes
first: without it there is no recording.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cached_property
from hashlib import blake2b, sha256
from pathlib import Path
from typing import Any

from pointbrush.errors import (
    BadInputError,
    PointbrushError,
    ReadOnlyError,
    UnavailableError,
)
from pointbrush.sequences.storage.checksums import SENSOR
from pointbrush.sequences.storage.file_cache import FileCache
from pointbrush.sequences.storage.manifest import FILE, parse_manifest

EXTRAS = {"s3": "s3", "s3a": "s3", "gs": "gs", "gcs": "gs"}
"""Extra of pointbrush that a scheme of URLs needs."""
BATCH = 32
"""Files that are sent at once."""
REFUSED = "sequences: expected a bucket that allows this with these credentials, it refused"
PIECE = 1 << 22
Progress = Callable[[float, str], None]


class Bucket:
    """Objects under ``url``, and the cache of this machine; picklable, thread-safe.

    Every method raises UnavailableError with the reason if the store does not answer.
    """

    def __init__(self, url: str, cache: FileCache) -> None:
        self.url, self.cache = url.rstrip("/"), cache
        key = blake2b(self.url.encode(), digest_size=8).hexdigest()
        self.folder = cache.folder / key
        """Folder of the cache that has this bucket's files."""

    def __reduce__(self) -> tuple[type[Bucket], tuple[str, FileCache]]:
        return Bucket, (self.url, self.cache)

    @cached_property
    def _opened(self) -> tuple[Any, str]:
        scheme, mark, _ = self.url.partition("://")
        if not mark:
            raise BadInputError(
                f"sequences: expected a URL such as s3://bucket/folder, got {self.url!r}"
            )
        try:
            import fsspec

            opened: tuple[Any, str] = fsspec.url_to_fs(self.url, use_listings_cache=False)
        except ImportError as error:
            extra = EXTRAS.get(scheme)
            wanted = f"pip install 'pointbrush[{extra}]'" if extra else f"fsspec for {scheme}"
            raise UnavailableError(
                f"sequences: expected what reads {scheme}://, which is not installed: {wanted}",
                private=str(error),
            ) from None
        except ValueError as error:
            raise BadInputError(
                f"sequences: expected a URL that fsspec knows, got {self.url}: {error}"
            ) from None
        return opened

    @contextmanager
    def _asking(self, *, writing: bool = False) -> Iterator[tuple[Any, str]]:
        """Yield file system and root; convert the store's errors except FileNotFoundError."""
        opened = self._opened
        try:
            yield opened
        except (PointbrushError, FileNotFoundError):
            raise
        except PermissionError as error:
            kind = ReadOnlyError if writing else UnavailableError
            raise kind(REFUSED, private=str(error)) from error
        except Exception as error:  # the errors of the stores have no common base class
            raise _unavailable(error) from error

    def require_answer(self) -> None:
        """Raise UnavailableError unless the objects can be listed."""
        self.folders()

    def folders(self) -> list[str]:
        """Return the names of the folders directly under the URL."""
        with self._asking() as (fs, root):
            try:
                found = fs.ls(root, detail=True)
            except FileNotFoundError as error:
                if not self._has_bucket(fs, root):
                    raise UnavailableError(
                        "sequences: expected a bucket that exists", private=self.url
                    ) from error
                return []
        names = (each["name"].rstrip("/") for each in found if each["type"] == "directory")
        return [name.rpartition("/")[2] for name in names]

    def _has_bucket(self, fs: Any, root: str) -> bool:
        """Return whether the bucket exists; stores without buckets create their folder."""
        scheme = self.url.partition("://")[0]
        return scheme not in EXTRAS or bool(fs.exists(root.partition("/")[0]))

    def version(self, name: str) -> str | None:
        """Return a version that changes whenever the object does, or None where there is none."""
        with self._asking() as (fs, root), suppress(FileNotFoundError):
            return str(fs.ukey(f"{root}/{name}"))
        return None

    def exists(self, name: str) -> bool:
        """Return whether there is an object, or any under a folder, of this name."""
        with self._asking() as (fs, root):
            return bool(fs.exists(f"{root}/{name}"))

    def read(self, name: str) -> bytes | None:
        """Return an object's bytes, or None where there is none."""
        with self._asking() as (fs, root), suppress(FileNotFoundError):
            return bytes(fs.cat_file(f"{root}/{name}"))
        return None

    def write(self, name: str, data: bytes) -> None:
        """Put an object there, in one step."""
        with self._asking(writing=True) as (fs, root):
            place = f"{root}/{name}"
            fs.makedirs(place.rpartition("/")[0], exist_ok=True)
            fs.pipe_file(place, data)

    def remove(self, names: Iterable[str]) -> None:
        """Remove objects and folders with their contents; missing ones count as removed."""
        with self._asking(writing=True) as (fs, root):
            for name in names:
                with suppress(FileNotFoundError):
                    fs.rm(f"{root}/{name}", recursive=True)

    def sizes(self, folder: str) -> dict[str, int]:
        """Return the bytes of all objects under a folder, by their names in it."""
        with self._asking() as (fs, root):
            place = f"{root}/{folder}/"
            found = fs.find(place, detail=True)
            return {name.removeprefix(place): each["size"] for name, each in found.items()}

    def fetch(self, name: str, target: Path) -> None:
        """Copy an object to a file; raises FileNotFoundError where there is none."""
        with self._asking() as (fs, root):
            fs.get_file(f"{root}/{name}", str(target))

    def digest(self, name: str) -> str:
        """Return an object's checksum, read piece by piece; raises FileNotFoundError."""
        found = sha256()
        with (
            self._asking() as (fs, root),
            fs.open(f"{root}/{name}", "rb", block_size=PIECE) as file,
        ):
            while piece := file.read(PIECE):
                found.update(piece)
        return found.hexdigest()

    def publish(self, made: Path, name: str, progress: Progress | None = None) -> None:
        """Send the recording in the folder ``made``, the manifest last, and keep it in the cache.

        If sending fails, the objects are removed.  ``progress`` as for ``import_frames``.
        """
        manifest = (made / FILE).read_bytes()
        kept = {made / FILE, made / SENSOR}
        files = [file for file in made.rglob("*") if file.is_file() and file not in kept]
        try:
            for first in range(0, len(files), BATCH):
                self._send(files[first : first + BATCH], made, name)
                if progress is not None:
                    sent = min(first + BATCH, len(files))
                    progress(1.0, f"sent {sent} of {len(files)} files")
            self.write(f"{name}/{FILE}", manifest)
        except BaseException:
            with suppress(UnavailableError):
                self.remove([name])
            raise
        (made / FILE).unlink()
        self.cache.adopt(made, self.folder / parse_manifest(manifest, name).identity)

    def _send(self, files: list[Path], made: Path, name: str) -> None:
        with self._asking(writing=True) as (fs, root):
            places = [f"{root}/{name}/{file.relative_to(made)}" for file in files]
            for folder in {place.rpartition("/")[0] for place in places}:
                fs.makedirs(folder, exist_ok=True)
            fs.put(list(map(str, files)), places)


def _unavailable(error: Exception) -> UnavailableError:
    kind = type(error).__name__
    if "Credentials" in kind:
        problem = "expected credentials for the bucket in the environment, got none that serve"
    else:
        problem = "expected an answer from the bucket, got none"
    return UnavailableError(f"sequences: {problem}", private=f"{kind}: {error}")
