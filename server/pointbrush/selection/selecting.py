"""From a stroke to point numbers, at once or sample by sample while it is drawn."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.selection.clip import clipped
from pointbrush.selection.points import Points
from pointbrush.selection.pointset import PointSet
from pointbrush.selection.ray import Alive, first_hits
from pointbrush.selection.shape import Parts, Selecting
from pointbrush.selection.stroke import Stroke

__all__ = ["Selector", "first_hits", "select", "select_parts"]

SWEPT = 64
"""Samples that are worked on at once while a stroke is drawn: the work between two turns."""


def select(points: Points, stroke: Stroke, alive: Alive | None = None) -> NDArray[np.int64]:
    """Stored numbers of the points that ``stroke`` (local coordinates) takes; sorted, unique.

    ``alive`` says which points rays can hit.  What the tool then does with the points, and the
    rules of locked labels and ``only_unlabeled``, are the label store's.
    Raises BadInputError when a sampled shape has no samples.
    """
    parts = list(select_parts(points, stroke, alive))
    if len(parts) == 1:
        return parts[0]
    numbers = np.concatenate([np.empty(0, np.int64), *parts])
    return numbers if (np.diff(numbers) > 0).all() else np.unique(numbers)


def select_parts(
    points: Points, stroke: Stroke, alive: Alive | None = None
) -> Iterator[NDArray[np.int64]]:
    """The same in parts, each sorted, so that a selection of a whole scan takes little memory."""
    shape = stroke.kind
    if shape.sampled and len(stroke.origins) == 0:
        raise BadInputError(f"samples: expected at least one for shape '{shape.name}', got none")
    taken = PointSet()
    for part in _taken(points, stroke, alive, taken):
        yield taken.add(part) if shape.fills else part


def _taken(points: Points, stroke: Stroke, alive: Alive | None, taken: PointSet) -> Parts:
    """Yield what the stroke's shape takes of the points that its clip box shows."""
    clip = stroke.clip
    for part in stroke.kind.take(Selecting(points, stroke, clipped(clip, points, alive), taken)):
        yield part if clip is None else clip.of(points, part)


class Selector:
    """The same selection while the stroke is being drawn: samples come in batches.

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
        """Take in a batch (the brush with new samples) while the newly touched numbers are read."""
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
