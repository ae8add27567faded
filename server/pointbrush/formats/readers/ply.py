"""PLY (Turk 1994): ascii and both binary layouts, any property names and order.

The vertices become the points; faces and other elements are skipped.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.options import ReadOptions, read_bytes, require_count
from pointbrush.formats.tables.columns import frame_from_columns
from pointbrush.formats.tables.numbers import parse_numbers
from pointbrush.formats.tables.table import Columns, Table, free_name, plain_name
from pointbrush.frame import PointFrame

Array = NDArray[Any]

TYPES = {
    **{"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "bool": "u1"},
    **{"short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2"},
    **{"int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4"},
    **{"int64": "i8", "uint64": "u8", "long": "i8", "ulong": "u8"},
    **{"float": "f4", "float32": "f4", "double": "f8", "float64": "f8"},
}
NAMES = {
    **{"i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint"},
    **{"f4": "float", "f8": "double"},
}
ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
MAX_HEADER = 1 << 20
MAX_NAME = 200


@dataclass(frozen=True, slots=True)
class Property:
    """A scalar property; with ``count_kind``, a list of them preceded by its length."""

    name: str
    kind: str
    count_kind: str | None = None


@dataclass(frozen=True, slots=True)
class Element:
    """An element: ``count`` rows of properties."""

    name: str
    count: int
    properties: list[Property]

    @property
    def has_lists(self) -> bool:
        """Whether rows have variable lengths."""
        return any(p.count_kind for p in self.properties)

    def least_row(self) -> int:
        """Bytes of a row with empty lists."""
        return sum(np.dtype(p.count_kind or p.kind).itemsize for p in self.properties)


@dataclass(frozen=True, slots=True)
class Header:
    """Header up to ``end_header``; ``size`` is its length in bytes."""

    layout: str
    elements: list[Element]
    size: int


def read_ply(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """The vertices of one file as one frame.

    Raises BadInputError for anything that is not a whole PLY file with vertices x, y, z.
    """
    data = read_bytes(path)
    header = parse_header(path.name, data)
    position = next(
        (i for i, e in enumerate(header.elements) if e.name in ("vertex", "point")), None
    )
    if position is None:
        names = ", ".join(element.name for element in header.elements) or "none"
        raise BadInputError(f"{path.name}: expected an element 'vertex', got elements: {names}")
    element = header.elements[position]
    require_count(path.name, element.count, options.limits)
    before = header.elements[:position]
    if header.layout == "ascii":
        columns = _ascii_columns(path.name, data[header.size :], before, element)
    else:
        columns = _binary_columns(path.name, data, header, before, element)
    yield frame_from_columns(path.name, columns, options)


def parse_header(name: str, data: bytes) -> Header:
    """The header of a PLY file; raises BadInputError naming the line that is wrong."""
    if not data.startswith(b"ply"):
        raise BadInputError(f"{name}: expected a PLY file starting with 'ply', got other bytes")
    start = data.find(b"end_header", 0, MAX_HEADER)
    if start < 0:
        raise BadInputError(f"{name}: expected 'end_header', the file is cut off in its header")
    size = _line_end(data, start + len(b"end_header"))
    layout = ""
    elements: list[Element] = []
    for number, line in enumerate(data[:start].decode("latin-1").splitlines(), start=1):
        words = line.split()
        where = f"{name} line {number}"
        match words:
            case ["ply"] | ["comment" | "obj_info", *_] | []:
                pass
            case ["format", layout, "1.0"] if layout in ORDERS:
                pass
            case ["element", element, count] if count.isascii() and count.isdigit():
                elements.append(Element(element, int(count[:18]), []))
            case ["property", "list", count_kind, kind, prop] if elements:
                kinds = _kind(where, count_kind, count=True), _kind(where, kind)
                elements[-1].properties.append(Property(prop, kinds[1], kinds[0]))
            case ["property", kind, prop] if elements:
                elements[-1].properties.append(Property(prop, _kind(where, kind)))
            case _:
                raise BadInputError(f"{where}: expected a PLY header line, got another")
    if not layout:
        raise BadInputError(f"{name}: expected a line 'format ascii|binary_… 1.0', got none")
    # An element without properties takes no bytes, independent of its count.
    return Header(layout, [element for element in elements if element.properties], size)


def _line_end(data: bytes, at: int) -> int:
    """Number of the byte behind the line that ends at ``at``.

    Spaces may follow; then exactly one line end, as the first byte of data may look like one.
    """
    while data[at : at + 1] in (b" ", b"\t"):
        at += 1
    for line_end in (b"\r\n", b"\n", b"\r"):
        if data.startswith(line_end, at):
            return at + len(line_end)
    return at


def _kind(where: str, text: str, *, count: bool = False) -> str:
    if text not in TYPES or (count and TYPES[text][0] == "f"):
        known = ", ".join(TYPES)
        raise BadInputError(f"{where}: expected one of the types {known}, got another")
    return TYPES[text]


# ── binary ───────────────────────────────────────────────────────────────────────────────────


def _binary_columns(
    name: str, data: bytes, header: Header, before: list[Element], vertex: Element
) -> dict[str, Array]:
    order = ORDERS[header.layout]
    offset = header.size
    for element in before:
        offset = int(_row_starts(name, data, offset, element, order)[-1])
    _require_bytes(name, data, offset, vertex)
    if not vertex.has_lists:
        dtype = np.dtype([(f"f{i}", order + p.kind) for i, p in enumerate(vertex.properties)])
        rows = np.frombuffer(data, dtype, vertex.count, offset)
        return {p.name: rows[f"f{i}"] for i, p in enumerate(vertex.properties)}
    return _gathered_columns(name, data, offset, vertex, order)


def _require_bytes(name: str, data: bytes, offset: int, element: Element) -> None:
    needed = element.count * element.least_row()
    if offset + needed > len(data):
        raise BadInputError(
            f"{name}: expected {element.count} rows of '{element.name}' ({needed} bytes or more "
            f"from byte {offset}), got {max(len(data) - offset, 0)} bytes; the file is cut off"
        )


def _row_starts(
    name: str, data: bytes, offset: int, element: Element, order: str
) -> NDArray[np.int64]:
    """Byte offset of each row, and of the end, of an element."""
    _require_bytes(name, data, offset, element)
    if not element.has_lists:
        step = element.least_row()
        return offset + step * np.arange(element.count + 1, dtype=np.int64)
    byteorder = "big" if order == ">" else "little"
    starts = np.empty(element.count + 1, np.int64)
    for row in range(element.count):
        starts[row] = offset
        for prop in element.properties:
            size = np.dtype(prop.kind).itemsize
            if prop.count_kind:
                width = np.dtype(prop.count_kind).itemsize
                length = int.from_bytes(data[offset : offset + width], byteorder)  # type: ignore[arg-type]
                offset += width + length * size
            else:
                offset += size
        if offset > len(data):
            raise BadInputError(
                f"{name}: expected {element.count} rows of '{element.name}', the file is cut off "
                f"in row {row}"
            )
    starts[-1] = offset
    return starts


def _gathered_columns(
    name: str, data: bytes, offset: int, vertex: Element, order: str
) -> dict[str, Array]:
    """Scalar properties of rows of different lengths."""
    starts = _row_starts(name, data, offset, vertex, order)[:-1]
    raw = np.frombuffer(data, np.uint8)
    columns: dict[str, Array] = {}
    at = starts.copy()
    for prop in vertex.properties:
        size = np.dtype(prop.kind).itemsize
        width = np.dtype(prop.count_kind).itemsize if prop.count_kind else size
        kind = order + (prop.count_kind or prop.kind)
        values = raw[at[:, None] + np.arange(width)].view(kind).reshape(-1)
        at += width
        if prop.count_kind:
            at += values.astype(np.int64) * size
        else:
            columns[prop.name] = values.astype(prop.kind)
    return columns


# ── ascii ────────────────────────────────────────────────────────────────────────────────────


def _ascii_columns(
    name: str, text: bytes, before: list[Element], vertex: Element
) -> dict[str, Array]:
    numbers = parse_numbers(name, text)
    at = 0
    for element in before:
        at = int(_token_starts(name, numbers, at, element)[-1])
    starts = _token_starts(name, numbers, at, vertex)[:-1]
    columns: dict[str, Array] = {}
    for prop in vertex.properties:
        values = numbers[starts]
        starts = starts + 1
        if prop.count_kind:
            starts = starts + values.astype(np.int64)
        else:
            columns[prop.name] = _typed(name, prop, values)
    return columns


def _token_starts(
    name: str, numbers: NDArray[np.float64], at: int, element: Element
) -> NDArray[np.int64]:
    """Index of each row's first number, and of the end, of an element."""
    width = len(element.properties)
    enough = at + element.count * width <= len(numbers)
    if enough and not element.has_lists:
        return at + width * np.arange(element.count + 1, dtype=np.int64)
    starts = [at]
    for row in range(element.count if enough else 0):
        for prop in element.properties:
            if prop.count_kind and at < len(numbers):
                length = numbers[at]
                if not 0 <= length <= len(numbers):
                    raise BadInputError(
                        f"{name}: expected the length of a list in row {row} of "
                        f"'{element.name}', got {length:g}"
                    )
                at += int(length)
            at += 1
        starts.append(at)
    if not enough or at > len(numbers):
        raise BadInputError(
            f"{name}: expected {element.count} rows of '{element.name}' with {width} values, got "
            f"{len(numbers)} numbers in all; the file is cut off"
        )
    return np.array(starts, np.int64)


def _typed(name: str, prop: Property, values: NDArray[np.float64]) -> Array:
    kind = np.dtype(prop.kind)
    if kind.kind == "f":
        # Text may have more digits than the declared float; far from the origin they matter.
        far = len(values) and np.nanmax(np.abs(values), initial=0) > 4096
        return values if far else values.astype(kind)
    info = np.iinfo(kind)
    whole = np.isfinite(values) & (values == np.rint(values))
    bad = np.flatnonzero(~(whole & (values >= info.min) & (values <= info.max)))
    if bad.size:
        raise BadInputError(
            f"{name}: expected '{prop.name}' as {kind.name}, got {values[bad[0]]:g} at vertex "
            f"{bad[0]}"
        )
    return values.astype(kind)


def _as_ply(columns: Columns) -> Columns:
    made: dict[str, Array] = {}
    taken: set[str] = set()
    for name, values in columns.items():
        called = free_name(plain_name(name, MAX_NAME), taken, MAX_NAME)
        taken.add(called.lower())
        made[called] = (
            values.astype(np.float64)
            if values.dtype.kind + str(values.dtype.itemsize) in ("i8", "u8")
            else values
        )
    return made


def write_ply(out: BinaryIO, table: Table) -> None:
    """Write a table as the vertices of a binary little-endian PLY.

    Names are in ASCII, and integers of 64 bits, which PLY does not have, are doubles.
    """
    types, blocks = Table(table.count, lambda: map(_as_ply, table.blocks())).rows()
    lines = ["ply", "format binary_little_endian 1.0"]
    lines.append(f"element vertex {table.count}")
    lines += [f"property {NAMES[kind.str[1:]]} {name}" for name, kind in types.items()]
    out.write("\n".join([*lines, "end_header", ""]).encode("ascii"))
    for rows in blocks:
        out.write(rows.tobytes())
