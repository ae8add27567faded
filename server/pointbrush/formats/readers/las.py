"""LAS, LAZ and COPC: whole files as one frame, or by chunks for files larger than memory.

Coordinates are float64, the stored integers times scale plus offset.  Compressed points are
decoded in a child process (``laz_child.py``), since native decoders can crash on bad files.
"""

from __future__ import annotations

import base64
import logging
import os
import selectors
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.options import Limits, ReadOptions
from pointbrush.formats.readers.las_header import (
    COLORS,
    LasHeader,
    further_fields,
    read_header,
    read_records,
)
from pointbrush.formats.tables.column_roles import role_columns
from pointbrush.formats.tables.columns import frame_from_columns
from pointbrush.frame import PointFrame, Scaling

log = logging.getLogger(__name__)

Array = NDArray[Any]
OURS = ("label", "instance")
# Enough of a file to see whether its 16-bit colours go beyond 255.
SAMPLE_BLOCKS, SAMPLE_POINTS = 64, 4096
CHILD = Path(__file__).with_name("laz_child.py")


def read_las(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """One LAS, LAZ or COPC file as one frame.

    Extra dimensions ``label`` and ``instance`` are read as such; the classification is not.
    Raises BadInputError for a damaged or truncated file, TooLargeError beyond the limits.
    """
    header = read_header(path, options.limits)
    records = list(_records(path, header, max(header.count, 1), options))
    rows = records[0] if len(records) == 1 else np.concatenate([_empty(header), *records])
    yield _frame(path, header, rows, _eight_bit(rows, options), options, read_records(path, header))


def read_chunks(
    path: Path, points_per_chunk: int, options: ReadOptions | None = None
) -> Iterator[PointFrame]:
    """The points of a file in order, as frames of ``points_per_chunk`` (the last is smaller).

    Takes the memory of one chunk.  Raises as ``read_las``; ``read_header`` has count and bounds.
    """
    if points_per_chunk < 1:
        raise BadInputError(f"points_per_chunk: expected 1 or more, got {points_per_chunk}")
    options = options or ReadOptions()
    header = read_header(path, options.limits)
    eight_bit: bool | None = None
    records = read_records(path, header)
    for rows in _records(path, header, points_per_chunk, options):
        if eight_bit is None:
            eight_bit = _is_8_bit(rows if header.laszip else _sample(path, header))
        yield _frame(path, header, rows, eight_bit, options, records)


def _records(
    path: Path, header: LasHeader, chunk: int, options: ReadOptions
) -> Iterator[NDArray[Any]]:
    """Point records in blocks of ``chunk``; views of the file where it is not compressed."""
    if header.count == 0:
        log.warning("%s: the file is empty: its header says 0 points", path.name)
        yield _empty(header)
        return
    if header.laszip is None:
        rows = _mapped(path, header)
        for first in range(0, header.count, chunk):
            yield rows[first : first + chunk]
        return
    for block in decoded_records(path, header, chunk, options.limits):
        yield np.frombuffer(block, header.dtype)


def _mapped(path: Path, header: LasHeader) -> NDArray[Any]:
    return np.memmap(path, header.dtype, "r", header.offset, (header.count,))


def _empty(header: LasHeader) -> NDArray[Any]:
    return np.empty(0, header.dtype)


def _sample(path: Path, header: LasHeader) -> NDArray[Any]:
    rows = _mapped(path, header)
    starts = np.linspace(0, max(header.count - SAMPLE_POINTS, 0), SAMPLE_BLOCKS).astype(np.int64)
    return np.concatenate([rows[start : start + SAMPLE_POINTS] for start in np.unique(starts)])


def _is_8_bit(rows: NDArray[Any]) -> bool:
    """Return whether 16-bit colours have 8-bit values, as from many writers."""
    names = rows.dtype.names or ()
    return "red" in names and all(int(rows[c].max(initial=0)) <= 255 for c in COLORS)


def _eight_bit(rows: NDArray[Any], options: ReadOptions) -> bool:
    """Return whether colours have 8 bits in the whole recording; raise UndecidedColorsError."""
    if options.colors is None or "red" not in (rows.dtype.names or ()) or len(rows) == 0:
        return _is_8_bit(rows)
    return options.colors.whole_for(max(int(rows[c].max()) for c in COLORS)) == 255


def _frame(
    path: Path,
    header: LasHeader,
    rows: NDArray[Any],
    eight_bit: bool,
    options: ReadOptions,
    records: bytes,
) -> PointFrame:
    """One frame of point records; ``records`` is the file without its points."""
    xyz = np.empty((len(rows), 3))
    # An absurd scale gives infinities, which are refused later.
    with np.errstate(over="ignore", invalid="ignore"):
        for i, axis in enumerate("xyz"):
            xyz[:, i] = rows[axis] * header.scales[i] + header.offsets[i]
    columns: dict[str, Array] = {"xyz": xyz}
    columns["intensity"] = rows["intensity"]
    columns |= {extra: rows[extra] for extra in OURS if extra in header.extra}
    columns |= {
        field: values
        for field, values in further_fields(header, rows).items()
        if field.lower() not in OURS
    }
    scaled = header.scalings.keys() & role_columns(path.name, columns, options)
    stored = {field: columns[field] for field in scaled}
    columns |= {field: header.scalings[field].values(stored[field]) for field in scaled}
    if "red" in (rows.dtype.names or ()):
        columns["rgb"] = rgb = np.empty((len(rows), 3), np.uint8)
        for i, color in enumerate(COLORS):
            # 8 bits scaled by 256 or 257, as by some writers, give the original 8 bits.
            rgb[:, i] = np.minimum(rows[color], 255) if eight_bit else rows[color] >> 8
    scaling = Scaling(header.scales, header.offsets)
    frame = frame_from_columns(path.name, columns, options, zeros=True)
    kept = slice(None) if frame.rows is None else frame.rows
    whole = {field: values[kept] for field, values in stored.items() if field in frame.other}
    return replace(frame, other={**frame.other, **whole}, header=records, scaling=scaling)


def decoded_records(
    path: Path, header: LasHeader, chunk: int, limits: Limits
) -> Iterator[bytearray]:
    """The point records in blocks of ``chunk`` points, the last one smaller.

    Raises BadInputError when the decoder fails, crashes, stalls or ends early.
    """
    arguments = [
        *(sys.executable, "-I", str(CHILD), str(path.absolute())),
        *(str(header.offset), str(header.record), str(header.count)),
        base64.b64encode(header.laszip or b"").decode("ascii"),
        str(limits.native_memory),
    ]
    with (
        tempfile.TemporaryFile() as complaints,
        subprocess.Popen(
            arguments, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=complaints
        ) as child,
    ):
        try:
            left = header.count
            while left > 0:
                wanted = min(chunk, left) * header.record
                block = _receive(child, wanted, limits.native_stall_seconds)
                if len(block) < wanted:
                    child.wait(limits.native_stall_seconds)
                    complaints.seek(0)
                    lines = complaints.read(4096).decode("utf-8", "replace").strip().splitlines()
                    got = header.count - left + len(block) // header.record
                    why = lines[-1][:200] if lines else f"the decoder ended ({child.returncode})"
                    raise BadInputError(
                        f"{path.name}: expected {header.count} compressed points, got {got}: {why}"
                    )
                left -= min(chunk, left)
                yield block
        except subprocess.TimeoutExpired:
            raise BadInputError(f"{path.name}: the decoder of compressed points stalled") from None
        finally:
            child.kill()


def _receive(child: subprocess.Popen[bytes], size: int, stall: float) -> bytearray:
    """Return up to ``size`` bytes, fewer at the end; allocate only for received bytes."""
    assert child.stdout is not None  # noqa: S101
    descriptor = child.stdout.fileno()
    block = bytearray()
    # Not select(): that fails in a process with more than a thousand open files.
    with selectors.DefaultSelector() as selector:
        selector.register(descriptor, selectors.EVENT_READ)
        while len(block) < size:
            if not selector.select(stall):
                raise subprocess.TimeoutExpired(child.args, stall)
            received = os.read(descriptor, min(size - len(block), 1 << 20))
            if not received:
                break
            block += received
    return block
