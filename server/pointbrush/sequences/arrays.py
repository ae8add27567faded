"""Named arrays in one file, or one ``.npy`` each in a folder, memory-mapped for reading.

A small frame is one file: magic, length of a JSON header, the header, then each array at a
multiple of 64 bytes.  A large frame, written piece by piece, is a folder of ``.npy`` files.
Whichever it is, ``open_arrays`` returns read-only views of the page cache.
"""

from __future__ import annotations

import json
import mmap
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.sequences.files import write_file

MAGIC = b"PBARRAY1"
_ALIGN = 64
_PIECE = 1 << 22

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
    offset = 0
    for name, array in arrays.items():
        offset = -(-offset // _ALIGN) * _ALIGN
        descr = np.lib.format.dtype_to_descr(array.dtype)
        table[name] = {"dtype": descr, "shape": array.shape, "offset": offset}
        offset += array.nbytes
    header = json.dumps({"arrays": table, "meta": meta}, separators=(",", ":")).encode()
    start = -(-(16 + len(header)) // _ALIGN) * _ALIGN
    out = bytearray(start + offset)
    out[:16] = MAGIC + len(header).to_bytes(8, "little")
    out[16 : 16 + len(header)] = header
    for name, array in arrays.items():
        at = start + table[name]["offset"]
        out[at : at + array.nbytes] = np.ascontiguousarray(array).tobytes()
    return bytes(out)


def open_arrays(path: Path) -> tuple[Arrays, dict[str, Any]]:
    """Read-only arrays and meta of ``path``, an array file or a folder of them.

    Raises NotFoundError when it is absent, BadInputError when it is damaged.
    """
    try:
        if path.is_dir():
            meta = json.loads((path / "meta.json").read_bytes())
            return {file.stem: _open_npy(file) for file in sorted(path.glob("*.npy"))}, meta
        return _parse(map_file(path))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInputError(f"{path.name}: expected stored arrays, got {error}") from error


def map_file(path: Path) -> memoryview:
    """A whole file as read-only memory; the mapping lives as long as its views."""
    try:
        with path.open("rb") as file:
            if path.stat().st_size == 0:
                return memoryview(b"")
            return memoryview(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ))
    except FileNotFoundError as error:
        raise NotFoundError(f"expected the file {path.name} of the sequence, it is gone") from error


def read_range(path: Path, start: int, stop: int) -> bytes:
    """Bytes ``start`` to before ``stop`` of a file."""
    with path.open("rb") as file:
        file.seek(start)
        return file.read(stop - start)


def read_rows(path: Path, first: int, stop: int) -> NDArray[Any]:
    """Rows ``first`` to before ``stop`` of an ``.npy`` file, read rather than mapped."""
    with path.open("rb") as file:
        np.lib.format.read_magic(file)
        shape, _, dtype = np.lib.format.read_array_header_1_0(file)
        row = shape[1:]
        width = int(np.prod(row, dtype=np.int64))
        file.seek(first * width * dtype.itemsize, 1)
        return np.fromfile(file, dtype, (stop - first) * width).reshape(-1, *row)


def _open_npy(path: Path) -> NDArray[Any]:
    # A view of the base class: the memmap subclass makes each slice several times slower.
    mapped: NDArray[Any] = np.load(path, mmap_mode="r", allow_pickle=False)
    return mapped.view(np.ndarray)


def release(array: NDArray[Any]) -> None:
    """Take the pages of a mapped ``.npy`` out of this process's memory; others are left alone."""
    if isinstance(array.base, np.memmap) and hasattr(mmap, "MADV_DONTNEED"):
        array.base._mmap.madvise(mmap.MADV_DONTNEED)  # type: ignore[attr-defined]  # numpy's own


def _parse(data: memoryview) -> tuple[Arrays, dict[str, Any]]:
    if bytes(data[:8]) != MAGIC:
        raise ValueError("another magic number")
    length = int.from_bytes(data[8:16], "little")
    header = json.loads(bytes(data[16 : 16 + length]))
    start = -(-(16 + length) // _ALIGN) * _ALIGN
    arrays: Arrays = {}
    for name, entry in header["arrays"].items():
        dtype = np.dtype(np.lib.format.descr_to_dtype(entry["dtype"]))
        shape = tuple(entry["shape"])
        count = int(np.prod(shape, dtype=np.int64))
        at = start + entry["offset"]
        if count == 0:
            arrays[name] = np.empty(shape, dtype)
        else:
            arrays[name] = np.frombuffer(data, dtype, count, at).reshape(shape)
    return arrays, header["meta"]


def write_arrays(
    path: Path, arrays: Mapping[str, NDArray[Any]], meta: Mapping[str, Any]
) -> dict[str, str]:
    """Write an array file durably; returns its checksum under its name."""
    data = pack_arrays(arrays, meta)
    write_file(path, data)
    return {path.name: digest(data)}
