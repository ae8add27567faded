"""Values that the frames of a sequence share: shift, grid, lattice, range of intensities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.frame import FAR, PointFrame, frame_of_part
from pointbrush.sequences.columns import to_local
from pointbrush.sequences.depth.lattice import Lattice
from pointbrush.sequences.octree.order import MAX_POINTS
from pointbrush.sequences.octree.quantise import base_step, coarsest_step
from pointbrush.sequences.wire.chunk import Grid

_SAMPLE = 500_000
"""Intensities of which quantiles are taken, evenly from all."""


class GridChooser:
    """Chooses shift, grid, lattice and intensity range from the first frame that defines them.

    The lattice of each of several sensors is chosen from the first frame with points of it.
    """

    def __init__(self) -> None:
        self.grid = Grid(np.zeros(3), base_step(0.0), None)
        self._placed = False
        self._seen: set[int] = set()

    def __call__(self, frames: Sequence[PointFrame]) -> Grid:
        """The grid for ``frames``, one frame or parts of one."""
        filled = [frame for frame in frames if len(frame)]
        if not self._placed and filled:
            self._placed = True
            ends = np.array([_ends(frame.xyz) for frame in filled], np.float64)
            lo, hi = ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)
            extent = float((hi - lo).max())
            step, coarsest = base_step(extent), coarsest_step(extent)
            span = self.grid.intensity_range
            shift = choose_shift(lo, hi)
            self.grid = Grid(shift, step, span, coarsest, _lattice(filled, shift, step))
        known = [frame.intensity for frame in filled if frame.intensity is not None]
        if self.grid.intensity_range is None and known:
            span = intensity_range(np.concatenate(known))
            self.grid = replace(self.grid, intensity_range=span)
        for frame in filled:
            self._add_sensors(frame)
        return self.grid

    def _add_sensors(self, frame: PointFrame) -> None:
        """Find the lattices of the sensors that have points for the first time."""
        origin, lattices = np.zeros(3), list(self.grid.lattices or (None,) * len(frame.sensors))
        for part in frame.parts:
            if part.sensor not in self._seen and len(own := frame_of_part(frame, part)):
                self._seen.add(part.sensor)
                lattices[part.sensor] = _lattice([own], origin, self.grid.step)
                self.grid = replace(self.grid, lattices=tuple(lattices))


def _ends(xyz: NDArray[np.floating]) -> NDArray[np.floating]:
    """Least and greatest coordinates (2, 3), in the points' own precision."""
    # Axis by axis: numpy reduces rows of three several times slower.
    return np.array([[xyz[:, k].min() for k in range(3)], [xyz[:, k].max() for k in range(3)]])


def _lattice(
    frames: Sequence[PointFrame], shift: NDArray[np.float64], step: float
) -> Lattice | None:
    """Return the lattice of whole frames; a frame in parts is not of a depth camera."""
    if len(frames) != 1 or len(frames[0]) > MAX_POINTS or frames[0].sensors:
        return None
    # Imported here because it loads the tracker's sensors, which only an import needs.
    from pointbrush.sequences.depth.finding import find_lattice

    return find_lattice(frames[0], to_local(frames[0].xyz, shift), shift, step)


def choose_shift(lo: NDArray[np.float64], hi: NDArray[np.float64]) -> NDArray[np.float64]:
    """A round shift (3,) near the middle of the bounds when they are far out, else zeros."""
    if max(float(np.abs(lo).max()), float(np.abs(hi).max())) <= FAR:
        return np.zeros(3)
    middle = lo / 2 + hi / 2
    shift: NDArray[np.float64] = np.where(np.abs(middle) > FAR / 4, np.rint(middle / 100) * 100, 0)
    return shift + 0.0  # no negative zeros


def intensity_range(intensity: NDArray[np.float32]) -> tuple[float, float]:
    """Return the source values that stream as 0 and 255: a common unit's whole range if it fits."""
    finite = intensity[np.isfinite(intensity)]
    if len(finite) == 0:
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    if low >= 0 and high <= 1:
        return 0.0, 1.0
    if low >= 0 and high <= 255:
        return 0.0, 255.0
    # A few retro-reflectors must not make all other points black.
    sample = finite[:: max(len(finite) // _SAMPLE, 1)]
    low, high = (float(value) for value in np.quantile(sample.astype(np.float64), (0.001, 0.995)))
    return (low, high) if high > low else (low, low + 1.0)
