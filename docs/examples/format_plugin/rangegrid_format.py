"""Add a file format: range pictures of a spinning lidar, ``.rgrid``.

    pip install docs/examples/format_plugin
    pointbrush import scans/ --format rangegrid

A file contains ``RGRID``, the numbers of beams and columns as little-endian uint16, and
beams x columns float32 distances in metres; 0 is no echo. The beams point from 15 degrees down to
15 degrees up, the columns cover one turn.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.formats import Format, ReadOptions
from pointbrush.formats.options import require_count
from pointbrush.frame import PointFrame

MAGIC = b"RGRID"
HEADER = struct.Struct("<5sHH")
TILT = np.radians(15)


def read_rangegrid(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """Yield the frame of a file; raises BadInputError if the file is incomplete."""
    data = path.read_bytes()
    if len(data) < HEADER.size or not data.startswith(MAGIC):
        raise BadInputError(f"{path.name}: expected a file that begins with RGRID, got another")
    _, beams, columns = HEADER.unpack_from(data)
    require_count(path.name, beams * columns, options.limits)
    wanted = HEADER.size + 4 * beams * columns
    if len(data) != wanted:
        raise BadInputError(f"{path.name}: expected {wanted} bytes, got {len(data)}")
    metres = np.frombuffer(data, "<f4", offset=HEADER.size).reshape(beams, columns)
    up = np.linspace(-TILT, TILT, beams)[:, None]
    turn = np.linspace(0, 2 * np.pi, columns, endpoint=False)[None, :]
    way = np.stack(
        np.broadcast_arrays(np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up)), -1
    )
    echo = metres > 0
    xyz = (way * metres[..., None])[echo].astype(np.float32)
    yield PointFrame(xyz=xyz, viewpoint=np.zeros(3), dropped=int((~echo).sum()))


RANGEGRID = Format("rangegrid", (".rgrid",), read_rangegrid, "range pictures", (MAGIC,))
