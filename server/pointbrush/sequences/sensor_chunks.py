"""A frame of several sensors → stored arrays and wire bytes, from its sensors' own."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.frame import FramePart, PointFrame, frame_of_part, to_frame
from pointbrush.sequences.columns import (
    Encoded,
    block_arrays,
    columns_of,
    encode_frame,
    residual,
    to_local,
)
from pointbrush.sequences.wire.chunk import SENSOR_CHUNK, Grid

FARTHEST = 16_384.0
"""Greatest coordinate, metres, of a point in its sensor's coordinates: float32 resolves 1 mm."""


@dataclass(frozen=True, slots=True, eq=False)
class _Piece:
    """An encoded chunk: its row, the numbers of its points in the frame, its bytes, and its bytes
    as a band of a depth image, or else as points again."""

    row: NDArray[Any]
    order: NDArray[np.int64]
    points: bytes
    best: bytes


def encode_sensors(frame: PointFrame, grid: Grid) -> Encoded:
    """Encode a frame of several sensors: chunks by level, then by sensor, each of one sensor.

    The wire's first part has all chunks as points.  Where a sensor has a depth image, the second
    part has all chunks again: those of the depth images as their bands, the others as points.
    """
    encoded = [_encode_part(frame, part, grid) for part in frame.parts]
    pieces = [
        piece
        for part, one in zip(frame.parts, encoded, strict=True)
        for piece in _pieces(frame, part, one)
    ]
    pieces.sort(key=lambda piece: int(piece.row["level"]))  # stable: then by sensor
    order = np.concatenate([np.empty(0, np.int64), *(piece.order for piece in pieces)])
    table = _table(pieces)
    arrays, local = _arrays(frame, order, table, grid)
    wire = [piece.points for piece in pieces]
    if table["depth"].any():
        best = [piece.best for piece in pieces]
        arrays["depth_ends"] = sum(map(len, wire)) + np.cumsum(
            [len(data) for data in best], dtype=np.int64
        )
        wire += best
    return Encoded(
        arrays,
        local,
        b"".join(wire),
        max((one.error for one in encoded), default=0.0),
        max((one.side_error for one in encoded), default=0.0),
        max((one.color_error for one in encoded), default=0.0),
    )


def _arrays(
    frame: PointFrame, order: NDArray[np.int64], table: NDArray[Any], grid: Grid
) -> tuple[dict[str, NDArray[Any]], NDArray[np.float32]]:
    """Return the stored arrays, and local coordinates (N, 3); fill in the bounds of ``table``."""
    own = (frame.xyz if frame.sensor_xyz is None else frame.sensor_xyz).take(order, axis=0)
    xyz = to_local(own, np.zeros(3))
    exact = residual(own, xyz, np.zeros(3))
    local = to_local(place_chunks(own, table, _mounts(frame), frame.xyz.dtype), grid.shift)
    blocks = block_arrays(local, np.append(table["first"], len(order)))
    if len(table):
        starts = blocks["block_of_chunk"][:-1]
        table["lo"] = np.minimum.reduceat(blocks["block_lo"], starts)
        table["hi"] = np.maximum.reduceat(blocks["block_hi"], starts)
    arrays: dict[str, NDArray[Any]] = {"xyz": xyz, "source_index": order.astype(np.uint32)}
    if exact is not None:
        arrays["residual"] = exact
    return arrays | {**columns_of(frame, order), "chunks": table, **blocks}, local


def _mounts(frame: PointFrame) -> NDArray[np.float64]:
    """Return the mounts (S, 4, 4) of all sensors; a sensor without a part has the identity."""
    mounts = np.tile(np.eye(4), (len(frame.sensors), 1, 1))
    for part in frame.parts:
        mounts[part.sensor] = part.T_frame_sensor
    return mounts


def _encode_part(frame: PointFrame, part: FramePart, grid: Grid) -> Encoded:
    own = frame_of_part(frame, part)
    if len(own) and float(np.abs(own.xyz).max()) > FARTHEST:
        raise BadInputError(
            f"sensor {frame.sensors[part.sensor].name}: expected points within {FARTHEST:,.0f} m "
            "of it, in its own coordinates"
        )
    lattice = grid.lattices[part.sensor] if grid.lattices else None
    alone = Grid(np.zeros(3), grid.step, grid.intensity_range, grid.coarsest, lattice)
    return encode_frame(own, alone)


def _pieces(frame: PointFrame, part: FramePart, encoded: Encoded) -> list[_Piece]:
    """Return the chunks of one sensor's encoded points."""
    table, ends = encoded.arrays["chunks"], encoded.arrays.get("depth_ends")
    begin = int(np.searchsorted(frame.sensor, part.sensor))  # type: ignore[arg-type]
    order = begin + encoded.arrays["source_index"].astype(np.int64)
    start = int(table["nbytes"].sum())
    bounds = [] if ends is None else [start, *ends.tolist()]
    bands = [encoded.wire[start:stop] for start, stop in pairwise(bounds)]
    pieces = []
    for chunk, row in enumerate(table):
        first, offset = int(row["first"]), int(row["offset"])
        points = encoded.wire[offset : offset + int(row["nbytes"])]
        numbers = order[first : first + int(row["count"])]
        marked = np.zeros((), SENSOR_CHUNK)
        for name in table.dtype.names or ():
            marked[name] = row[name]
        marked["sensor"], marked["depth"] = part.sensor, bool(bands)
        pieces.append(_Piece(marked, numbers, points, bands[chunk] if bands else points))
    return pieces


def _table(pieces: list[_Piece]) -> NDArray[Any]:
    """Return the chunk table of pieces in stored order."""
    table = np.array([piece.row for piece in pieces], SENSOR_CHUNK).reshape(-1)
    table["first"] = np.cumsum([0, *(len(piece.order) for piece in pieces)])[:-1]
    table["offset"] = np.cumsum([0, *(len(piece.points) for piece in pieces)])[:-1]
    return table


def sensors_of_chunks(chunks: NDArray[Any]) -> NDArray[np.uint8]:
    """Return each point's sensor (N,) in stored order by the chunk table."""
    sensor: NDArray[np.uint8] = np.repeat(chunks["sensor"], chunks["count"])
    return sensor


def place_chunks(
    sensor_xyz: NDArray[Any],
    chunks: NDArray[Any],
    mounts: NDArray[np.float64],
    dtype: np.dtype[Any],
) -> NDArray[Any]:
    """Return points (N, 3) in the frame's coordinates by the mounts (S, 4, 4) of their sensors."""
    out = np.empty(sensor_xyz.shape, dtype)
    for first, count, sensor in chunks[["first", "count", "sensor"]].tolist():
        out[first : first + count] = to_frame(
            sensor_xyz[first : first + count], mounts[sensor], dtype
        )
    return out
