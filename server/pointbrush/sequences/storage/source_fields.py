"""Fields and headers of a source stored with a frame, so that exports contain them.

Under ``fields/``, in the source's order of points: further fields in array files,
``NNNNNN.fields`` of a frame or ``NNNNNN.FIRST.fields`` of its points from FIRST on;
``NNNNNN.header``, the source's header; ``NNNNNN.rows``, the rows of the points where some were
left out.  A recording without that folder has none.  Recordings of before manifest version 4 have
compressed ``.npz`` files in place of array files.
"""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import DamagedError
from pointbrush.frame import PointFrame
from pointbrush.sequences.octree.arrays import Arrays, digest, parse_arrays, write_arrays
from pointbrush.sequences.storage.files import write_file
from pointbrush.sequences.storage.verification import stamp_of, verifier

FIELDS = "fields"
_SKIPPED = "skipped"
_DAMAGE = (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile, zlib.error, DamagedError)


def write_source_fields(
    folder: Path, index: int, frame: PointFrame, first: int | None = None
) -> dict[str, str]:
    """Store a frame's source fields; ``first``: number of the first point, if it is a part.

    Returns the checksums of the files by their paths in ``folder``.
    """
    place, stem = folder / FIELDS, f"{index:06d}"
    checksums: dict[str, str] = {}
    header = None if first else frame.header
    rows = None if first is not None else frame.rows
    if frame.other or header is not None or rows is not None:
        place.mkdir(exist_ok=True)
    if frame.other:
        part = "" if first is None else f".{first:012d}"
        checksums |= write_arrays(place / f"{stem}{part}.fields", frame.other, {})
    if header is not None:
        path = place / f"{stem}.header"
        write_file(path, header)
        checksums[path.name] = digest(header)
    if rows is not None:
        # Differences of consecutive rows are zero and compress well.
        steps = np.diff(rows, prepend=-1) - 1
        checksums |= write_arrays(place / f"{stem}.rows", {_SKIPPED: steps.astype(np.uint32)}, {})
    return {f"{FIELDS}/{name}": value for name, value in checksums.items()}


def read_source_fields(
    folder: Path, checksums: Mapping[str, str], index: int, first: int, stop: int, count: int
) -> Arrays:
    """Return the further fields of points ``first`` to before ``stop`` of ``count``; {} for none.

    Raises DamagedError for files that are not as ``checksums`` have them, or not whole.
    """
    parts = _parts(folder / FIELDS, index)
    if not parts:
        return {}
    starts = sorted(parts)
    pieces: list[Arrays] = []
    for begin, end in zip(starts, [*starts[1:], count], strict=True):
        if begin < stop and end > first:
            part = _read(parts[begin], checksums, index, end - begin)
            cut = slice(max(first - begin, 0), min(stop, end) - begin)
            pieces.append({name: values[cut] for name, values in part.items()})
    if not pieces:
        return {}
    names = [name for name in pieces[0] if all(name in piece for piece in pieces)]
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in names}


def _parts(place: Path, index: int) -> dict[int, Path]:
    """The files of a frame's further fields by the first point that each has."""
    for suffix in ("fields", "npz"):
        whole = place / f"{index:06d}.{suffix}"
        if whole.is_file():
            return {0: whole}
        parts = sorted(place.glob(f"{index:06d}.{'[0-9]' * 12}.{suffix}"))
        if parts:
            return {int(path.name.split(".")[1]): path for path in parts}
    return {}


def _read(path: Path, checksums: Mapping[str, str], index: int, count: int) -> Arrays:
    try:
        found = _arrays(path, checksums)
    except _DAMAGE as error:
        raise DamagedError(f"frame {index}: expected its further fields: {error}") from None
    if any(values.shape != (count,) for values in found.values()):
        raise DamagedError(f"frame {index}: expected further fields of {count} points")
    return found


def _arrays(path: Path, checksums: Mapping[str, str]) -> Arrays:
    """The arrays of a file; in an ``.npz`` further fields are numbered, beside their ``names``."""
    if path.suffix != ".npz":  # an .npz has internal checksums
        stamp, data = stamp_of(path), path.read_bytes()
        verifier.require_bytes(path, stamp, data, checksums.get(f"{FIELDS}/{path.name}"))
        return parse_arrays(path, data, ())
    with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
        if "names" not in stored:
            return dict(stored)
        return {str(name): stored[f"field_{k}"] for k, name in enumerate(stored["names"])}


def read_source_header(folder: Path, index: int) -> bytes | None:
    """Return the header of a frame's source, or None."""
    path = folder / FIELDS / f"{index:06d}.header"
    return path.read_bytes() if path.is_file() else None


def read_rows(
    folder: Path, checksums: Mapping[str, str], index: int, count: int
) -> NDArray[np.int64] | None:
    """Read the source's row of each point (count,), or None where it is not known.

    Raises DamagedError for a file that is not as ``checksums`` have it, or not whole.
    """
    place = folder / FIELDS
    paths = [place / f"{index:06d}.rows{suffix}" for suffix in ("", ".npz")]
    path = next((path for path in paths if path.is_file()), None)
    if path is None:
        return None
    try:
        skipped = _arrays(path, checksums)[_SKIPPED]
    except _DAMAGE as error:
        raise DamagedError(f"frame {index}: expected its rows: {error}") from None
    if skipped.shape != (count,):
        raise DamagedError(f"frame {index}: expected rows of {count} points")
    return np.cumsum(skipped.astype(np.int64) + 1) - 1
