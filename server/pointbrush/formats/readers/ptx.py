"""PTX (Leica Cyclone): consecutive scans with their poses, each a frame.

A scan is: columns, rows, the scanner's position and axes (four lines), a 4x4 transform of row
vectors (four lines), then x y z intensity [r g b] of every cell; 0 0 0 is a beam without an echo.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.formats.options import Extras, ReadOptions, require_count
from pointbrush.formats.tables.columns import frame_from_columns
from pointbrush.formats.tables.numbers import parse_numbers
from pointbrush.frame import PointFrame

HEADER = 10
"""Lines before the points of a scan."""
AT_ONCE = 65_536
"""Lines that are converted to numbers together."""
WIDTHS = (4, 7)


def read_ptx(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """The scans of a file in their own coordinates, with ``T_world_frame`` of their transform.

    Raises NotFoundError, BadInputError for other lines or a file that is cut off, TooLargeError.
    """
    try:
        with path.open("r", encoding="utf-8", errors="replace") as file:
            lines = (line.strip() for line in file)
            number = 0
            while True:
                first = next((line for line in lines if line), None)
                if first is None:
                    break
                yield _scan(f"{path.name} scan {number}", first, lines, options)
                number += 1
    except FileNotFoundError:
        raise NotFoundError(f"{path}: expected a file, it does not exist") from None
    if number == 0:
        raise BadInputError(f"{path.name}: expected scans, got an empty file")


def _scan(name: str, first: str, lines: Iterator[str], options: ReadOptions) -> PointFrame:
    header = [first, *(line for _, line in zip(range(HEADER - 1), lines, strict=False))]
    sizes = [line for line in header[:2] if line.isascii() and line.isdigit() and len(line) < 10]
    if len(header) < HEADER or len(sizes) < 2:
        raise BadInputError(f"{name}: expected columns, rows and eight lines of its place")
    count = int(header[0]) * int(header[1])
    require_count(name, count, options.limits)
    matrix = _numbers(name, header[6:10], 4)
    table = _points(name, lines, count)
    names = ("x", "y", "z", "intensity", "red", "green", "blue")
    columns = {column: table[:, i] for i, column in enumerate(names[: table.shape[1]])}
    extras = Extras(pose=matrix.T.copy(), viewpoint=np.zeros(3))
    return frame_from_columns(name, columns, options, missing=True, extras=extras)


def _points(name: str, lines: Iterator[str], count: int) -> NDArray[np.float64]:
    blocks: list[NDArray[np.float64]] = []
    left = count
    while left:
        part = [line for _, line in zip(range(min(left, AT_ONCE)), lines, strict=False)]
        if not part:
            raise BadInputError(f"{name}: expected {count} points, got {count - left}")
        width = len(part[0].split())
        if width not in WIDTHS or (blocks and blocks[0].shape[1] != width):
            raise BadInputError(f"{name}: expected x y z intensity [r g b], got {width} values")
        blocks.append(_numbers(name, part, width))
        left -= len(part)
    return np.concatenate(blocks) if blocks else np.empty((0, 4))


def _numbers(name: str, lines: list[str], width: int) -> NDArray[np.float64]:
    values = parse_numbers(name, "\n".join(lines).encode())
    if values.size != len(lines) * width:
        raise BadInputError(f"{name}: expected lines of {width} numbers, got others")
    return values.reshape(len(lines), width)
