"""One chunk's points → its bytes on the wire, within a budget.

A chunk is encoded on the finest grid of its recording.  Where that takes more than six bytes a
point, as between the far-apart points of a lidar, the grid is coarsened as far as the recording's
sensor justifies (``quantise.coarsest_step``); if that is not enough, the points are put on a
shorter way, and then colours lose their lowest bit, or two, which is a camera's noise: only in
recordings whose grid may be coarsened, those of lidars.
Vertices are 12 bytes: x, y, z uint16; r, g, b, intensity uint8; flags; a free byte.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences.codec import Bytes, encode_vertices
from pointbrush.sequences.path import short_path
from pointbrush.sequences.quantise import Quantised, quantise

WIRE_STRIDE = 12
BUDGET = 6.0
"""Bytes a point that a chunk should not exceed."""
RELATIVE = 1
"""Flag of a chunk's vertices: r and b are differences to g, modulo 256."""
DROPPED_SHIFT, MOST_DROPPED = 1, 2
"""Where the flags say how many low bits r, g and b have lost, and the most they may lose."""

_FLAGS = 10
_WORDS = 1
"""Four bytes of x and y are encoded as words; z shares its four with colours."""
_FEW = 512
"""With fewer points, what a stream needs anyway outweighs all that could be saved."""
_GAIN = 3 / 8
"""Bytes a point that a grid of twice the step saves: one bit for each coordinate."""
_MANY = 16384
_SAMPLE, _RUN = 32, 64
"""So many runs of so many points stand for a larger chunk."""
_MARGIN = 0.15

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
"""One row per chunk; ``parent`` is -1 but in an octree."""


@dataclass(frozen=True, slots=True)
class Grid:
    """What all frames of a sequence share: the shift, the grid, the intensities' range.

    A chunk's step is ``step`` or, to keep the budget, up to ``coarsest`` (none: ``step``).
    """

    shift: NDArray[np.float64]
    step: float
    intensity_range: tuple[float, float] | None
    coarsest: float = 0.0


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
    hurry: bool = False,
) -> EncodedChunks:
    """Encode the chunks ``first[c]:first[c + 1]`` of points (N, 3) as ``encode_chunk`` does."""
    table = np.zeros(len(first) - 1, CHUNK)
    parts: list[bytes] = []
    order: NDArray[np.int64] | None = None
    offset, error = 0, 0.0
    for number, (start, stop) in enumerate(pairwise(first.tolist())):
        chunk = encode_chunk(xyz[start:stop], colors[start:stop], grid, hurry=hurry)
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
    xyz: NDArray[np.float32], colors: Bytes, grid: Grid, *, hurry: bool = False
) -> EncodedChunk:
    """Encode points (N, 3), local metres in Morton order, with colours (N, 4).

    ``hurry``: look for a shorter way in little runs only, at a quarter of the time.
    """
    budget = BUDGET * len(xyz) if len(xyz) >= _FEW else math.inf
    related = _related(colors)
    step, order = grid.step, None
    if len(xyz) >= _MANY and step < grid.coarsest:  # most of what fails is not even tried
        step = _coarser(step, _forecast(xyz, colors, step, related=related) - BUDGET, grid)
    quantised = quantise(xyz, step)
    data = _encode(quantised, colors, related=related)
    while len(data) > budget and step < grid.coarsest:
        step = _coarser(step, (len(data) - budget) / len(xyz), grid)
        quantised = quantise(xyz, step)
        data = _encode(quantised, colors, related=related)
    if len(data) > budget:
        changing = colors.astype(np.int16)
        if related:
            changing[:, :3:2] -= changing[:, 1:2]
        values = np.concatenate([quantised.q.astype(np.int32), changing], axis=1)
        order = short_path(values, 8 if hurry else 2)
        data = _encode(quantised, colors, order, related=related)
    droppable = grid.coarsest > grid.step and bool(colors[:, :3].any())
    for dropped in range(1, MOST_DROPPED + 1):
        if droppable and len(data) > budget:
            data = _encode(quantised, colors, order, related=related, dropped=dropped)
    row = np.zeros((), CHUNK)
    row["parent"], row["count"], row["nbytes"] = -1, len(xyz), len(data)
    for name in ("origin", "scale", "lo", "hi"):
        row[name] = getattr(quantised, name)
    return EncodedChunk(row, data, quantised.error, order)


def _coarser(step: float, excess: float, grid: Grid) -> float:
    """The step that saves ``excess`` bytes a point, no coarser than the grid may become."""
    doublings = max(0, math.ceil(excess / _GAIN))
    return min(step * 2.0**doublings, grid.coarsest)


def _forecast(xyz: NDArray[np.float32], colors: Bytes, step: float, *, related: bool) -> float:
    """About the bytes a point that a chunk will take, or a little less, from some of its runs."""
    starts = np.arange(_SAMPLE) * (len(xyz) - _RUN) // _SAMPLE
    sample = (starts[:, None] + np.arange(_RUN)).ravel()
    data = _encode(quantise(xyz[sample], step), colors[sample], related=related)
    return len(data) / len(sample) - _MARGIN


def _encode(
    quantised: Quantised,
    colors: Bytes,
    order: NDArray[np.int64] | None = None,
    *,
    related: bool,
    dropped: int = 0,
) -> bytes:
    vertices = np.zeros((len(colors), WIRE_STRIDE), np.uint8)
    vertices[:, :6] = quantised.q.view(np.uint8).reshape(-1, 6)
    vertices[:, 6:_FLAGS] = colors
    vertices[:, _FLAGS] = dropped << DROPPED_SHIFT
    if dropped:
        # Black stands for no colour: what is nearly black must not become it.
        vertices[:, 6:9] = np.maximum(colors[:, :3] >> dropped, colors[:, :3] > 0)
    if related:
        vertices[:, 6] -= vertices[:, 7]
        vertices[:, 8] -= vertices[:, 7]
        vertices[:, _FLAGS] |= RELATIVE
    return encode_vertices(vertices if order is None else vertices[order], _WORDS)


def _related(colors: Bytes) -> bool:
    """Whether r and b of colours (N, 4) change less from point to point relative to g.

    Looks at runs all over the chunk; what counts is the bits of each change.
    """
    if len(colors) == 0:
        return False
    starts = np.arange(_SAMPLE) * max(len(colors) - _RUN, 0) // _SAMPLE
    at = np.minimum(starts[:, None] + np.arange(_RUN), len(colors) - 1)
    steps = np.diff(colors[at, :3], axis=1)  # modulo 256
    alone, green = steps[..., ::2], steps[..., 1:2]
    return _bits(alone - green) < _bits(alone)


def _bits(steps: Bytes) -> float:
    return float(np.log2(1.0 + np.abs(steps.view(np.int8).astype(np.float64))).sum())
