"""Points as text: XYZ, TXT, ASC, PTS and CSV; with or without a header, any usual separator.

Without a header the columns are x y z, then by number and content: intensity; red green blue;
or intensity red green blue (PTS).
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.columns import frame_from_columns, plain_columns, roles
from pointbrush.formats.numbers import parse_numbers
from pointbrush.formats.options import ReadOptions, read_bytes, require_count
from pointbrush.formats.table import Table
from pointbrush.frame import PointFrame

Array = NDArray[Any]
SEPARATORS = (",", ";", "\t")
MAX_COLUMNS = 1024
_CSV_ROWS = 65536


def read_text(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """One file as one frame, coordinates as float64.

    Raises BadInputError naming the line for words that are no numbers, rows of different
    lengths, fewer than three columns, or a count line (PTS) that does not agree.
    """
    data = read_bytes(path)
    name = path.name
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise BadInputError(
            f"{name}: expected text, got byte {data[error.start]:#04x} at {error.start}"
        ) from None
    lines = text.splitlines()
    commented = "#" in text or "//" in text
    numbers = [
        i
        for i, line in enumerate(lines)
        if line and not line.isspace() and not (commented and _is_comment(line))
    ]
    if not numbers:
        raise BadInputError(f"{name}: expected lines of numbers, got none")
    first = lines[numbers[0]]
    separator = next((s for s in SEPARATORS if s in first), None)
    header, claimed = None, None
    words = _words(first, separator)
    if len(words) == 1 and len(numbers) > 1 and words[0].isascii() and words[0].isdigit():
        claimed = int(words[0][:18])
        separator = next((s for s in SEPARATORS if s in lines[numbers[1]]), None)
    elif not all(_is_number(word) for word in words):
        header = [word.strip().strip("\"'") for word in words]
    rows = numbers[1:] if header is not None or claimed is not None else numbers
    require_count(name, len(rows), options.limits)
    if claimed is not None and claimed != len(rows):
        raise BadInputError(f"{name}: expected {claimed} points as line 1 says, got {len(rows)}")
    if header is not None and not {"x", "y", "z"} <= set(roles(header)):
        raise BadInputError(
            f"{name}: expected numbers, or a header with x, y and z, got other words"
        )
    table = _table(name, lines, rows, separator)
    columns = _named(name, table, header, is_pts=path.suffix.lower() == ".pts")
    yield frame_from_columns(name, columns, options)


def _is_comment(line: str) -> bool:
    stripped = line.strip()
    return stripped.startswith(("#", "//")) and not _is_header_comment(stripped)


def _is_header_comment(line: str) -> bool:
    """``//X,Y,Z,R,G,B`` (CloudCompare) and ``# x y z`` name the columns."""
    words = line.lstrip("#/ ").replace(",", " ").replace(";", " ").split()
    return {"x", "y", "z"} <= set(roles(words)) and not any(_is_number(word) for word in words)


def _words(line: str, separator: str | None) -> list[str]:
    bare = line.strip().lstrip("#/").strip() if line.strip().startswith(("#", "//")) else line
    return [word.strip() for word in bare.strip().split(separator)]


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _table(
    name: str, lines: list[str], rows: list[int], separator: str | None
) -> NDArray[np.float64]:
    if not rows:
        return np.empty((0, 3))
    width = len(_words(lines[rows[0]], separator))
    if width > MAX_COLUMNS:
        raise BadInputError(f"{name}: expected at most {MAX_COLUMNS} columns, got {width}")
    wanted = [lines[row] for row in rows]
    if {len(line.split(separator)) for line in wanted} != {width}:
        raise _complaint(name, lines, rows, separator, width)
    body = "\n".join(wanted)
    try:
        numbers = parse_numbers(name, body.replace(separator or "\n", " ").encode())
    except BadInputError:
        raise _complaint(name, lines, rows, separator, width) from None
    if numbers.size != len(rows) * width:
        raise _complaint(name, lines, rows, separator, width)
    return numbers.reshape(len(rows), width)


def _complaint(
    name: str, lines: list[str], rows: list[int], separator: str | None, width: int
) -> BadInputError:
    for row in rows:
        words = _words(lines[row], separator)
        if len(words) != width:
            return BadInputError(
                f"{name} line {row + 1}: expected {width} values as in line {rows[0] + 1}, got "
                f"{len(words)}"
            )
        for word in words:
            if not _is_number(word):
                return BadInputError(f"{name} line {row + 1}: expected a number, got another word")
    return BadInputError(f"{name}: expected lines of {width} numbers")


def _named(
    name: str, table: NDArray[np.float64], header: list[str] | None, *, is_pts: bool
) -> Mapping[str, Array]:
    width = table.shape[1]
    if header is not None:
        if len(table) and width != len(header):
            raise BadInputError(
                f"{name}: expected {len(header)} values per line as the header says, got {width}"
            )
        return {column: table[:, i] for i, column in enumerate(header) if i < width}
    if width < 3:
        raise BadInputError(f"{name}: expected at least 3 columns (x y z), got {width}")
    return plain_columns(table, intensity_first=is_pts)


def write_csv(out: BinaryIO, table: Table) -> None:
    """Write a table as CSV with a header; coordinates read back bit for bit."""
    types, blocks = table.opened()
    writer = io.TextIOWrapper(out, encoding="ascii", newline="\n", write_through=True)
    writer.write(",".join(types) + "\n")
    for columns in blocks:
        for first in range(0, len(next(iter(columns.values()))), _CSV_ROWS):
            texts = [_texts(values[first : first + _CSV_ROWS]) for values in columns.values()]
            writer.writelines(",".join(row) + "\n" for row in zip(*texts, strict=True))
    writer.detach()


def _texts(values: Array) -> list[str]:
    # str() of a NumPy scalar is the shortest text that reads back as the same number.
    if values.dtype.kind == "f":
        texts: list[str] = values.astype("U32").tolist()
        return texts
    return [str(value) for value in values.tolist()]
