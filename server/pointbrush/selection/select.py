"""From a stroke to point numbers, at once or sample by sample while it is drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.selection.box import box
from pointbrush.selection.grow import grow
from pointbrush.selection.lasso import lasso
from pointbrush.selection.plane import plane
from pointbrush.selection.points import Points
from pointbrush.selection.ray import Alive, first_hits, ray_balls, ray_tubes
from pointbrush.selection.sphere import swept_ball
from pointbrush.selection.stroke import Stroke

__all__ = ["Selector", "first_hits", "select"]

REGIONS = {"grow": grow, "plane": plane}
"""Shapes that take a region round each place that a ray meets."""


def select(points: Points, stroke: Stroke, alive: Alive | None = None) -> NDArray[np.int64]:
    """Stored numbers of the points that ``stroke`` (local coordinates) takes; sorted, unique.

    ``alive`` says which points rays can hit.  What the tool then does with the points, and the
    rules of locked labels and ``only_unlabeled``, are the label store's.
    Raises BadInputError when a sampled shape has no samples.
    """
    if stroke.lasso is not None:
        return lasso(points, stroke.lasso.polygon, stroke.lasso.matrix)
    if stroke.box is not None:
        return box(points, stroke.box.center, stroke.box.size, stroke.box.rotation)
    if len(stroke.origins) == 0:
        raise BadInputError(f"samples: expected at least one for shape '{stroke.shape}', got none")
    if stroke.shape == "sphere":
        return swept_ball(points, stroke.origins, stroke.radius)
    if stroke.shape in REGIONS:
        return _regions(points, stroke, alive)
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
        self._last: Stroke | None = None
        self.numbers: NDArray[np.int64] = np.empty(0, np.int64)
        if brush.shape in ("lasso", "box"):
            self.numbers = select(points, brush)

    def add(self, samples: Stroke) -> NDArray[np.int64]:
        """Take in a batch (the brush with new samples); returns the newly touched numbers."""
        if self._brush.shape in ("lasso", "box") or len(samples.origins) == 0:
            return np.empty(0, np.int64)
        batch = samples
        if self._last is not None and self._brush.shape == "sphere":
            # The ball sweeps on from where the last batch ended.
            batch = replace(
                samples, origins=np.concatenate([self._last.origins[-1:], samples.origins])
            )
        self._last = samples
        taken = select(self._points, batch, self._alive)
        fresh = np.setdiff1d(taken, self.numbers, assume_unique=True)
        self.numbers = np.union1d(self.numbers, fresh)
        return fresh


def _regions(points: Points, stroke: Stroke, alive: Alive | None) -> NDArray[np.int64]:
    region = np.empty(0, np.int64)
    hits = first_hits(points, stroke.origins, stroke.directions, stroke.radius, alive)
    for hit in hits[np.isfinite(hits[:, 0])]:
        near = swept_ball(points, hit[None], stroke.radius)
        # Dragging over a region that is already filled must not fill it again.
        if len(near) and not np.isin(near, region, assume_unique=True).any():
            fill = REGIONS[stroke.shape]
            region = np.union1d(region, fill(points, hit, stroke.radius, alive))
    return region
