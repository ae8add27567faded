"""Files of one recording in a bucket, read through the cache of whole files; see ``bucket.py``."""

from __future__ import annotations

import re
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property
from pathlib import Path

from pointbrush.errors import DamagedError, NotFoundError, PointbrushError
from pointbrush.sequences.octree.arrays import file_digest
from pointbrush.sequences.storage.bucket import Bucket
from pointbrush.sequences.storage.checksums import CHECKSUMS, SENSOR, parse_checksums
from pointbrush.sequences.storage.file_cache import Hold, held
from pointbrush.sequences.storage.frame_files import FRAMES
from pointbrush.sequences.storage.manifest import FILE, Manifest, parse_manifest
from pointbrush.sequences.storage.read_ahead import ReadAhead
from pointbrush.sequences.storage.recording_files import KeptFiles

OPEN_FRAMES = 64
"""Most open frames of a recording; each holds 3 file descriptors."""
AT_ONCE = 8
"""Files of one frame that are fetched at once."""
_OF_FRAME = re.compile(r"(\w+)/(\d{6,})[./].+")


class BucketFiles:
    """Files of the recording ``name`` in a bucket; see FolderFiles."""

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
        data = self._bucket.read(f"{self._name}/{FILE}")
        if data is None:
            raise NotFoundError(f"expected a sequence in {self._name}, got no {FILE}")
        self._known = parse_manifest(data, self._name)
        return self._known

    @cached_property
    def path(self) -> Path:
        # An import's files never change: files of another import of this name are in its folder.
        path = self._bucket.folder / (self._known or self.manifest()).identity
        path.mkdir(parents=True, exist_ok=True)
        return path

    @cached_property
    def _ahead(self) -> ReadAhead:
        manifest = self._known or self.manifest()
        frames = 0 if manifest.large else manifest.frames
        return ReadAhead(frames, sum(self._sizes.values()), self._fetch_ahead)

    def checksums(self) -> dict[str, str] | None:
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
        """Names of a frame's files by folder and number, including missing files."""
        found = defaultdict(list)
        for name in self._sizes.keys() | self._checksums.keys():
            if match := _OF_FRAME.fullmatch(name):
                found[match[1], int(match[2])].append(name)
        return dict(found)

    def hold(self, index: int, part: str) -> Hold:
        try:
            held = self._hold_frame(index, part)
        except DamagedError:
            # Objects repaired after they were listed have other lengths.
            for name in ("_of_frame", "_sizes", "_checksums"):
                self.__dict__.pop(name, None)
            try:
                held = self._hold_frame(index, part)
            except DamagedError as error:
                raise DamagedError(f"frame {index} is damaged: {error}") from error
        if part == FRAMES:
            self._ahead.looked_at(index)
        return held

    def _hold_frame(self, index: int, part: str) -> Hold:
        return self._hold(self._of_frame.get((part, index), []))

    def _fetch_ahead(self, index: int) -> None:
        with self._hold_frame(index, FRAMES):
            pass

    def _hold(self, names: list[str]) -> Hold:
        if unlisted := [name for name in names if name not in self._sizes]:
            raise self._missing(unlisted[0])
        found = {name: held(self.path / name, self._sizes[name]) for name in names}
        missing = [name for name, descriptor in found.items() if descriptor is None]
        descriptors = [descriptor for descriptor in found.values() if descriptor is not None]
        if not missing:
            return Hold(descriptors)
        with ThreadPoolExecutor(min(AT_ONCE, len(missing)), "pointbrush-fetch") as pool:
            fetched = [pool.submit(self._fetched, name) for name in missing]
        problems = [each.exception() for each in fetched]
        descriptors += [each.result() for each in fetched if each.exception() is None]
        if problem := next(filter(None, problems), None):
            Hold(descriptors).__exit__()
            raise problem
        return Hold(descriptors)

    def _fetched(self, name: str) -> int:
        """Return a descriptor that holds a file; fetch the file if it is not in the cache."""
        checksum = None if name == CHECKSUMS else self._checksums.get(name)

        def fetch(target: Path) -> None:
            try:
                self._bucket.fetch(f"{self._name}/{name}", target)
            except FileNotFoundError:
                raise self._missing(name) from None
            if checksum is not None and file_digest(target) != checksum:
                raise DamagedError(f"the bytes of {name} are not those that were imported")

        return self._bucket.cache.hold(self.path / name, self._sizes[name], fetch)

    def _missing(self, name: str) -> PointbrushError:
        self._gone = self._bucket.version(f"{self._name}/{FILE}") is None
        kind = NotFoundError if self._gone else DamagedError
        return kind(f"expected the file {name}, it is missing")

    def is_gone(self) -> bool:
        return self._gone

    def names(self) -> set[str]:
        return self._sizes.keys() - {CHECKSUMS, FILE, SENSOR}

    def digest(self, name: str) -> str:
        return self._bucket.digest(f"{self._name}/{name}")

    def write(self, name: str, data: bytes) -> None:
        self._bucket.write(f"{self._name}/{name}", data)

    def copy_to(self, target: Path, earlier: Path | None = None) -> None:
        kept = KeptFiles(self.checksums(), earlier)
        for name, size in self._sizes.items():
            place = target / name
            place.parent.mkdir(parents=True, exist_ok=True)
            if not kept.link(name, size, place):
                self._bucket.fetch(f"{self._name}/{name}", place)
