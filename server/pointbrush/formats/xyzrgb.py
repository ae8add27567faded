"""XYZRGB float records: six little-endian float32 per point, x y z r g b, and nothing else.

Colours are 0..1 or 0..255; a file where none exceeds 1 is taken as 0..1.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.formats.columns import frame_from_columns
from pointbrush.formats.options import ReadOptions, read_bytes, require_count
from pointbrush.frame import PointFrame

RECORD = 24


def read_xyzrgb(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """One file as one frame; raises BadInputError for a size that is not whole records."""
    data = read_bytes(path)
    if len(data) % RECORD:
        raise BadInputError(
            f"{path.name}: expected records of {RECORD} bytes (x y z r g b as float32), got "
            f"{len(data)} bytes, {len(data) % RECORD} more than {len(data) // RECORD} records"
        )
    require_count(path.name, len(data) // RECORD, options.limits)
    table = np.frombuffer(data, "<f4").reshape(-1, 6)
    names = ("x", "y", "z", "red", "green", "blue")
    columns = {name: table[:, i] for i, name in enumerate(names)}
    yield frame_from_columns(path.name, columns, options)
