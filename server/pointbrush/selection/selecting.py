"""Selection of point numbers by a stroke, at once or incrementally while it is drawn.

Overlaid frames are treated as one cloud.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.selection.box import clipped
from pointbrush.selection.points import Alive, Points, PointSet
from pointbrush.selection.ray import first_hits
from pointbrush.selection.rigid import Matrix, inverse, transformed
from pointbrush.selection.shape import Parts, Selecting
from pointbrush.selection.stroke import Stroke

__all__ = ["Selector", "first_hits", "select", "select_parts"]

SWEPT = 64
"""Number of samples of a batch while a stroke is drawn."""


def select(points: Points, stroke: Stroke, alive: Alive | None = None) -> NDArray[np.int64]:
    """Return sorted unique numbers of the points that ``stroke`` (local coordinates) takes.

    ``alive``: marks points that rays can hit.  The label store applies the tool, locked labels and
    ``only_unlabeled``.  Raises BadInputError if a sampled shape has no samples.
    """
    parts = list(select_parts(points, stroke, alive))
    if len(parts) == 1:
        return parts[0]
    numbers = np.concatenate([np.empty(0, np.int64), *parts])
    return numbers if (np.diff(numbers) > 0).all() else np.unique(numbers)


def select_parts(
    points: Points, stroke: Stroke, alive: Alive | None = None
) -> Iterator[NDArray[np.int64]]:
    """Yield the numbers of ``select`` in sorted parts, to limit memory for whole scans."""
    shape = stroke.kind
    if shape.sampled and len(stroke.origins) == 0:
        raise BadInputError(f"samples: expected at least one for shape '{shape.name}', got none")
    taken = PointSet()
    for part in _taken(points, stroke, alive, taken):
        yield taken.add(part) if shape.fills else part


def _taken(points: Points, stroke: Stroke, alive: Alive | None, taken: PointSet) -> Parts:
    """Yield the points that the stroke's shape takes inside its clip box."""
    clip, met = stroke.clip, stroke.met
    meets = clipped(clip, points, alive)
    at = Selecting(points, stroke.values, stroke.origins, stroke.directions, met, meets, taken)
    for part in stroke.kind.take(at):
        yield part if clip is None else clip.of(points, part)


class Selector:
    """Incremental selection while a stroke is drawn, with samples in batches.

    The union of the batches equals ``select`` of the whole stroke.
    """

    def __init__(self, points: Points, brush: Stroke, alive: Alive | None = None) -> None:
        """``brush`` is the stroke without samples, in local coordinates."""
        self._points, self._brush, self._alive = points, brush, alive
        self._end = np.empty((0, 3))
        self.taken = PointSet()
        if not brush.kind.sampled:
            for part in select_parts(points, brush):
                self.taken.add(part)

    def add(self, samples: Stroke) -> Iterator[NDArray[np.int64]]:
        """Yield the newly touched numbers of a batch: the brush with new samples."""
        shape = self._brush.kind
        if not shape.sampled:
            return
        for start in range(0, len(samples.origins), SWEPT):
            batch = samples.run(slice(start, start + SWEPT))
            if shape.sweeps:
                batch = replace(batch, origins=np.concatenate([self._end, batch.origins]))
                self._end = batch.origins[-1:]
            for part in _taken(self._points, batch, self._alive, self.taken):
                yield self.taken.add(part)


@dataclass(frozen=True, eq=False)
class Layer:
    """Points displayed with one rigid transform: a frame, or a moving object in it.

    ``T_shown_layer`` (4, 4): from the points' local coordinates to the stroke's; ``touchable``:
    marks points that rays can hit; ``part``: marks the frame's points in the layer, None: all.
    """

    points: Points
    T_shown_layer: Matrix
    touchable: Alive
    part: Alive | None = None

    def meets(self, numbers: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Mark the stored ``numbers`` (n,) that rays can hit."""
        met = self.touchable(numbers)
        return met if self.part is None else met & self.part(numbers)

    def own(self, numbers: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the stored ``numbers`` (n,) of points in the layer."""
        return numbers if self.part is None else numbers[self.part(numbers)]


class OverlaySelector:
    """``Selector`` for several layers: a ray hits the first surface of all layers."""

    def __init__(self, layers: Sequence[Layer], brush: Stroke) -> None:
        """``brush`` is the stroke without samples, in displayed coordinates."""
        self._layers = layers
        self._brush = brush
        self._T = [inverse(layer.T_shown_layer) for layer in layers]
        self._selectors = [
            Selector(layer.points, brush.placed(T), layer.meets)
            for layer, T in zip(layers, self._T, strict=True)
        ]

    def begun(self) -> Iterator[tuple[int, NDArray[np.int64]]]:
        """Yield each layer's number and the points that the parameters alone take."""
        for k, selector in enumerate(self._selectors):
            for numbers in selector.taken.parts():
                yield k, self._layers[k].own(numbers)

    def add(self, samples: Stroke) -> Iterator[tuple[int, NDArray[np.int64]]]:
        """Yield layers' numbers and newly touched points of new samples."""
        for start in range(0, len(samples.origins), SWEPT):
            batch = samples.run(slice(start, start + SWEPT))
            if len(self._layers) > 1 and self._brush.kind.meets(self._brush.values):
                batch = replace(batch, met=self._met(batch))
            for k, (selector, T) in enumerate(zip(self._selectors, self._T, strict=True)):
                for fresh in selector.add(batch.placed(T)):
                    yield k, self._layers[k].own(fresh)

    def _met(self, batch: Stroke) -> NDArray[np.float64]:
        """Return the first hits (S, 3) of rays on the surfaces of all layers; NaN: none."""
        nearest = np.full(len(batch.origins), np.inf)
        hits = np.full((len(batch.origins), 3), np.nan)
        for layer, T in zip(self._layers, self._T, strict=True):
            there = batch.placed(T)
            meets = clipped(there.clip, layer.points, layer.meets)
            found = first_hits(layer.points, there.origins, there.directions, batch.radius, meets)
            found = transformed(layer.T_shown_layer, found)
            along = np.einsum("ij,ij->i", found - batch.origins, batch.directions)
            nearer = along < nearest  # not where NaN
            nearest[nearer], hits[nearer] = along[nearer], found[nearer]
        return hits
