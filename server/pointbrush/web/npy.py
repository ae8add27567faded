"""``.npy`` bodies, read without trusting them: header, then type and shape, then the data."""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Container, Iterator, Mapping, Sequence
from itertools import chain
from typing import Any, cast

import numpy as np
from numpy.lib import format as npy_format
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.exchange.npz import read_header
from pointbrush.streaming.shared.status import MalformedError

MEDIA_TYPE = "application/x-npy"
HEADER_ROOM = 4096
"""Bytes of a header, at most."""
MOST_BYTES = 256 << 20
"""Most bytes of the arrays of several frames in one call."""
BLOCK = 1 << 18
"""Points formatted at once while an array is streamed."""

Columns = Mapping[str, NDArray[Any]]


def parse(body: bytes | bytearray, dtype: np.dtype[Any], count: int) -> NDArray[Any]:
    """The array of a ``.npy`` body: exactly ``(count,)`` of ``dtype`` (any byte order).

    A view on ``body`` where possible; nothing is unpickled.
    Raises MalformedError (no .npy) or BadInputError (another type or shape).
    """
    shape, _, found, offset = _header(body)
    if found.hasobject or found.newbyteorder("=") != dtype:
        raise BadInputError(f"array: expected {dtype}, got {found}")
    if shape != (count,):
        raise BadInputError(f"array: expected shape ({count},), one value a point, got {shape}")
    return _data(body, offset, found, count).astype(dtype, copy=False)


def _header(body: bytes | bytearray) -> tuple[tuple[int, ...], bool, np.dtype[Any], int]:
    """Return shape, Fortran order, type and offset of the data; raises MalformedError."""
    stream = io.BytesIO(body)
    try:
        shape, fortran, found = read_header(stream)
    except BadInputError as error:
        raise MalformedError(f"body: {error}, {len(body)} bytes long") from error
    return shape, fortran, found, stream.tell()


def _data(body: bytes | bytearray, offset: int, found: np.dtype[Any], count: int) -> NDArray[Any]:
    """Return ``count`` values from ``offset`` to the end of a body; raises MalformedError."""
    if len(body) - offset != count * found.itemsize:
        raise MalformedError(
            f"array: expected {count * found.itemsize} bytes of data, got {len(body) - offset}"
        )
    return np.frombuffer(body, found, count, offset)


def parse_image(
    body: bytes | bytearray, dtypes: Sequence[np.dtype[Any]], size: tuple[int, int]
) -> NDArray[Any]:
    """Return the array (H, W) of a ``.npy`` body of one of ``dtypes``, of any byte order.

    ``size``: width and height.
    Raises MalformedError (no .npy) or BadInputError (another type or shape).
    """
    shape, fortran, found, offset = _header(body)
    expected = size[::-1]
    if found.newbyteorder("=") not in dtypes:
        raise BadInputError(f"array: expected {' or '.join(map(str, dtypes))}, got {found}")
    if shape != expected:
        raise BadInputError(f"array: expected shape {expected}, height and width, got {shape}")
    flat = _data(body, offset, found, shape[0] * shape[1])
    native = flat.astype(found.newbyteorder("="), copy=False)
    return native.reshape(shape, order="F" if fortran else "C")


def of_array(array: NDArray[Any]) -> bytes:
    """Return an array as ``.npy``."""
    content = io.BytesIO()
    np.save(content, array, allow_pickle=False)
    return content.getvalue()


def parse_by_frame(
    body: bytes | bytearray, dtype: np.dtype[Any], counts: Sequence[int]
) -> dict[int, NDArray[Any]]:
    """Read the arrays of a ``.npz`` body by frame: members ``I.npy`` of (counts[I],) ``dtype``.

    Raises MalformedError (no .npz), BadInputError (another name, type or shape, no member),
    TooLargeError.
    """
    found: dict[int, NDArray[Any]] = {}
    room = MOST_BYTES
    try:
        with zipfile.ZipFile(io.BytesIO(body)) as archive:
            for member in archive.infolist():
                frame = _frame_of(member.filename, len(counts), found)
                limit = counts[frame] * dtype.itemsize + HEADER_ROOM
                room -= limit
                if room < 0:
                    raise TooLargeError(f"body: expected at most {MOST_BYTES} bytes of arrays")
                with archive.open(member) as file:
                    content = file.read(limit + 1)  # the stated size of a member may be wrong
                found[frame] = parse(content, dtype, counts[frame])
    # RuntimeError: encrypted; NotImplementedError: an unsupported compression.
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError) as error:
        raise MalformedError(f"body: expected an .npz archive: {error}") from None
    if not found:
        raise BadInputError("body: expected an array of at least one frame, got none")
    return found


def _frame_of(name: str, frames: int, found: Container[int]) -> int:
    """Read the frame of a member's name, below ``frames`` and not ``found`` yet."""
    number = name.removesuffix(".npy")
    if not (number.isascii() and number.isdigit() and len(number) < 10 and int(number) < frames):
        raise BadInputError(
            f"array: expected names of frames, 0 to {frames - 1}, got {number[:60]!r}"
        )
    if int(number) in found:
        raise BadInputError(f"array: expected frame {number} once, got it again")
    return int(number)


def stream_array(
    blocks: Iterator[NDArray[Any]], dtype: np.dtype[Any], count: int
) -> tuple[int, Iterator[bytes]]:
    """A ``.npy`` file of ``count`` values that come in ``blocks``: its length and its pieces."""
    header = _described(dtype, (count,))

    def pieces() -> Iterator[bytes]:
        yield header
        for array in blocks:
            for first in range(0, len(array), BLOCK):
                yield array[first : first + BLOCK].tobytes()

    return len(header) + count * dtype.itemsize, pieces()


def _described(dtype: np.dtype[Any], shape: tuple[int, ...]) -> bytes:
    header = io.BytesIO()
    description = {
        "descr": npy_format.dtype_to_descr(dtype),
        "fortran_order": False,
        "shape": shape,
    }
    npy_format.write_array_header_1_0(header, cast(Any, description))
    return header.getvalue()


def stream_points(blocks: Iterator[Columns], count: int) -> tuple[int, Iterator[bytes]]:
    """A frame's ``count`` points as a structured ``.npy``: its length and its pieces.

    Fields: ``xyz`` (3,), and ``rgb`` (3,) uint8, ``intensity`` float32 and ``sensor`` uint8 where
    there are any.
    """
    first = next(blocks)
    dtype = np.dtype([(name, array.dtype, array.shape[1:]) for name, array in first.items()])
    header = _described(dtype, (count,))
    blocks = chain([first], blocks)
    del first  # a block is large: free it before the end

    def pieces() -> Iterator[bytes]:
        yield header
        for columns in blocks:
            for start in range(0, len(columns["xyz"]), BLOCK):
                part = np.empty(min(BLOCK, len(columns["xyz"]) - start), dtype)
                for name, array in columns.items():
                    part[name] = array[start : start + BLOCK]
                yield part.tobytes()

    return len(header) + count * dtype.itemsize, pieces()


def stream_npz(fields: Mapping[str, Iterator[NDArray[Any]]], count: int) -> Iterator[bytes]:
    """A ``.npz`` with an array of ``count`` rows for each field, uncompressed as it is read once.

    Each field's blocks are read when its turn comes.
    """
    sink = _Sink()
    with zipfile.ZipFile(cast(Any, sink), "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
        for name, blocks in fields.items():
            first = next(blocks)
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                member.write(_described(first.dtype, (count, *first.shape[1:])))
                blocks = chain([first], blocks)
                del first
                for array in blocks:
                    for start in range(0, len(array), BLOCK):
                        member.write(array[start : start + BLOCK].tobytes())
                        yield sink.taken()
    yield sink.taken()


class _Sink:
    """Target of an archive that leaves at once."""

    def __init__(self) -> None:
        self._gathered: list[bytes] = []

    def write(self, data: bytes) -> int:
        self._gathered.append(bytes(data))
        return len(data)

    def flush(self) -> None:
        """Do nothing: ``taken`` returns the bytes."""

    def taken(self) -> bytes:
        """Remove and return the bytes written since the last call."""
        data = b"".join(self._gathered)
        self._gathered.clear()
        return data
