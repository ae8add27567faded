"""Encoding of chunks in at most six bytes a point, with the least visible loss.

A chunk is encoded on the finest grid of its recording.  If that takes more, as for the sparse
points of a lidar, it reduces, as far as needed and in this order:

1. fineness of the grid, as far as the recording's sensor justifies (``quantise.coarsest_step``);
2. the order of its points inside blocks (``path``): only bytes are lost;
3. one or two low bits of its colours, a camera's noise: only in recordings of 1 (lidars).

A chunk that is still above the budget is mostly noise, random points with random colours, in which
further losses are not visible:

4. half of the fineness again, where that is 1/32 of the distance between neighbours or less;
5. in its place, colours of 5, 6 and 5 bits, two bytes for three;
6. and as much fineness as needed: no point of the tested chunks moves by more than 1/25 of that
   distance.

Levels of a frame are encoded in order: steps 4 to 6 may use the bytes that earlier levels left.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences.octree.quantise import Quantised, quantise
from pointbrush.sequences.wire.codec import Bytes
from pointbrush.sequences.wire.path import short_path
from pointbrush.sequences.wire.vertices import MOST_DROPPED, PACKED, are_related, encode, runs_of

BUDGET = 6.0
"""Bytes a point that a chunk does not exceed."""
FEW = 64
"""Chunks of fewer points have no budget: the fixed part of a stream is too large for them."""

_GAIN, _MOST_GAIN = 3 / 8, 1 / 2
"""Bytes a point that a grid of twice the step saves: one bit for each coordinate, and at most."""
_MANY = 16384
_MARGIN = 0.15
_SMALL_STEP = 1 / 32
"""Largest invisible grid step, as a share of the distance between neighbours."""


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A chunk's positions, its bytes, and the order (N,) of its points in them, if it changed."""

    quantised: Quantised
    data: bytes
    order: NDArray[np.int64] | None


class _Chunk:
    """One chunk and its best encoding so far."""

    def __init__(self, xyz: NDArray[np.float32], colors: Bytes, step: float):
        self.xyz, self.colors, self.step = xyz, colors, step
        self.related = are_related(colors)
        self.order: NDArray[np.int64] | None = None
        self.dropped = 0
        self.budget = BUDGET * len(xyz) if len(xyz) >= FEW else math.inf

    def encode(self) -> None:
        """Encode with the current losses."""
        self.quantised = quantise(self.xyz, self.step)
        self._write()

    def _write(self) -> None:
        self.data = encode(
            self.quantised, self.colors, self.order, related=self.related, dropped=self.dropped
        )

    @property
    def excess(self) -> float:
        """Bytes a point above the budget."""
        return (len(self.data) - self.budget) / max(len(self.xyz), 1)

    def coarsen(self, most: float) -> None:
        """Coarsen the grid up to ``most`` until the budget is kept."""
        while self.excess > 0 and self.step < most:
            self.step = _coarser(self.step, self.excess, most, _GAIN)
            self.encode()

    def shorten(self) -> None:
        """Order the points along a path that is short in positions and colours."""
        values = np.empty((7, len(self.xyz)), np.int32)
        values[:3], values[3:] = self.quantised.q.T, self.colors.T
        if self.related:
            values[3:6:2] -= values[4]
        self.order = short_path(values)
        self._write()

    def drop(self, bits: int) -> None:
        """Drop low bits of the colours."""
        self.dropped = bits
        self._write()

    def blur(self, most: float) -> None:
        """Coarsen a grid of noise up to ``most``, on a path that is short in space only."""
        while True:
            self.quantised = quantise(self.xyz, self.step)
            self.order = short_path(self.quantised.q.T.astype(np.int32))
            self._write()
            if self.excess <= 0 or self.step >= most:
                return
            self.step = _coarser(self.step, self.excess, most, _MOST_GAIN)


def fit(
    xyz: NDArray[np.float32],
    colors: Bytes,
    step: float,
    coarsest: float,
    *,
    spare: float = 0.0,
    ordered: bool = False,
) -> Fitted:
    """Encode points (N, 3), local metres in Morton order, with colours (N, 4), within the budget.

    The grid's step is ``step`` or, where the sensor justifies it, up to ``coarsest`` (metres).
    ``spare``: bytes left by chunks before it, so that it is treated as noise less often.
    ``ordered``: the points keep their order; a chunk that no coarser grid brings within the budget
    stays above it, as for a few depth cameras.
    """
    chunk = _Chunk(xyz, colors, step)
    if len(xyz) >= _MANY and step < coarsest:  # skip most of the steps that would fail
        excess = _forecast(xyz, colors, step, related=chunk.related) - BUDGET
        chunk.step = _coarser(step, excess, coarsest, _GAIN)
    chunk.encode()
    chunk.coarsen(coarsest)
    if ordered:
        return Fitted(chunk.quantised, chunk.data, None)
    if chunk.excess > 0:
        chunk.shorten()
    colored = bool(colors[:, :3].any())
    for bits in range(1, MOST_DROPPED + 1):
        if chunk.excess > 0 and colored and coarsest > step:
            chunk.drop(bits)
    chunk.budget += spare
    if chunk.excess > 0:
        _blur(chunk, colored=colored)
    return Fitted(chunk.quantised, chunk.data, chunk.order)


def _blur(chunk: _Chunk, *, colored: bool) -> None:
    """Steps 4 to 6."""
    step, chunk.dropped = chunk.step, 0
    unseen = min(2 * step, _power(_SMALL_STEP * _spacing(chunk.xyz)))
    chunk.blur(max(step, unseen))
    if chunk.excess > 0 and colored:
        chunk.step, chunk.dropped = step, PACKED
    if chunk.excess > 0:
        chunk.blur(math.inf)


def _coarser(step: float, excess: float, most: float, gain: float) -> float:
    """The step that saves ``excess`` bytes a point, no coarser than ``most``."""
    doublings = max(0, math.ceil(excess / gain))
    return min(step * 2.0**doublings, most)


def _power(step: float) -> float:
    """The power of two not above ``step``."""
    return 2.0 ** math.floor(math.log2(step)) if step > 0 else 0.0


def _spacing(xyz: NDArray[np.float32]) -> float:
    """Estimate the distance from a point to the next along the curve, metres."""
    return float(np.median(np.linalg.norm(np.diff(xyz.astype(np.float64), axis=0), axis=1)))


def _forecast(xyz: NDArray[np.float32], colors: Bytes, step: float, *, related: bool) -> float:
    """Estimate the bytes a point of a chunk, or a little less, from some of its runs."""
    sample = runs_of(len(xyz)).ravel()
    data = encode(quantise(xyz[sample], step), colors[sample], related=related)
    return len(data) / len(sample) - _MARGIN
