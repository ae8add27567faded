"""How tall people are, which tells them apart where colours do not.

Before a known scene the top of somebody's head is as high above the ground in every frame, within
the bobbing of a walk, while nothing hides it and he neither bends nor sits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pointbrush.tracking.interface import I64
from pointbrush.tracking.people.observation import Observation

SAMPLE = 50
"""Points that tell how far away somebody is."""
TOP = 0.01
"""Share of the most that ever showed of somebody that lies above what is taken for his top."""
ABOVE, BEHIND = (0.12, 0.25), 0.15
"""Metres above his top where only what lies so far behind him may be seen, for it to be his."""
VARIES = 0.02
"""Metres by which a measured top varies: a walk, and noise."""
OTHERWISE, RANGE = 0.1, 1.0
"""Share of the frames in which somebody bends, sits or lifts an arm, and the metres over which his
top is then."""
FEWEST = 2
"""Measured tops from which a stature is known."""
DECISIVE = 3.0
"""Logarithm of a ratio of likelihoods (20 to 1) from which one of two is told."""


@dataclass(eq=False)
class Stature:
    """The ``tops`` measured so far, in metres along the way up from any one place."""

    tops: list[float] = field(default_factory=list)

    @property
    def known(self) -> bool:
        """Whether there were enough measurements."""
        return len(self.tops) >= FEWEST

    def likelihood(self, top: float) -> float:
        """Logarithm of the density of a measured top, over that of any within the range; 0 while
        the stature is not known."""
        if not self.known:
            return 0.0
        varies = VARIES * math.sqrt(1 + 1 / len(self.tops))
        away = (top - float(np.median(self.tops))) / varies
        upright = math.exp(-0.5 * away**2) / (varies * math.sqrt(2 * math.pi))
        return math.log((1 - OTHERWISE) * upright * RANGE + OTHERWISE)


def ratio(top: float | None, one: Stature, other: Stature) -> float:
    """Logarithm of how much likelier a top is one's than another's; 0 where none is seen."""
    return 0.0 if top is None else one.likelihood(top) - other.likelihood(top)


def top_of(sight: Observation, cells: I64, area: float) -> float | None:
    """Metres up to the top of the ``cells`` (C,) of somebody of whom an ``area`` showed at most;
    None where it is not seen that he ends there."""
    mask = np.zeros(len(sight.owner), np.bool_)
    mask[cells] = True
    points = sight.cells.indices[mask[sight.cells.cell]]
    if not len(points):
        return None
    world = sight.view.xyz[points].astype(np.float64)
    height = world @ sight.up
    _, depth = sight.view.project(world[:: max(1, len(points) // SAMPLE)])
    above = max(1, round(TOP * max(area, sight.area(cells)) / float(np.median(depth)) ** 2))
    if above >= len(points):
        return None
    order = np.argpartition(height, len(points) - above)
    highest = order[len(points) - above :]
    middle = world[highest].mean(axis=0)
    at, away = sight.view.project(middle + np.outer(ABOVE, sight.up))
    free = (at >= 0) & (sight.view.depth[at] > away + BEHIND)
    return float(height[highest].min()) if free.all() else None
