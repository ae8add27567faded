"""Arrays of ``.npz`` archives from outside: uploads, answers of services, files of a workspace.

Compiled loops index with these arrays without checks of their own, so each array's type, shape and
range is checked here before anything uses it.  Nothing is unpickled.
"""

from __future__ import annotations

import io
import math
import zipfile
import zlib
from collections.abc import Mapping
from lzma import LZMAError
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy_format
from numpy.typing import NDArray

from pointbrush.errors import BadInputError

Arrays = Mapping[str, NDArray[Any]]
MOST_MEMBERS = 1_000
"""Arrays in an archive."""
PART = 1 << 20
"""Bytes that are unpacked at a time."""
HEADERS = {
    (1, 0): npy_format.read_array_header_1_0,
    (2, 0): npy_format.read_array_header_2_0,
}


def read_header(stream: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Return shape, Fortran order and type of a ``.npy`` stream, up to its data.

    Raises BadInputError.
    """
    try:
        version = npy_format.read_magic(stream)
        if version not in HEADERS:
            raise BadInputError(f"expected .npy version 1.0 or 2.0, got {version}")
        shape, fortran, dtype = HEADERS[version](stream)
    except BadInputError:
        raise
    # NumPy evaluates the header as a literal: damaged headers raise almost any exception.
    except Exception as error:
        raise BadInputError(f"expected a .npy array ({error})"[:300]) from error
    return shape, fortran, dtype


def read_npz(source: bytes | Path, most_bytes: int) -> dict[str, NDArray[Any]]:
    """Return the arrays of an archive that take at most ``most_bytes`` when unpacked.

    Raises BadInputError for anything else, and OSError for a file that cannot be read.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(source) if isinstance(source, bytes) else source) as found:
            members = found.infolist()
            if len(members) > MOST_MEMBERS:
                raise BadInputError(f"expected at most {MOST_MEMBERS} arrays, got {len(members)}")
            size = sum(member.file_size for member in members)
            if size > most_bytes:
                raise BadInputError(f"expected at most {most_bytes} unpacked bytes, got {size}")
            return {
                member.filename.removesuffix(".npy"): _array(found, member) for member in members
            }
    except BadInputError:
        raise
    # RuntimeError: encrypted, or an unsupported compression; ValueError: a negative offset.
    except (zipfile.BadZipFile, zlib.error, LZMAError, EOFError, RuntimeError, ValueError) as error:
        raise BadInputError(f"expected an .npz archive ({error})"[:300]) from None


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> NDArray[Any]:
    """Read one array; the size in its header is compared with its bytes before they are read."""
    with archive.open(member) as file:
        shape, fortran, dtype = read_header(file)
        if dtype.hasobject:
            raise BadInputError(f"{member.filename}: expected numbers or text, got objects")
        count = math.prod(shape) * dtype.itemsize
        given = member.file_size - file.tell()
        if count != given:
            raise BadInputError(
                f"{member.filename}: expected {count} bytes of {dtype} {shape}, got {given}"
            )
        data = bytearray(count)  # writable, as compiled loops expect
        at = 0
        while part := file.read(PART):
            data[at : at + len(part)] = part
            at += len(part)
        if at != count:
            raise BadInputError(f"{member.filename}: expected {count} bytes, got {at}")
    array = np.ndarray(shape, dtype, data, order="F" if fortran else "C")
    return np.ascontiguousarray(array) if array.ndim else array


def checked(
    arrays: Arrays,
    name: str,
    dtype: type,
    shape: tuple[int | None, ...],
    low: float = -math.inf,
    high: float = math.inf,
) -> NDArray[Any]:
    """Return an array of ``dtype`` and ``shape`` (None: any length), its values within bounds.

    Floats must be finite where a bound is given.  Raises BadInputError.
    """
    found = arrays.get(name)
    wanted = f"{np.dtype(dtype)} ({', '.join('n' if n is None else str(n) for n in shape)})"
    if found is None:
        raise BadInputError(f"expected {name} {wanted}, got no such array")
    fits = found.ndim == len(shape) and all(
        wish in (None, length) for wish, length in zip(shape, found.shape, strict=True)
    )
    if found.dtype != dtype or not fits:
        raise BadInputError(f"expected {name} {wanted}, got {found.dtype} {found.shape}")
    bounded = low > -math.inf or high < math.inf
    if bounded and found.size and not (low <= found.min() and found.max() <= high):
        raise BadInputError(f"expected {name} from {low} to {high}, got {extremes(found)}")
    return found


def extremes(values: NDArray[Any]) -> str:
    """Return the least and greatest value as text, or the first value that is not finite."""
    odd = values[~np.isfinite(values)]
    return str(odd.flat[0]) if odd.size else f"{values.min()} to {values.max()}"
