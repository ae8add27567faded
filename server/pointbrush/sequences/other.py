"""Fields and headers of a source kept beside a frame, so that exports give them back.

Under ``fields/``, in the source's order of points: further fields in compressed ``.npz`` files,
``NNNNNN.npz`` of a frame or ``NNNNNN.FIRST.npz`` of its points from FIRST on; ``NNNNNN.header``,
the source's header; ``NNNNNN.rows.npz``, the rows of the points where some were left out.  A
recording without that folder has none.
"""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import DamagedError
from pointbrush.frame import PointFrame
from pointbrush.sequences.files import write_file

FIELDS = "fields"
LEVEL = 1
"""Of deflate: a second of work for ten of an import is enough."""
DAMAGE = (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile, zlib.error)
Columns = dict[str, NDArray[Any]]


def write_other(folder: Path, index: int, frame: PointFrame, first: int | None = None) -> None:
    """Keep what a frame has of its source; of its points from ``first`` on, where it is a part."""
    place = folder / FIELDS
    if frame.other:
        part = "" if first is None else f".{first:012d}"
        # Numbers for names: a field may be called as nothing that a file can be called.
        arrays = {f"field_{k}": values for k, values in enumerate(frame.other.values())}
        _write(place / f"{index:06d}{part}.npz", {"names": np.array(list(frame.other)), **arrays})
    if not first and frame.header is not None:
        place.mkdir(exist_ok=True)
        write_file(place / f"{index:06d}.header", frame.header)
    if frame.rows is not None and first is None:
        # Differences: a run of points costs nothing.
        steps = np.diff(frame.rows, prepend=-1) - 1
        _write(place / f"{index:06d}.rows.npz", {"skipped": steps.astype(np.uint32)})


def _write(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED, compresslevel=LEVEL) as archive:
        for name, values in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.ascontiguousarray(values), allow_pickle=False)
    path.parent.mkdir(exist_ok=True)
    write_file(path, content.getvalue())


def read_other(folder: Path, index: int, first: int, stop: int, count: int) -> Columns:
    """Return the further fields of points ``first`` to before ``stop`` of ``count``; {} for none.

    Raises DamagedError for files that are not whole.
    """
    place = folder / FIELDS
    whole = place / f"{index:06d}.npz"
    parts = {0: whole} if whole.is_file() else _parts(place, index)
    if not parts:
        return {}
    starts = sorted(parts)
    pieces: list[Columns] = []
    for begin, end in zip(starts, [*starts[1:], count], strict=True):
        if begin < stop and end > first:
            part = _read(parts[begin], index, end - begin)
            cut = slice(max(first - begin, 0), min(stop, end) - begin)
            pieces.append({name: values[cut] for name, values in part.items()})
    if not pieces:
        return {}
    names = [name for name in pieces[0] if all(name in piece for piece in pieces)]
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in names}


def _parts(place: Path, index: int) -> dict[int, Path]:
    found = place.glob(f"{index:06d}.{'[0-9]' * 12}.npz")
    return {int(path.name.split(".")[1]): path for path in found}


def _read(path: Path, index: int, count: int) -> Columns:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            names = [str(name) for name in stored["names"]]
            found = {name: stored[f"field_{k}"] for k, name in enumerate(names)}
    except DAMAGE as error:
        raise DamagedError(f"frame {index}: expected its further fields: {error}") from None
    if any(values.shape != (count,) for values in found.values()):
        raise DamagedError(f"frame {index}: expected further fields of {count} points")
    return found


def read_source_header(folder: Path, index: int) -> bytes | None:
    """Return the header of a frame's source, or None."""
    path = folder / FIELDS / f"{index:06d}.header"
    return path.read_bytes() if path.is_file() else None


def read_rows(folder: Path, index: int, count: int) -> NDArray[np.int64] | None:
    """Return which row of the source each point (count,) was, or None where it is not known.

    Raises DamagedError for a file that is not whole.
    """
    path = folder / FIELDS / f"{index:06d}.rows.npz"
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            skipped = stored["skipped"]
    except FileNotFoundError:
        return None
    except DAMAGE as error:
        raise DamagedError(f"frame {index}: expected its rows: {error}") from None
    if skipped.shape != (count,):
        raise DamagedError(f"frame {index}: expected rows of {count} points")
    return np.cumsum(skipped.astype(np.int64) + 1) - 1
