"""How tall people are, which tells them apart where colours do not.

Before a known scene the top of somebody's head is as high above the ground in every frame, within
the bobbing of a walk, while nothing hides it and he neither bends nor sits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pointbrush.tracking.interface import I64
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.people.observation import Observation


@dataclass(eq=False)
class Stature:
    """The ``tops`` measured so far, in metres along the way up from any one place."""

    options: TrackerOptions
    tops: list[float] = field(default_factory=list)

    @property
    def known(self) -> bool:
        """Whether there were enough measurements."""
        return len(self.tops) >= self.options.stature.min_tops

    def likelihood(self, top: float) -> float:
        """Logarithm of the density of a measured top, over that of any within the range; 0 while
        the stature is not known."""
        options = self.options.stature
        if not self.known:
            return 0.0
        varies = options.sigma_m * math.sqrt(1 + 1 / len(self.tops))
        away = (top - float(np.median(self.tops))) / varies
        upright = math.exp(-0.5 * away**2) / (varies * math.sqrt(2 * math.pi))
        return math.log(
            (1 - options.bent_share) * upright * options.bent_range_m + options.bent_share
        )


def ratio(top: float | None, one: Stature, other: Stature) -> float:
    """Logarithm of how much likelier a top is one's than another's; 0 where none is seen."""
    return 0.0 if top is None else one.likelihood(top) - other.likelihood(top)


def top_of(sight: Observation, cells: I64, area: float) -> float | None:
    """Metres up to the top of the ``cells`` (C,) of somebody of whom an ``area`` showed at most;
    None where it is not seen that he ends there."""
    options = sight.options.stature
    mask = np.zeros(len(sight.owner), np.bool_)
    mask[cells] = True
    points = sight.cells.indices[mask[sight.cells.cell]]
    if not len(points):
        return None
    world = sight.view.xyz[points].astype(np.float64)
    height = world @ sight.up
    _, depth = sight.view.project(world[:: max(1, len(points) // options.sampled_points)])
    above = max(
        1,
        round(options.top_share * max(area, sight.area(cells)) / float(np.median(depth)) ** 2),
    )
    if above >= len(points):
        return None
    order = np.argpartition(height, len(points) - above)
    highest = order[len(points) - above :]
    middle = world[highest].mean(axis=0)
    at, away = sight.view.project(middle + np.outer(options.above_m, sight.up))
    free = (at >= 0) & (sight.view.depth[at] > away + options.behind_m)
    return float(height[highest].min()) if free.all() else None
