"""The files of one stored frame: copied and mapped parts, and the detection of damage.

Reading mapped memory beyond the end of a truncated file ends the process (SIGBUS).  Therefore the
arrays of a frame that fits in memory are copied and compared with their checksum; only bytes for
the wire are mapped, and their file's length is checked each time.  The columns of an octree are too
large for that: they are mapped, and their lengths are checked before each use.
"""

from __future__ import annotations

import mmap
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from weakref import ref

import numpy as np
from numpy.typing import NDArray

from pointbrush.cache import Cache
from pointbrush.errors import DamagedError
from pointbrush.sequences.columns import from_local
from pointbrush.sequences.octree.arrays import (
    Arrays,
    Layout,
    map_file,
    map_npy,
    parse_arrays,
    read_array,
    read_file,
    read_layout,
    read_meta,
    read_range,
    read_rows,
    release,
)
from pointbrush.sequences.octree.coordinates import Coordinates
from pointbrush.sequences.octree.packed import PACKED
from pointbrush.sequences.storage.manifest import Manifest
from pointbrush.sequences.storage.verification import stamp_of, verifier

FRAMES = "frames"
"""Folder of a recording that has these files."""

COPIED_BYTES = 256 << 20
"""Memory of this process for arrays of frames; the least recently used are dropped first."""
_copied: Cache[tuple[str, str], Arrays] = Cache(COPIED_BYTES)

TABLES = ("chunks", "block_first", "block_lo", "block_hi", "block_of_chunk")
"""Arrays of an octree that are copied: a 256th of the points or fewer."""


class FrameFiles:
    """Common part of both kinds: the wire file, and errors about damage.

    ``names`` are the arrays there are, ``chunks`` (C,) the chunk table, ``count`` the points;
    ``depth_ends`` (C,) where its chunks as a depth image end in the wire file, None without one.
    Every method raises DamagedError, which names the frame.
    """

    large = False
    names: frozenset[str]
    meta: dict[str, Any]
    chunks: NDArray[Any]
    depth_ends: NDArray[Any] | None = None
    count: int

    def __init__(
        self,
        folder: Path,
        index: int,
        manifest: Manifest,
        checksums: Mapping[str, str],
        held: object = None,
    ) -> None:
        """``folder`` holds the sequence's frames; ``checksums`` are by name within it.

        ``held`` keeps the files there, see ``FolderFiles.hold``.
        """
        self.index, self._folder, self._held = index, folder, held
        self._checksums, self._placement = checksums, manifest.placement
        self._shift, points = np.array(manifest.shift), manifest.points[index]
        self._wire_path = folder / f"{index:06d}.wire"
        self._wire: memoryview | None = None
        with self.telling():
            self._open()
            if self.count != points:
                raise DamagedError(f"expected {points:,} points, its files have {self.count:,}")

    def _open(self) -> None:
        raise NotImplementedError

    @contextmanager
    def telling(self) -> Iterator[None]:
        """Name the frame in a DamagedError."""
        try:
            yield
        except DamagedError as error:
            raise DamagedError(f"frame {self.index} is damaged: {error}") from error

    def checksum(self, path: Path) -> str | None:
        """Return the checksum of a file at its import, or None if it was not recorded."""
        return self._checksums.get(str(path.relative_to(self._folder)))

    @property
    def wire_bytes(self) -> int:
        """Length that the wire file must have."""
        if self.depth_ends is not None and len(self.depth_ends):
            return int(self.depth_ends[-1])
        return int((self.chunks["offset"] + self.chunks["nbytes"]).max(initial=0))

    def verify(self, names: Collection[str]) -> int:
        """Compare the files of these arrays with their checksums, unless this process has.

        Returns their bytes.
        """
        self.look()
        with self.telling():
            return sum(
                verifier.require(path, self.checksum(path)).size for path in self.paths(names)
            )

    def paths(self, names: Collection[str]) -> list[Path]:
        """The files of these arrays."""
        raise NotImplementedError

    def array(self, name: str) -> NDArray[Any]:
        """A whole array that is in ``names``, read-only."""
        raise NotImplementedError

    def rows(self, name: str, first: int, stop: int) -> NDArray[Any]:
        """Rows ``first`` to before ``stop`` of an array."""
        raise NotImplementedError

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the coordinates that were imported."""
        dtype: np.dtype[Any] = np.dtype(self.meta["dtype"])
        return dtype

    def source(self, first: int, stop: int) -> NDArray[Any]:
        """Coordinates of points ``first`` to before ``stop`` as they were imported, bit for bit."""
        exact = self.rows("residual", first, stop) if "residual" in self.names else None
        return from_local(self.rows("xyz", first, stop), exact, self._shift, self.dtype)

    def coordinates(self) -> NDArray[np.float32] | Coordinates:
        """Local coordinates (N, 3) by number."""
        return self.array("xyz")

    def wire(self, start: int, stop: int) -> memoryview:
        """Bytes ``start`` to before ``stop`` of the wire file."""
        raise NotImplementedError

    def look(self) -> None:
        """Check the lengths of the mapped files of arrays."""

    def release(self) -> None:
        """Release the pages of mapped memory that were read."""


class CopiedFiles(FrameFiles):
    """A frame that fits in memory: one file of arrays, and the wire file."""

    def _open(self) -> None:
        self.path = self._wire_path.with_suffix(".points")
        verifier.soon(self.path, self.checksum(self.path))
        self._layout: Layout = read_layout(self.path)
        self.names, self.meta = frozenset(self._layout.entries), self._layout.meta
        self.count = self._layout.entries["xyz"].shape[0]
        self.chunks = read_array(self.path, self._layout, "chunks")
        if "depth_ends" in self.names:
            self.depth_ends = read_array(self.path, self._layout, "depth_ends")

    def paths(self, names: Collection[str]) -> list[Path]:  # noqa: ARG002 - one file has all
        return [self.path]

    def arrays(self) -> Arrays:
        """All arrays, compared with their checksum; a copy that no change of the file affects."""
        key = str(self.path), self._placement
        return _copied.get(key, self._copy, self._copied_bytes)

    @property
    def _copied_bytes(self) -> int:
        return self._layout.nbytes

    def _copy(self) -> Arrays:
        with self.telling():
            stamp = stamp_of(self.path)
            data = read_file(self.path, stamp.size)
            verifier.require_bytes(self.path, stamp, data, self.checksum(self.path))
            return parse_arrays(self.path, data)

    def array(self, name: str) -> NDArray[Any]:
        return self.arrays()[name]

    def rows(self, name: str, first: int, stop: int) -> NDArray[Any]:
        return self.arrays()[name][first:stop]

    def wire(self, start: int, stop: int) -> memoryview:
        view = self._wire
        if view is None or _cut(view) or verifier.suspects(self.path):
            with self.telling():
                verifier.refuse_damaged(self.path)
                view = self._wire = self._map_wire()
        return view[start:stop]

    def _map_wire(self) -> memoryview:
        self._wire = None
        view = map_file(self._wire_path)
        if len(view) != self.wire_bytes:
            raise DamagedError(
                f"expected {self.wire_bytes:,} bytes in {self._wire_path.name}, got {len(view):,}"
            )
        verifier.require(self._wire_path, self.checksum(self._wire_path))
        return view


class MappedFiles(FrameFiles):
    """An octree: a folder of ``.npy`` files, and the wire file, which is read piece by piece.

    The coordinates are plain, as in octrees before manifest version 4.
    """

    large = True
    tables: tuple[str, ...] = TABLES
    positions = "xyz"
    """The array that holds the coordinates."""

    def _open(self) -> None:
        self.path = self._wire_path.with_suffix("")
        self.meta = read_meta(self.path)
        self._arrays = {file.stem: map_npy(file) for file in sorted(self.path.glob("*.npy"))}
        missing = {self.positions, "source_index", *self.tables} - self._arrays.keys()
        if missing:
            raise DamagedError(f"expected the files {', '.join(sorted(missing))}.npy, got none")
        self.names = frozenset({*self._arrays, "xyz"})
        self.count = len(self._arrays["source_index"])
        for name in self.tables:
            path = self.path / f"{name}.npy"
            verifier.require(path, self.checksum(path))
            self._arrays[name] = read_rows(path, 0, len(self._arrays[name]))
        self.chunks = self._arrays["chunks"]
        for path in [*self.paths(self.names), self.path / "meta.json", self._wire_path]:
            verifier.soon(path, self.checksum(path))

    def paths(self, names: Collection[str]) -> list[Path]:
        kept = {self.positions if name == "xyz" else name for name in names}
        return [self.path / f"{name}.npy" for name in sorted(kept & self._arrays.keys())]

    def array(self, name: str) -> NDArray[Any]:
        with self.telling():
            self._look(name)
        return self._arrays[name]

    def rows(self, name: str, first: int, stop: int) -> NDArray[Any]:
        path = self.path / f"{name}.npy"
        with self.telling():
            verifier.refuse_damaged(path)
            return read_rows(path, first, stop)

    def wire(self, start: int, stop: int) -> memoryview:
        with self.telling():
            verifier.refuse_damaged(self._wire_path)
            return memoryview(read_range(self._wire_path, start, stop))

    def look(self) -> None:
        with self.telling():
            for name in self._arrays:
                self._look(name)

    def _look(self, name: str) -> None:
        path, base = self.path / f"{name}.npy", self._arrays[name].base
        verifier.refuse_damaged(path)
        if isinstance(base, np.memmap):
            mapped: mmap.mmap = base._mmap  # type: ignore[attr-defined]  # numpy's own
            if mapped.size() < len(mapped):
                raise DamagedError(
                    f"expected {len(mapped):,} bytes in {path.name}, got {mapped.size():,}"
                )

    def release(self) -> None:
        self.look()
        for array in self._arrays.values():
            release(array)


class PackedFiles(MappedFiles):
    """An octree with packed coordinates."""

    tables = (*TABLES, *PACKED[1:])
    positions = PACKED[0]
    _whole: ref[NDArray[np.float32]] | None = None

    def _open(self) -> None:
        super()._open()
        try:
            self._packed = Coordinates(self._arrays, self.meta, self._shift)
        except (ValueError, KeyError, TypeError) as error:
            raise DamagedError(f"expected coordinates in {self.path.name}, got: {error}") from error

    def array(self, name: str) -> NDArray[Any]:
        if name != "xyz":
            return super().array(name)
        # A weak reference: while a caller uses the array, further calls do not unpack it again.
        whole = None if self._whole is None else self._whole()
        if whole is None:
            whole = self.rows(name, 0, self.count)
            whole.flags.writeable = False
            self._whole = ref(whole)
        return whole

    def rows(self, name: str, first: int, stop: int) -> NDArray[Any]:
        if name != "xyz":
            return super().rows(name, first, stop)
        return self._packed.local(first, stop, self._words(first, stop))

    def source(self, first: int, stop: int) -> NDArray[Any]:
        return self._packed.source(first, stop, self._words(first, stop))

    def coordinates(self) -> Coordinates:
        with self.telling():
            self._look(self.positions)
        return self._packed

    def _words(self, first: int, stop: int) -> NDArray[np.uint64]:
        return super().rows(self.positions, *self._packed.span(first, stop))


def _cut(view: memoryview) -> bool:
    """Whether the file behind a mapping is shorter than the mapping: fstat, about 1 µs."""
    mapped = view.obj
    return isinstance(mapped, mmap.mmap) and mapped.size() < len(mapped)
