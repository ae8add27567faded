"""``.npy`` bodies, read without trusting them: header, then type and shape, then the data."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from typing import Any, cast

import numpy as np
from numpy.lib import format as npy_format
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.frame import PointFrame
from pointbrush.streaming.status import MalformedError

MEDIA_TYPE = "application/x-npy"
BLOCK = 1 << 18
"""Points formatted at once while an array is streamed."""


def parse(body: bytes, dtype: np.dtype[Any], count: int) -> NDArray[Any]:
    """The array of a ``.npy`` body: exactly ``(count,)`` of ``dtype`` (any byte order).

    A view on ``body`` where possible; nothing is unpickled.
    Raises MalformedError (no .npy) or BadInputError (another type or shape).
    """
    shape, found, offset = _header(body)
    if found.hasobject or found.newbyteorder("=") != dtype:
        raise BadInputError(f"array: expected {dtype}, got {found}")
    if shape != (count,):
        raise BadInputError(f"array: expected shape ({count},), one value a point, got {shape}")
    if len(body) - offset != count * found.itemsize:
        raise MalformedError(
            f"array: expected {count * found.itemsize} bytes of data, got {len(body) - offset}"
        )
    array = np.frombuffer(body, found, count, offset)
    return array.astype(dtype, copy=False)


def _header(body: bytes) -> tuple[tuple[int, ...], np.dtype[Any], int]:
    stream = io.BytesIO(body)
    try:
        version = npy_format.read_magic(stream)
        readers = {
            (1, 0): npy_format.read_array_header_1_0,
            (2, 0): npy_format.read_array_header_2_0,
        }
        if version not in readers:
            raise MalformedError(f"body: expected .npy version 1.0 or 2.0, got {version}")
        shape, _order, dtype = readers[version](stream)
    except MalformedError:
        raise
    # numpy's reader evaluates the header as a literal: junk raises almost anything.
    except Exception as error:
        raise MalformedError(
            f"body: expected a .npy array, got {len(body)} bytes that are none ({error})"[:300]
        ) from error
    return shape, dtype, stream.tell()


def dump(array: NDArray[Any]) -> bytes:
    """A ``.npy`` file."""
    stream = io.BytesIO()
    npy_format.write_array(stream, np.ascontiguousarray(array), allow_pickle=False)
    return stream.getvalue()


def stream_frame(frame: PointFrame) -> tuple[int, Iterator[bytes]]:
    """A frame as a structured ``.npy``: its length and its pieces.

    Fields: ``xyz`` (3,), and ``rgb`` (3,) uint8 and ``intensity`` float32 where there are any.
    """
    columns = columns_of(frame)
    dtype = np.dtype([(name, array.dtype, array.shape[1:]) for name, array in columns.items()])
    header = io.BytesIO()
    description = {"descr": dtype.descr, "fortran_order": False, "shape": (len(frame),)}
    npy_format.write_array_header_1_0(header, cast(Any, description))

    def pieces() -> Iterator[bytes]:
        yield header.getvalue()
        for first in range(0, len(frame), BLOCK):
            part = np.empty(min(BLOCK, len(frame) - first), dtype)
            for name, array in columns.items():
                part[name] = array[first : first + BLOCK]
            yield part.tobytes()

    return len(header.getvalue()) + len(frame) * dtype.itemsize, pieces()


def write_npz(frame: PointFrame, stream: Any) -> None:
    """A frame as ``.npz`` with one array a field, uncompressed as it is read once."""
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
        for name, array in columns_of(frame).items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                npy_format.write_array(member, np.ascontiguousarray(array), allow_pickle=False)


def columns_of(frame: PointFrame) -> dict[str, NDArray[Any]]:
    """The arrays that leave by REST, in the source's order."""
    columns: dict[str, NDArray[Any] | None] = {
        "xyz": frame.xyz,
        "rgb": frame.rgb,
        "intensity": frame.intensity,
    }
    return {name: array for name, array in columns.items() if array is not None}
