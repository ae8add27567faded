"""Recordings in object storage: objects under a URL, read through a cache of whole files.

A recording's objects are named as its files in a folder are, so that copying a folder of
recordings to a bucket, or back, is all it takes to move them.  The manifest comes last and goes
first: without it there is no recording.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from functools import cached_property
from hashlib import blake2b, sha256
from pathlib import Path
from typing import Any

from pointbrush.errors import (
    BadInputError,
    DamagedError,
    NotFoundError,
    PointbrushError,
    ReadOnlyError,
    UnavailableError,
)
from pointbrush.sequences.checksums import CHECKSUMS, SENSOR, parse_checksums
from pointbrush.sequences.file_cache import FileCache, Hold, held
from pointbrush.sequences.frame_files import FRAMES
from pointbrush.sequences.manifest import FILE, Manifest, parse_manifest
from pointbrush.sequences.octree.arrays import file_digest
from pointbrush.sequences.read_ahead import ReadAhead

EXTRAS = {"s3": "s3", "s3a": "s3", "gs": "gs", "gcs": "gs"}
"""Extra of pointbrush that a scheme of URLs needs."""
OPEN_FRAMES = 64
"""Frames of a recording that may be open at once: each holds its files, 3 descriptors."""
BATCH = 32
"""Files that are sent at once."""
AT_ONCE = 8
"""Files of one frame that are fetched at once."""
REFUSED = "sequences: expected a bucket that allows this with these credentials, it refused"
PIECE = 1 << 22
_OF_FRAME = re.compile(r"(\w+)/(\d{6,})[./].+")
Progress = Callable[[float, str], None]


class Bucket:
    """Objects under ``url``, and the cache of this machine; picklable, thread-safe.

    Every method raises UnavailableError when the store cannot be asked, and says why.
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
        """Give file system and root; tell what goes wrong but FileNotFoundError in our words."""
        opened = self._opened
        try:
            yield opened
        except (PointbrushError, FileNotFoundError):
            raise
        except PermissionError as error:
            kind = ReadOnlyError if writing else UnavailableError
            raise kind(REFUSED, private=str(error)) from error
        except Exception as error:  # each store has its own, of no common class
            raise _unavailable(error) from error

    def require_answer(self) -> None:
        """Raise UnavailableError unless the objects can be listed."""
        self.folders()

    def folders(self) -> list[str]:
        """Return the names of what looks like folders directly under the URL."""
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
        """Return whether the bucket exists; stores that are not in buckets make theirs."""
        scheme = self.url.partition("://")[0]
        return scheme not in EXTRAS or bool(fs.exists(root.partition("/")[0]))

    def version(self, name: str) -> str | None:
        """Return what changes whenever the object does, or None where there is none."""
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
        """Remove objects, and all under those that are folders; missing ones count as removed."""
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

        Of one that is not sent nothing stays.  ``progress`` as for ``import_frames``.
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


class BucketFiles:
    """Files of the recording ``name`` in a bucket; see RecordingFiles."""

    open_frames = OPEN_FRAMES

    def __init__(self, bucket: Bucket, name: str) -> None:
        self._bucket, self._name = bucket, name
        self._known: Manifest | None = None
        self._gone = False

    def __reduce__(self) -> tuple[type[BucketFiles], tuple[Bucket, str]]:
        return BucketFiles, (self._bucket, self._name)

    def __str__(self) -> str:
        return f"{self._bucket.url}/{self._name}"

    def manifest(self) -> Manifest:
        """See RecordingFiles."""
        data = self._bucket.read(f"{self._name}/{FILE}")
        if data is None:
            raise NotFoundError(f"expected a sequence in {self._name}, got no manifest")
        self._known = parse_manifest(data, self._name)
        return self._known

    @cached_property
    def path(self) -> Path:
        """See RecordingFiles."""
        # An import's files never change: those of another import of this name lie elsewhere.
        path = self._bucket.folder / (self._known or self.manifest()).identity
        path.mkdir(parents=True, exist_ok=True)
        return path

    @cached_property
    def _ahead(self) -> ReadAhead:
        manifest = self._known or self.manifest()
        frames = 0 if manifest.large else manifest.frames
        return ReadAhead(frames, sum(self._sizes.values()), self._fetch_ahead)

    def checksums(self) -> dict[str, str] | None:
        """See RecordingFiles."""
        if CHECKSUMS not in self._sizes:
            return None
        with self._hold([CHECKSUMS]):
            return parse_checksums((self.path / CHECKSUMS).read_bytes())

    @cached_property
    def _checksums(self) -> dict[str, str]:
        return self.checksums() or {}

    @cached_property
    def _sizes(self) -> dict[str, int]:
        return self._bucket.sizes(self._name)

    @cached_property
    def _of_frame(self) -> dict[tuple[str, int], list[str]]:
        """Names of a frame's files by folder and number."""
        found = defaultdict(list)
        for name in self._sizes:
            if match := _OF_FRAME.fullmatch(name):
                found[match[1], int(match[2])].append(name)
        return dict(found)

    def hold(self, index: int, part: str) -> Hold:
        """See RecordingFiles."""
        held = self._hold(self._of_frame.get((part, index), []))
        if part == FRAMES:
            self._ahead.looked_at(index)
        return held

    def _fetch_ahead(self, index: int) -> None:
        with self._hold(self._of_frame.get((FRAMES, index), [])):
            pass

    def _hold(self, names: list[str]) -> Hold:
        found = {name: held(self.path / name, self._sizes[name]) for name in names}
        missing = [name for name, descriptor in found.items() if descriptor is None]
        here = [descriptor for descriptor in found.values() if descriptor is not None]
        if not missing:
            return Hold(here)
        with ThreadPoolExecutor(min(AT_ONCE, len(missing)), "pointbrush-fetch") as pool:
            fetched = [pool.submit(self._fetched, name) for name in missing]
        problems = [each.exception() for each in fetched]
        here += [each.result() for each in fetched if each.exception() is None]
        if problem := next(filter(None, problems), None):
            Hold(here).__exit__()
            raise problem
        return Hold(here)

    def _fetched(self, name: str) -> int:
        """Return a descriptor that holds a file, which comes from the bucket if it must."""
        checksum = None if name == CHECKSUMS else self._checksums.get(name)

        def fetch(target: Path) -> None:
            try:
                self._bucket.fetch(f"{self._name}/{name}", target)
            except FileNotFoundError:
                self._gone = self._bucket.version(f"{self._name}/{FILE}") is None
                kind = NotFoundError if self._gone else DamagedError
                raise kind(f"expected the file {name}, it is missing") from None
            if checksum is not None and file_digest(target) != checksum:
                raise DamagedError(f"the bytes of {name} are not those that were imported")

        return self._bucket.cache.hold(self.path / name, self._sizes[name], fetch)

    def is_gone(self) -> bool:
        """See RecordingFiles."""
        return self._gone

    def names(self) -> set[str]:
        """See RecordingFiles."""
        return self._sizes.keys() - {CHECKSUMS, FILE, SENSOR}

    def digest(self, name: str) -> str:
        """See RecordingFiles."""
        return self._bucket.digest(f"{self._name}/{name}")

    def write(self, name: str, data: bytes) -> None:
        """See RecordingFiles."""
        self._bucket.write(f"{self._name}/{name}", data)

    def copy_to(self, target: Path) -> None:
        """See RecordingFiles."""
        for name in self._sizes:
            place = target / name
            place.parent.mkdir(parents=True, exist_ok=True)
            self._bucket.fetch(f"{self._name}/{name}", place)


def _unavailable(error: Exception) -> UnavailableError:
    kind = type(error).__name__
    if "Credentials" in kind:
        problem = "expected credentials for the bucket in the environment, got none that serve"
    else:
        problem = "expected an answer from the bucket, got none"
    return UnavailableError(f"sequences: {problem}", private=f"{kind}: {error}")
