"""Shapes that take the region round each place that a ray meets."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.parameters import RADIUS
from pointbrush.selection.points import NOTHING, Points
from pointbrush.selection.ray import Alive, places_met, runs
from pointbrush.selection.shape import Parts, Selecting, Shape
from pointbrush.selection.sphere import swept_ball

Region = Callable[[Points, NDArray[np.float64], float, Alive | None], Parts]
"""Points, a place (3,) local metres, radius, alive → the numbers of the region round the place."""


def region_shape(name: str, about: str, region: Region) -> Shape:
    """Return the shape that takes such a region round each hit."""

    def take(at: Selecting) -> Parts:
        points, stroke, radius = at.points, at.stroke, at.stroke.radius
        for run in runs(len(stroke.origins)):
            hits = places_met(at, run)
            for hit in hits[np.isfinite(hits[:, 0])]:
                near = swept_ball(points, hit[None], radius)
                # Dragging over a region that is already filled must not fill it again.
                if len(near) and not at.taken.has_any(near):
                    yield from region(points, hit, radius, at.alive)
            yield NOTHING

    return Shape(name, about, (RADIUS,), take=take, fills=True, meets=lambda _values: True)
