"""One chunk's points → its bytes on the wire (``budget``) and its row of the chunk table."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences.depth.lattice import Lattice
from pointbrush.sequences.wire.budget import BUDGET, fit
from pointbrush.sequences.wire.codec import Bytes

CHUNK = np.dtype(
    [
        ("level", "<i4"),
        ("parent", "<i4"),
        ("first", "<i8"),
        ("count", "<i8"),
        ("offset", "<i8"),
        ("nbytes", "<i8"),
        ("origin", "<f8", 3),
        ("scale", "<f8", 3),
        ("lo", "<f4", 3),
        ("hi", "<f4", 3),
    ]
)
"""One row per chunk; ``parent`` is -1 except in an octree."""
SENSOR_CHUNK = np.dtype([*CHUNK.descr, ("sensor", "u1"), ("depth", "?")])
"""The same where there are several sensors: ``origin`` and ``scale`` give coordinates of the
chunk's sensor; ``depth``: the chunk is also a band of the depth image of its sensor."""


@dataclass(frozen=True, slots=True)
class Grid:
    """Values that all frames of a sequence share: shift, grid, lattice, range of intensities.

    A chunk's step is ``step`` or, to keep the budget, up to ``coarsest`` (none: ``step``); a chunk
    of noise may have a greater one.  ``lattice``: pixels that the frames' points lie on, or None;
    ``lattices``: that of each of several sensors, in the sensor's coordinates.
    """

    shift: NDArray[np.float64]
    step: float
    intensity_range: tuple[float, float] | None
    coarsest: float = 0.0
    lattice: Lattice | None = None
    lattices: tuple[Lattice | None, ...] = ()


def wire_colors(
    rgb: NDArray[np.uint8] | None,
    intensity: NDArray[np.float32] | None,
    span: tuple[float, float] | None,
    count: int,
) -> NDArray[np.uint8]:
    """Bytes (N, 4) r, g, b, intensity.  Where r, g, b are zero the page shows grey."""
    out = np.zeros((count, 4), np.uint8)
    if intensity is not None and span is not None:
        unit = (intensity.astype(np.float64) - span[0]) * (255.0 / (span[1] - span[0]))
        out[:, 3] = np.rint(np.clip(np.nan_to_num(unit), 0, 255)).astype(np.uint8)
    if rgb is not None:
        out[:, :3] = rgb
    return out


@dataclass(frozen=True, slots=True, eq=False)
class EncodedChunk:
    """Row of the chunk table (without its place), wire bytes and error of one chunk.

    ``order`` (N,) puts the chunk's points into the order of the bytes, None when they are in it.
    """

    row: NDArray[Any]
    data: bytes
    error: float
    order: NDArray[np.int64] | None


@dataclass(frozen=True, slots=True, eq=False)
class EncodedChunks:
    """Chunks one after another: their table (without levels and parents), bytes and error.

    ``order`` (N,) puts all points into the order of the bytes, None when they are in it.
    """

    table: NDArray[Any]
    wire: bytes
    error: float
    order: NDArray[np.int64] | None


def encode_chunks(
    xyz: NDArray[np.float32],
    colors: Bytes,
    first: NDArray[np.int64],
    grid: Grid,
    *,
    ordered: bool = False,
) -> EncodedChunks:
    """Encode the chunks ``first[c]:first[c + 1]`` of points (N, 3) as ``encode_chunk`` does."""
    table = np.zeros(len(first) - 1, CHUNK)
    parts: list[bytes] = []
    order: NDArray[np.int64] | None = None
    offset, error = 0, 0.0
    for number, (start, stop) in enumerate(pairwise(first.tolist())):
        spare = max(0.0, BUDGET * start - offset)
        chunk = encode_chunk(
            xyz[start:stop], colors[start:stop], grid, spare=spare, ordered=ordered
        )
        if chunk.order is not None:
            order = np.arange(len(xyz)) if order is None else order
            order[start:stop] = start + chunk.order
        table[number] = chunk.row
        table[number]["first"], table[number]["offset"] = start, offset
        parts.append(chunk.data)
        offset += len(chunk.data)
        error = max(error, chunk.error)
    return EncodedChunks(table, b"".join(parts), error, order)


def encode_chunk(
    xyz: NDArray[np.float32],
    colors: Bytes,
    grid: Grid,
    *,
    spare: float = 0.0,
    ordered: bool = False,
) -> EncodedChunk:
    """Encode points (N, 3), local metres along a curve through space, with colours (N, 4).

    ``spare``: bytes that chunks before it left of their budget.  ``ordered``: the points keep
    their order.
    """
    fitted = fit(xyz, colors, grid.step, grid.coarsest, spare=spare, ordered=ordered)
    quantised, data = fitted.quantised, fitted.data
    row = np.zeros((), CHUNK)
    row["parent"], row["count"], row["nbytes"] = -1, len(xyz), len(data)
    for name in ("origin", "scale", "lo", "hi"):
        row[name] = getattr(quantised, name)
    return EncodedChunk(row, data, quantised.error, fitted.order)
