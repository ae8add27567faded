"""Named arrays in one file, or one ``.npy`` each in a folder.

A small frame is one file: magic, length of a JSON header, the header, then each array at a
multiple of 64 bytes: plain, or, where it is shorter so, its first bytes, its second bytes and so on
packed by LZ4.  A large frame, written piece by piece, is a folder of ``.npy`` files.
Every function that reads returns all requested data or raises DamagedError.
"""

from __future__ import annotations

import contextlib
import json
import mmap
import os
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import lz4.block
import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import DamagedError
from pointbrush.sequences.storage.files import write_file
from pointbrush.system.resources import shortage

MAGIC = b"PBARRAY2"
_MAGICS = (MAGIC, b"PBARRAY1")  # which has plain arrays only
_ALIGN = 64
_WORTH_PACKING = 4096
"""Bytes of an array; smaller ones stay plain."""
_MOST_GAIN = 255
"""Greatest ratio of LZ4 compression: a damaged header must not allocate all memory."""
_PIECE = 1 << 22
POINTS = ("xyz", "source_index", "chunks")
"""Arrays that every frame has."""

Arrays = dict[str, NDArray[Any]]


def digest(data: bytes | memoryview) -> str:
    """Checksum as kept in ``checksums.json``."""
    return sha256(data).hexdigest()


def file_digest(path: Path) -> str:
    """Checksum of a file, read piece by piece."""
    checksum = sha256()
    with path.open("rb") as file:
        while piece := file.read(_PIECE):
            checksum.update(piece)
    return checksum.hexdigest()


def pack_arrays(arrays: Mapping[str, NDArray[Any]], meta: Mapping[str, Any]) -> bytes:
    """The bytes of an array file with these arrays and this JSON-ready ``meta``."""
    table: dict[str, dict[str, Any]] = {}
    stored: list[tuple[int, bytes]] = []
    offset = 0
    for name, array in arrays.items():
        offset = -(-offset // _ALIGN) * _ALIGN
        plain = np.ascontiguousarray(array)
        packed = _pack(plain)
        data = plain.tobytes() if packed is None else packed
        descr = np.lib.format.dtype_to_descr(array.dtype)
        table[name] = {"dtype": descr, "shape": array.shape, "offset": offset}
        if packed is not None:
            table[name]["packed"] = len(packed)
        stored.append((offset, data))
        offset += len(data)
    header = json.dumps({"arrays": table, "meta": meta}, separators=(",", ":")).encode()
    start = -(-(16 + len(header)) // _ALIGN) * _ALIGN
    parts = [MAGIC, len(header).to_bytes(8, "little"), header]
    end = 16 + len(header)
    for at, data in [*stored, (offset, b"")]:
        parts += bytes(start + at - end), data
        end = start + at + len(data)
    return b"".join(parts)


def _pack(array: NDArray[Any]) -> bytes | None:
    """Return an array's bytes grouped by place in the item and packed; None: hardly shorter."""
    if array.nbytes < _WORTH_PACKING or array.dtype.hasobject:
        return None
    places = array.view(np.uint8).reshape(len(array), -1).T
    packed: bytes = lz4.block.compress(np.ascontiguousarray(places), store_size=False)
    return packed if len(packed) < 15 * array.nbytes // 16 else None


@dataclass(frozen=True, slots=True)
class Entry:
    """Extent of an array in its file."""

    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    offset: int
    packed: int | None

    @property
    def nbytes(self) -> int:
        """Bytes of the array in memory."""
        return int(np.prod(self.shape, dtype=np.int64)) * self.dtype.itemsize

    @property
    def stop(self) -> int:
        """End of the array in the file."""
        return self.offset + (self.nbytes if self.packed is None else self.packed)

    def array(self, data: bytes) -> NDArray[Any]:
        """Return a read-only copy of the array from the bytes between offset and stop."""
        if self.packed is not None:
            if self.nbytes > _MOST_GAIN * self.packed:
                raise ValueError(f"{self.nbytes:,} bytes packed as {self.packed:,}")
            try:
                data = lz4.block.decompress(data, uncompressed_size=self.nbytes)
            except lz4.block.LZ4BlockError as error:
                raise ValueError(f"packed bytes that are none: {error}") from error
            if len(data) != self.nbytes:
                raise ValueError(f"{len(data):,} unpacked bytes of {self.nbytes:,}")
            places = np.frombuffer(data, np.uint8).reshape(-1, self.shape[0])
            data = np.ascontiguousarray(places.T).tobytes()
        return np.frombuffer(data, self.dtype).reshape(self.shape)


@dataclass(frozen=True, slots=True)
class Layout:
    """Header of an array file; ``nbytes`` is the file's length."""

    entries: dict[str, Entry]
    meta: dict[str, Any]
    nbytes: int


@contextlib.contextmanager
def _damaged(path: Path) -> Iterator[None]:
    """Convert the errors of reading a damaged file to DamagedError."""
    try:
        yield
    except OSError as error:
        if (short := shortage(error)) is not None:
            raise short from error
        reason = error.strerror or error
        raise DamagedError(f"expected stored arrays in {path.name}, got: {reason}") from error
    except (ValueError, KeyError, TypeError, OverflowError) as error:
        raise DamagedError(f"expected stored arrays in {path.name}, got: {error}") from error


def read_layout(path: Path) -> Layout:
    """The layout of an array file that has these arrays and its length; raises DamagedError."""
    with _damaged(path), path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        head = file.read(16)
        length = int.from_bytes(head[8:16], "little")
        if length > size:
            raise ValueError("a header longer than the file")
        return _layout(head + file.read(length), size, POINTS)


def _layout(head: bytes, size: int, required: Collection[str]) -> Layout:
    if head[:8] not in _MAGICS:
        raise ValueError("another magic number")
    length = int.from_bytes(head[8:16], "little")
    header = json.loads(head[16 : 16 + length])
    start = -(-(16 + length) // _ALIGN) * _ALIGN
    entries = {
        name: Entry(
            np.dtype(np.lib.format.descr_to_dtype(entry["dtype"])),
            tuple(entry["shape"]),
            start + entry["offset"],
            entry.get("packed"),
        )
        for name, entry in header["arrays"].items()
    }
    length = max([start, *(entry.stop for entry in entries.values())])
    if length != size:
        raise ValueError(f"{size:,} bytes of {length:,}")
    if not entries.keys() >= set(required):
        raise ValueError(f"no more than {', '.join(entries)}")
    nbytes = sum(entry.nbytes for entry in entries.values())
    return Layout(entries, header["meta"], nbytes)


def read_array(path: Path, layout: Layout, name: str) -> NDArray[Any]:
    """A copy of one array of an array file; raises DamagedError."""
    entry = layout.entries[name]
    with _damaged(path):
        return entry.array(read_range(path, entry.offset, entry.stop))


def read_file(path: Path, nbytes: int) -> bytes:
    """A file of ``nbytes``, copied; raises DamagedError."""
    with _damaged(path), path.open("rb") as file:
        data = file.read()
        if len(data) != nbytes:
            raise ValueError(f"{len(data):,} bytes of {nbytes:,}")
        return data


def parse_arrays(path: Path, data: bytes, required: Collection[str] = POINTS) -> Arrays:
    """Return read-only copies of the arrays in an array file's bytes; raises DamagedError."""
    with _damaged(path):
        layout = _layout(data, len(data), required)
        return {
            name: entry.array(data[entry.offset : entry.stop])
            for name, entry in layout.entries.items()
        }


def read_meta(path: Path) -> dict[str, Any]:
    """Read the facts beside the arrays of a folder; raises DamagedError."""
    with _damaged(path / "meta.json"):
        meta: dict[str, Any] = json.loads((path / "meta.json").read_bytes())
        return meta


def map_npy(path: Path) -> NDArray[Any]:
    """A read-only view of an ``.npy`` file in the page cache; raises DamagedError."""
    with _damaged(path):
        # A view of the base class: the memmap subclass makes each slice several times slower.
        mapped: NDArray[Any] = np.load(path, mmap_mode="r", allow_pickle=False)
        return mapped.view(np.ndarray)


def map_file(path: Path) -> memoryview:
    """A whole file as read-only memory; the mapping lives as long as its views."""
    with _damaged(path), path.open("rb") as file:
        if os.fstat(file.fileno()).st_size == 0:
            return memoryview(b"")
        return memoryview(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ))


def read_range(path: Path, start: int, stop: int) -> bytes:
    """Bytes ``start`` to before ``stop`` of a file; raises DamagedError when it is shorter."""
    with _damaged(path), path.open("rb") as file:
        file.seek(start)
        data = file.read(stop - start)
        if len(data) != stop - start:
            raise ValueError(f"{start + len(data):,} bytes, of {stop:,} or more")
        return data


def read_rows(path: Path, first: int, stop: int) -> NDArray[Any]:
    """Rows ``first`` to before ``stop`` of an ``.npy`` file, read rather than mapped."""
    with _damaged(path), path.open("rb") as file:
        np.lib.format.read_magic(file)
        shape, _, dtype = np.lib.format.read_array_header_1_0(file)
        row = shape[1:]
        width = int(np.prod(row, dtype=np.int64))
        file.seek(first * width * dtype.itemsize, 1)
        return np.fromfile(file, dtype, (stop - first) * width).reshape(stop - first, *row)


def release(array: NDArray[Any]) -> None:
    """Remove the pages of a mapped ``.npy`` from this process's memory; ignore other arrays."""
    if isinstance(array.base, np.memmap) and hasattr(mmap, "MADV_DONTNEED"):
        array.base._mmap.madvise(mmap.MADV_DONTNEED)  # type: ignore[attr-defined]  # numpy's own


def write_arrays(
    path: Path, arrays: Mapping[str, NDArray[Any]], meta: Mapping[str, Any]
) -> dict[str, str]:
    """Write an array file durably; returns its checksum under its name."""
    data = pack_arrays(arrays, meta)
    write_file(path, data)
    return {path.name: digest(data)}
