"""PCD (Point Cloud Library) 0.5 to 0.7: ascii, binary and binary_compressed.

Points with a NaN coordinate are missing pixels of an organised cloud and are left out.
"""

from __future__ import annotations

import logging
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.formats.geometry.poses import of_quaternion
from pointbrush.formats.options import Extras, ReadOptions, read_bytes, require_count
from pointbrush.formats.tables.columns import frame_from_columns, unpack_rgb
from pointbrush.formats.tables.names import VIEWPOINT
from pointbrush.formats.tables.numbers import parse_numbers
from pointbrush.formats.tables.table import Table
from pointbrush.frame import PointFrame

log = logging.getLogger(__name__)
Array = NDArray[Any]
KEYS = (
    *("VERSION", "FIELDS", "COLUMNS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT"),
    *("VIEWPOINT", "POINTS", "DATA"),
)
KINDS = {"F": "f", "U": "u", "I": "i"}
MAX_HEADER = 1 << 16
MAX_COUNT = 1 << 20
PADDING = "_"
"""Name of fields that PCL writes between others; of COUNT 0 they have no bytes."""
OBJECT = "object"
"""Instances of Hitachi's editor beside its ``label``: counted from 0, -1 for none."""
# liblzf packs at most 264 bytes into 3.
MAX_RATIO = 90
SAME = 1e-6
"""Greatest difference from the identity of a pose that counts as none, metres or of a matrix."""


@dataclass(frozen=True, slots=True)
class Field:
    """A field: ``count`` values of NumPy type ``kind``."""

    name: str
    kind: str
    count: int

    @property
    def is_read(self) -> bool:
        """Whether the field becomes a column: one value a point, not padding."""
        return self.count == 1 and self.name != PADDING


@dataclass(frozen=True, slots=True)
class Header:
    """Header before the data; ``size`` is its length in bytes."""

    fields: list[Field]
    width: int
    height: int
    points: int
    viewpoint: list[float]
    layout: str
    size: int

    @property
    def row(self) -> int:
        """Bytes of one point."""
        return sum(np.dtype(field.kind).itemsize * field.count for field in self.fields)


def read_pcd(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """One file as one frame; points with NaN coordinates are left out and counted.

    Raises BadInputError for a damaged or truncated file.
    """
    data = read_bytes(path)
    name = path.name
    header = parse_header(name, data)
    require_count(name, header.points, options.limits)
    body = data[header.size :]
    if header.layout == "ascii":
        columns = _ascii_columns(name, body, header)
    elif header.layout == "binary":
        columns = _binary_columns(name, body, header)
    else:
        columns = _compressed_columns(name, body, header)
    named = {n: c for n, c in columns.items() if n.lower() in ("rgb", "rgba") and c.ndim == 1}
    for field, values in named.items():
        columns[field] = unpack_rgb(values)
    if OBJECT in columns and "label" in columns:
        columns[OBJECT] = columns[OBJECT] + 1
    yield frame_from_columns(name, columns, options, missing=True, extras=_extras(header, options))


def _extras(header: Header, options: ReadOptions) -> Extras:
    """Return the place of the sensor, or the pose of the points if the user chose it.

    Programs differ: in PCL's algorithms VIEWPOINT is the sensor's place in the coordinates of the
    points (sensor_origin_); PCLVisualizer and CloudCompare's PcdFilter move the points by it.
    """
    values = np.array(header.viewpoint, np.float64)
    if not np.isfinite(values).all():
        return Extras()
    position, (w, *turn) = values[:3], values[3:] if values[3:].any() else (1.0, 0.0, 0.0, 0.0)
    pose = of_quaternion("VIEWPOINT", np.array([*position, *turn, w]))
    if options.chosen.poses == VIEWPOINT:
        return Extras(pose=pose, viewpoint=np.zeros(3))
    if not np.allclose(pose, np.eye(4), atol=SAME):
        log.warning(
            "the PCD files have a VIEWPOINT other than 0 0 0 1 0 0 0: it is used as the position "
            "of the sensor, and the points are not moved; poses 'viewpoint' moves the points by it"
        )
    # Writers without a viewpoint also write 0 0 0; in an organised cloud it is the camera.
    return Extras(viewpoint=position if header.height > 1 or position.any() else None)


def parse_header(name: str, data: bytes) -> Header:
    """Return the header; raise BadInputError naming the missing or wrong entry."""
    entries: dict[str, list[str]] = {}
    at = 0
    while "DATA" not in entries:
        end = data.find(b"\n", at, MAX_HEADER)
        if end < 0:
            raise BadInputError(
                f"{name}: expected a PCD header ending in a DATA line, "
                f"got {', '.join(entries) or 'none of its lines'}"
            )
        words = data[at:end].decode("latin-1").split()
        at = end + 1
        if not words or words[0].startswith("#"):
            continue
        if words[0].upper() not in KEYS:
            raise BadInputError(f"{name}: expected a PCD header line, got an unknown one")
        entries[words[0].upper()] = words[1:]
    layout = " ".join(entries["DATA"]).lower()
    if layout not in ("ascii", "binary", "binary_compressed"):
        raise BadInputError(
            f"{name}: expected DATA ascii, binary or binary_compressed, got another"
        )
    width = _whole(name, entries, "WIDTH")
    height = _whole(name, entries, "HEIGHT", 1)
    points = _whole(name, entries, "POINTS", width * height)
    if points != width * height:
        raise BadInputError(
            f"{name}: expected POINTS to be WIDTH x HEIGHT = {width * height}, got {points}"
        )
    try:
        viewpoint = [float(word) for word in entries.get("VIEWPOINT", ["0"] * 7)]
    except ValueError:
        viewpoint = []
    if len(viewpoint) != 7:
        raise BadInputError(
            f"{name}: expected VIEWPOINT with 7 numbers, got {len(entries['VIEWPOINT'])} words"
        )
    return Header(_fields(name, entries), width, height, points, viewpoint, layout, at)


def _whole(name: str, entries: dict[str, list[str]], key: str, default: int | None = None) -> int:
    words = entries.get(key)
    if words is None and default is not None:
        return default
    if not words or not (words[0].isascii() and words[0].isdigit()) or len(words[0]) > 18:
        raise BadInputError(f"{name}: expected {key} with a whole number, got another word")
    return int(words[0])


def _fields(name: str, entries: dict[str, list[str]]) -> list[Field]:
    names = entries.get("FIELDS", entries.get("COLUMNS", []))
    sizes = entries.get("SIZE", ["4"] * len(names))
    kinds = entries.get("TYPE", ["F"] * len(names))
    counts = entries.get("COUNT", ["1"] * len(names))
    if not names or {len(sizes), len(kinds), len(counts)} != {len(names)}:
        raise BadInputError(
            f"{name}: expected FIELDS, SIZE, TYPE and COUNT with one entry per field, got "
            f"{len(names)}, {len(sizes)}, {len(kinds)} and {len(counts)}"
        )
    fields = []
    for field, size, kind, count in zip(names, sizes, kinds, counts, strict=True):
        dtype = KINDS.get(kind.upper(), "?") + size
        if dtype not in ("f4", "f8", "u1", "u2", "u4", "u8", "i1", "i2", "i4", "i8"):
            raise BadInputError(
                f"{name}: expected field '{field}' as F 4, F 8 or U or I of 1, 2, 4 or 8 bytes, "
                f"got {kind} {size}"
            )
        if not (count.isascii() and count.isdigit()) or int(count[:18]) > MAX_COUNT:
            raise BadInputError(
                f"{name}: expected COUNT 0 to {MAX_COUNT} for '{field}', got {count[:40]}"
            )
        fields.append(Field(field, dtype, int(count)))
    return fields


def _ascii_columns(name: str, body: bytes, header: Header) -> dict[str, Array]:
    numbers = parse_numbers(name, body)
    width = sum(field.count for field in header.fields)
    if len(numbers) != header.points * width:
        raise BadInputError(
            f"{name}: expected {header.points} points of {width} values = "
            f"{header.points * width} numbers, got {len(numbers)}"
        )
    table = numbers.reshape(header.points, width)
    columns: dict[str, Array] = {}
    at = 0
    for field in header.fields:
        if field.is_read:
            columns[field.name] = _typed(field, table[:, at])
        at += field.count
    return columns


def _typed(field: Field, values: NDArray[np.float64]) -> Array:
    if field.kind[0] == "f":
        # Text may have more digits than the declared float; far from the origin they matter.
        far = field.kind == "f4" and len(values) and np.nanmax(np.abs(values), initial=0) > 4096
        packed = field.name.lower() in ("rgb", "rgba")
        with np.errstate(over="ignore"):
            return values if far and not packed else values.astype(field.kind)
    # A missing pixel may have "nan" even in a field of integers.
    return np.where(np.abs(values) < 2.0**63, values, 0).astype(np.int64)


def _binary_columns(name: str, body: bytes, header: Header) -> dict[str, Array]:
    needed = header.points * header.row
    if len(body) < needed:
        raise BadInputError(
            f"{name}: expected {header.points} points of {header.row} bytes = {needed} bytes, got "
            f"{len(body)}; the file is cut off"
        )
    kinds = [(f"f{i}", f"<{f.kind}", (f.count,)) for i, f in enumerate(header.fields)]
    rows = np.frombuffer(body, np.dtype(kinds), header.points)
    return {
        field.name: rows[f"f{i}"][:, 0] for i, field in enumerate(header.fields) if field.is_read
    }


def _compressed_columns(name: str, body: bytes, header: Header) -> dict[str, Array]:
    """Compressed data holds each field as one array, one after the other."""
    if header.points == 0:
        return {field.name: np.empty(0, field.kind) for field in header.fields if field.is_read}
    if len(body) < 8:
        raise BadInputError(f"{name}: expected compressed data, got {len(body)} bytes")
    packed, size = struct.unpack_from("<II", body)
    needed = header.points * header.row
    if size != needed:
        raise BadInputError(
            f"{name}: expected {header.points} points of {header.row} bytes = {needed} bytes, got "
            f"{size} according to the data"
        )
    if packed > len(body) - 8:
        raise BadInputError(
            f"{name}: expected {packed} bytes of compressed data, got {len(body) - 8}; the file "
            "is cut off"
        )
    if size > packed * MAX_RATIO:
        raise TooLargeError(f"{name}: expected at most {packed * MAX_RATIO} bytes, got {size}")
    from pointbrush.formats.readers.lzf import lzf_decompress

    raw = lzf_decompress(name, body[8 : 8 + packed], size)
    columns: dict[str, Array] = {}
    at = 0
    for field in header.fields:
        count = header.points * field.count
        if field.is_read:
            columns[field.name] = np.frombuffer(raw, f"<{field.kind}", count, at)
        at += count * np.dtype(field.kind).itemsize
    return columns


def write_pcd(out: BinaryIO, table: Table) -> None:
    """Write a table as a binary PCD 0.7."""
    types, blocks = table.rows()
    kinds = types.values()
    lines = [
        "# .PCD v0.7 - Point Cloud Data file format",
        "VERSION 0.7",
        f"FIELDS {' '.join(types)}",
        f"SIZE {' '.join(str(kind.itemsize) for kind in kinds)}",
        f"TYPE {' '.join(kind.kind.upper() for kind in kinds)}",
        f"COUNT {' '.join('1' for _ in kinds)}",
        *(f"WIDTH {table.count}", "HEIGHT 1", "VIEWPOINT 0 0 0 1 0 0 0", f"POINTS {table.count}"),
        *("DATA binary", ""),
    ]
    out.write("\n".join(lines).encode("ascii"))
    for rows in blocks:
        out.write(rows.tobytes())
