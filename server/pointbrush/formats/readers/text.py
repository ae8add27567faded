"""Points as text: XYZ, TXT, ASC, PTS and CSV; with or without a header, any usual separator.

Without a header the columns are x y z, then by number and content: intensity; red green blue;
or intensity red green blue (PTS).
"""

from __future__ import annotations

import csv
import io
import logging
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.options import ReadOptions, read_bytes, require_count
from pointbrush.formats.readers.unnamed import plain_columns
from pointbrush.formats.tables.column_roles import roles, unit_of
from pointbrush.formats.tables.columns import frame_from_columns
from pointbrush.formats.tables.corrections import Corrections, meanings
from pointbrush.formats.tables.numbers import is_number, parse_numbers
from pointbrush.formats.tables.table import Table
from pointbrush.frame import PointFrame

Array = NDArray[Any]
MAX_COLUMNS = 1024
LONG = 1 << 18
"""Bytes of a text from which on it is read with pyarrow."""
HEAD = 1 << 16
"""Bytes from which the layout of lines is inferred."""
SAMPLE = 50
"""Rows that are checked for decimal commas."""
FRAMES = ("frame", "frame_id", "frame_index", "frame_number", "frame_no", "frameid")
"""Names of columns that number the frames of a table."""
LEAST_POINTS = 2
"""Least mean number of points of a frame for a column of frame numbers."""
ECHO_START = "header:"
ECHOED = "messages as 'rostopic echo' prints them; import their bag, or a table of their points"
EXACT = 2.0**53
"""Whole numbers from which on float64 rounds."""
log = logging.getLogger(__name__)
METRES = {"mm": 0.001, "cm": 0.01, "dm": 0.1, "km": 1000.0, "ft": 0.3048, "in": 0.0254}
"""Metres of units in headers."""
_EXCEL = re.compile(r"\"?sep=.\"?", re.IGNORECASE)
"""First line with which a spreadsheet states the separator."""
_COMMA = re.compile(r"[-+]?\d+,\d+(?:[eE][-+]?\d+)?", re.ASCII)
_QUOTED = re.compile(rf'"\s*{_COMMA.pattern}\s*"', re.ASCII)
_CSV_ROWS = 65536


def read_text(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """Read a file as one frame, or as several by a column of frames; coordinates are float64.

    Raises BadInputError naming the line for words that are not numbers, rows of different
    lengths, fewer than three columns, or a wrong count line (PTS).
    """
    data = read_bytes(path)
    name = path.name
    is_pts = path.suffix.lower() == ".pts"
    plain = len(data) > LONG and not is_pts
    known = _read_at_once(name, data, options) if plain else None
    if known is not None:
        yield from _by_frame(name, known, options)
        return
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
        if line
        and not line.isspace()
        and not (commented and _is_comment(line))
        and not (i == 0 and _EXCEL.fullmatch(line))
    ]
    if not numbers:
        raise BadInputError(f"{name}: expected lines of numbers, got none")
    layout = _layout(name, lines, numbers, options.chosen)
    require_count(name, len(layout.rows), options.limits)
    columns = _columns(name, lines, layout, options, is_pts=is_pts)
    yield from _by_frame(name, columns, options)


def _by_frame(
    name: str, columns: Mapping[str, Array], options: ReadOptions
) -> Iterator[PointFrame]:
    """Yield the frames of a table, in the order of their numbers."""
    named = (columns[column] for column in columns if column.strip().lower() in FRAMES)
    values = next(named, np.empty(0))
    numbers = np.unique(values)
    if not 1 < len(numbers) <= len(values) / LEAST_POINTS or np.any(numbers % 1):
        yield frame_from_columns(name, columns, options)
        return
    order = np.argsort(values, kind="stable")
    for rows in np.split(order, np.searchsorted(values[order], numbers[1:])):
        part = {column: each[rows] for column, each in columns.items()}
        yield frame_from_columns(name, part, options)


def _read_at_once(name: str, data: bytes, options: ReadOptions) -> dict[str, Array] | None:
    """Columns of a plain table of numbers, read in all cores by pyarrow; None for any other text.

    Other or invalid texts are left to the slow reader, which reports errors by line.
    """
    head = data[: data.rfind(b"\n", 0, HEAD) + 1]
    if not head.isascii() or any(mark in data for mark in (b'"', b"#", b"//")):
        return None
    lines = head.decode("ascii").splitlines()
    numbers = [i for i, line in enumerate(lines) if line and not line.isspace()]
    try:
        layout = _layout(name, lines, numbers, options.chosen)
    except BadInputError:
        return None
    if layout.separator is None or not layout.rows:
        return None
    width = len(_words(lines[layout.rows[0]], layout.separator))
    names = layout.header or [str(i) for i in range(width)]
    if len(names) != width or len(set(names)) != width or not 3 <= width <= MAX_COLUMNS:
        return None
    table = _parsed_by_arrow(data, layout, names)
    if table is None:
        return None
    require_count(name, table.num_rows, options.limits)
    columns = {column: table[column].to_numpy() for column in names}
    if layout.header is not None:
        beyond = any(np.any(np.abs(values) >= EXACT) for values in columns.values())
        return None if beyond else columns  # whole numbers that float64 rounds
    table_of = np.stack(list(columns.values()), axis=1)
    return plain_columns(name, table_of, options, intensity_first=False)


def _parsed_by_arrow(data: bytes, layout: Layout, names: list[str]) -> Any:
    import pyarrow as pa
    from pyarrow import csv as arrow

    try:
        return arrow.read_csv(
            pa.BufferReader(data),
            arrow.ReadOptions(skip_rows=layout.rows[0], column_names=names),
            arrow.ParseOptions(delimiter=layout.separator),
            arrow.ConvertOptions(
                column_types=dict.fromkeys(names, pa.float64()),
                null_values=[],
                decimal_point="," if layout.decimal_comma else ".",
            ),
        )
    except (pa.ArrowException, ValueError):
        return None


@dataclass(frozen=True, slots=True)
class Layout:
    """Lines that hold points: ``rows`` are their numbers; ``header`` names the columns, if any."""

    separator: str | None
    decimal_comma: bool
    header: list[str] | None
    rows: list[int]


def _layout(name: str, lines: list[str], numbers: list[int], chosen: Corrections) -> Layout:
    """Infer header, count line (PTS), separator and decimal comma from the first lines.

    ``chosen`` takes precedence over them.
    """
    header: list[str] | None = None
    counted: list[int] = []
    left = numbers
    separator: str | None = None
    while left:
        line = lines[left[0]]
        separator = chosen.separator if chosen.delimiter else _separator(line)
        words = _words(line, separator)
        if _is_count(line) and not counted:
            counted = left[:1]
        elif header is None and _is_header(words):
            header = _header(line, separator)
        else:
            break
        left = left[1:]
    if counted:
        left = _rows_of_scans(name, lines, counted + left)
    named = bool(chosen.columns) or header is None or {"x", "y", "z"} <= set(roles(header))
    if not named:
        raise BadInputError(
            f"{name}: expected numbers, or a header with x, y and z, got "
            + (ECHOED if header == [ECHO_START] else "a first line of other words")
        )
    _name_units(header or (), chosen)
    comma = chosen.decimal_comma
    if comma is None:
        comma = _has_decimal_commas(lines, left, separator)
    return Layout(separator, comma, header, left)


def _header(line: str, separator: str | None) -> list[str]:
    """Return the names of columns; with spaces as separator, a unit stays with its name."""
    words = _words(line if separator else re.sub(r"\s+(?=[\[(])", "", line), separator)
    return [word.strip().strip("\"'") for word in words]


def _name_units(header: Sequence[str], chosen: Corrections) -> None:
    """Warn of coordinates with a unit other than metres in the header."""
    found = roles(header)
    units = {unit_of(found[axis]) for axis in "xyz" if axis in found} & METRES.keys()
    for unit in units if chosen.scale == 1.0 else ():
        log.warning(
            "the header gives coordinates in %s: scale %g makes them metres", unit, METRES[unit]
        )


def _has_decimal_commas(lines: list[str], rows: list[int], separator: str | None) -> bool:
    """Whether values have decimal commas, by the first rows with a comma in a value."""
    if separator == ",":  # then values with decimal commas are in quotes
        return any(_QUOTED.search(lines[row]) for row in rows if '"' in lines[row])
    sample = islice((lines[row] for row in rows if "," in lines[row]), SAMPLE)
    table = csv.reader(sample, delimiter=separator or " ")
    return any(_COMMA.fullmatch(word.strip()) for words in table for word in words)


def _is_count(line: str) -> bool:
    """Return whether a line is a number of points (PTS)."""
    word = line.strip()
    return word.isascii() and word.isdigit()


def _rows_of_scans(name: str, lines: list[str], left: list[int]) -> list[int]:
    """Return the rows of consecutive scans, each after a line with its count.

    Raises BadInputError for a scan with another number of points than its count.
    """
    starts = [i for i, row in enumerate(left) if _is_count(lines[row])]
    rows: list[int] = []
    for start, end in zip(starts, [*starts[1:], len(left)], strict=True):
        claimed, scan = int(lines[left[start]].strip()[:18]), left[start + 1 : end]
        if claimed != len(scan):
            raise BadInputError(
                f"{name}: expected {claimed} points as line {left[start] + 1} says, got {len(scan)}"
            )
        rows += scan
    return rows


def _separator(line: str) -> str | None:
    """Separator of the values of a line; None: spaces."""
    for separator in (";", "\t"):
        if separator in line:
            return separator
    if "," not in line:
        return None
    # 1,5 2,25 3,125: decimal commas, separated by spaces.
    words = line.split()
    decimal = [_COMMA.fullmatch(word) is not None or is_number(word) for word in words[:3]]
    return None if len(words) >= 3 and all(decimal) else ","


def _is_header(words: list[str]) -> bool:
    """Whether a line names columns: a row has numbers in its first three."""
    return not all(_is_value(word) for word in words[:3]) and not all(
        _is_value(word) for word in words
    )


def _is_value(word: str) -> bool:
    return is_number(word) or _COMMA.fullmatch(word) is not None


def _is_comment(line: str) -> bool:
    stripped = line.strip()
    return stripped.startswith(("#", "//")) and not _is_header_comment(stripped)


def _is_header_comment(line: str) -> bool:
    """``//X,Y,Z,R,G,B`` (CloudCompare) and ``# x y z`` name the columns."""
    words = line.lstrip("#/ ").replace(",", " ").replace(";", " ").split()
    return {"x", "y", "z"} <= set(roles(words)) and not any(is_number(word) for word in words)


def _words(line: str, separator: str | None) -> list[str]:
    bare = line.strip().lstrip("#/").strip() if line.strip().startswith(("#", "//")) else line
    return [word.strip() for word in bare.strip().split(separator)]


def _columns(
    name: str, lines: list[str], layout: Layout, options: ReadOptions, *, is_pts: bool
) -> Mapping[str, Array]:
    rows, header = layout.rows, layout.header
    width = len(_words(lines[rows[0]], layout.separator)) if rows else 3
    if width > MAX_COLUMNS:
        raise BadInputError(f"{name}: expected at most {MAX_COLUMNS} columns, got {width}")
    if rows and header is not None and width != len(header) and not _quoted(lines, rows):
        raise BadInputError(
            f"{name}: expected {len(header)} values per line as the header says, got {width}"
        )
    table = _table(name, lines, layout, width)
    if header is None and width < 3:
        raise BadInputError(f"{name}: expected at least 3 columns (x y z), got {width}")
    if table is None:
        return _columns_with_words(name, lines, layout, options)
    if header is not None:
        return {
            column: _exact(table[:, i], _words_of(lines, layout, i))
            for i, column in enumerate(header)
            if i < width
        }
    return plain_columns(name, table, options, intensity_first=is_pts)


def _quoted(lines: list[str], rows: list[int]) -> bool:
    return any('"' in lines[row] for row in rows[:SAMPLE])


def _table(name: str, lines: list[str], layout: Layout, width: int) -> NDArray[np.float64] | None:
    """Return all values as numbers (N, width), or None if there may be columns of words."""
    rows, separator = layout.rows, layout.separator
    if not rows:
        return np.empty((0, 3))
    wanted = [lines[row] for row in rows]
    if {len(line.split(separator)) for line in wanted} != {width}:
        if _quoted(lines, rows):
            return None
        raise _complaint(name, lines, layout, width)
    body = "\n".join(wanted)
    if layout.decimal_comma:
        body = body.replace(",", ".")
    try:
        numbers = parse_numbers(name, body.replace(separator or "\n", " ").encode())
    except BadInputError:
        return None
    return numbers.reshape(len(rows), width) if numbers.size == len(rows) * width else None


def _table_of(name: str, lines: list[str], layout: Layout) -> list[list[str]]:
    """Return the words of each row; raise BadInputError for a row of another length."""
    separator = layout.separator or " "
    wanted = (lines[row] for row in layout.rows)
    table = list(csv.reader(wanted, delimiter=separator, skipinitialspace=True))
    width = len(table[0])
    for row, words in zip(layout.rows, table, strict=True):
        if len(words) != width:
            raise BadInputError(
                f"{name} line {row + 1}: expected {width} values as in line "
                f"{layout.rows[0] + 1}, got {len(words)}"
            )
    return table


def _columns_with_words(
    name: str, lines: list[str], layout: Layout, options: ReadOptions
) -> Mapping[str, Array]:
    """Return the columns of numbers only; names, dates and remarks are left out."""
    table = _table_of(name, lines, layout)
    width = len(table[0])
    names = layout.header or [str(i) for i in range(width)]
    if len(names) != width:
        raise BadInputError(
            f"{name}: expected {len(names)} values per line as the header says, got {width}"
        )
    meaning = meanings(names, options.chosen.columns or names, name)
    if layout.header is None and not options.chosen.columns:
        needed = {names[i] for i in range(3)}
    else:
        axes = roles(meaning.values())
        needed = {old for old, new in meaning.items() if new in {axes.get(a) for a in "xyz"}}
    columns: dict[str, Array] = {}
    left_out: list[str] = []
    label = roles(meaning.values()).get("label")
    for column, called in zip(names, map(list, zip(*table, strict=True)), strict=True):
        values = _numbers(called, layout)
        if isinstance(values, int) and column in needed:
            where = f"{name} line {layout.rows[values] + 1}"
            raise BadInputError(f"{where}: expected a number, got another word")
        if isinstance(values, int) and meaning[column] == label and options.class_number:
            number = options.class_number
            of_name = {word: number(name, word) for word in dict.fromkeys(called)}
            values = np.array([of_name[word] for word in called], np.float64)
        if not isinstance(values, int):
            columns[column] = _exact(values, called)
            continue
        left_out.append(column)
        # A column of words keeps its place in the order of meanings that the user gave.
        if options.chosen.columns:
            columns[column] = np.full(len(table), np.nan)
    if left_out:
        log.warning("%s: columns of words are left out: %s", name, ", ".join(left_out))
    if layout.header is not None or options.chosen.columns:
        return columns
    table_of = np.stack(list(columns.values()), axis=1)
    return plain_columns(name, table_of, options, intensity_first=False)


def _words_of(lines: list[str], layout: Layout, column: int) -> Iterator[str]:
    return (_words(lines[row], layout.separator)[column] for row in layout.rows)


def _exact(values: NDArray[np.float64], words: Iterable[str]) -> Array:
    """Return numbers as int64 if they are whole and float64 would round them, else unchanged."""
    if not np.any(np.abs(values) >= EXACT):
        return values
    try:
        return np.array([int(word) for word in words], np.int64)
    except (ValueError, OverflowError):
        return values


def _numbers(words: list[str], layout: Layout) -> NDArray[np.float64] | int:
    """Return words as numbers, or the index of an invalid word; a missing value is NaN."""
    values = np.full(len(words), np.nan)
    known = False
    for i, word in enumerate(words):
        bare = word.strip()
        if not bare:
            continue
        if layout.decimal_comma:
            bare = bare.replace(",", ".")
        if not is_number(bare):
            return i
        values[i] = parse_numbers("", bare.encode())[0]
        known = True
    return values if known or not words else 0


def _complaint(name: str, lines: list[str], layout: Layout, width: int) -> BadInputError:
    for row in layout.rows:
        words = _words(lines[row], layout.separator)
        if len(words) != width:
            return BadInputError(
                f"{name} line {row + 1}: expected {width} values as in line "
                f"{layout.rows[0] + 1}, got {len(words)}"
            )
    return BadInputError(f"{name}: expected lines of {width} numbers")


def write_csv(out: BinaryIO, table: Table) -> None:
    """Write a table as CSV with a header; coordinates read back bit for bit."""
    types, blocks = table.opened()
    writer = io.TextIOWrapper(out, encoding="utf-8", newline="\n", write_through=True)
    csv.writer(writer, lineterminator="\n").writerow(types)
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
