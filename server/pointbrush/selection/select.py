"""From a stroke to point numbers, at once or sample by sample while it is drawn."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.selection.box import box
from pointbrush.selection.grow import grow
from pointbrush.selection.lasso import lasso
from pointbrush.selection.plane import plane
from pointbrush.selection.points import NOTHING, Points
from pointbrush.selection.pointset import PointSet
from pointbrush.selection.ray import Alive, first_hits, ray_balls, ray_tubes, runs
from pointbrush.selection.sphere import swept_ball, swept_parts
from pointbrush.selection.stroke import Stroke

__all__ = ["Selector", "first_hits", "select", "select_parts"]

SWEPT = 64
"""Samples that are worked on at once while a stroke is drawn: the work between two turns."""
REGIONS = {"grow": grow, "plane": plane}
"""Shapes that take a region round each place that a ray meets."""


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
    if stroke.lasso is not None:
        return lasso(points, stroke.lasso.polygon, stroke.lasso.matrix)
    if stroke.box is not None:
        return box(points, stroke.box.center, stroke.box.size, stroke.box.rotation)
    if len(stroke.origins) == 0:
        raise BadInputError(f"samples: expected at least one for shape '{stroke.shape}', got none")
    if stroke.shape == "sphere":
        return swept_parts(points, stroke.origins, stroke.radius)
    if stroke.shape in REGIONS:
        return _regions(points, stroke, alive, PointSet())
    if stroke.through:
        return ray_tubes(points, stroke.origins, stroke.directions, stroke.radius)
    return ray_balls(points, stroke.origins, stroke.directions, stroke.radius, alive)


class Selector:
    """The same selection while the stroke is being drawn: samples come in batches.

    The union of the batches equals ``select`` of the whole stroke.
    """

    def __init__(self, points: Points, brush: Stroke, alive: Alive | None = None) -> None:
        """``brush`` is the stroke without samples, in local coordinates."""
        self._points, self._brush, self._alive = points, brush, alive
        self._end = np.empty((0, 3))
        self.taken = PointSet()
        if brush.shape in ("lasso", "box"):
            for part in select_parts(points, brush):
                self.taken.add(part)

    def add(self, samples: Stroke) -> Iterator[NDArray[np.int64]]:
        """Take in a batch (the brush with new samples) while the newly touched numbers are read."""
        if self._brush.shape in ("lasso", "box") or len(samples.origins) == 0:
            return
        if self._brush.shape in REGIONS:
            yield from _regions(self._points, samples, self._alive, self.taken)
            return
        for start in range(0, len(samples.origins), SWEPT):
            run = slice(start, start + SWEPT)
            batch = replace(
                samples, origins=samples.origins[run], directions=samples.directions[run]
            )
            if self._brush.shape == "sphere":
                # The ball sweeps on from where the last batch ended.
                batch = replace(batch, origins=np.concatenate([self._end, batch.origins]))
                self._end = batch.origins[-1:]
            for part in select_parts(self._points, batch, self._alive):
                yield self.taken.add(part)


def _regions(
    points: Points, stroke: Stroke, alive: Alive | None, filled: PointSet
) -> Iterator[NDArray[np.int64]]:
    """Fill a region round each hit; yields what is new in ``filled``, often nothing."""
    for run in runs(len(stroke.origins)):
        rays = stroke.origins[run], stroke.directions[run]
        hits = first_hits(points, *rays, stroke.radius, alive)
        for hit in hits[np.isfinite(hits[:, 0])]:
            near = swept_ball(points, hit[None], stroke.radius)
            # Dragging over a region that is already filled must not fill it again.
            if len(near) and not filled.has_any(near):
                for part in REGIONS[stroke.shape](points, hit, stroke.radius, alive):
                    yield filled.add(part)
        yield NOTHING
