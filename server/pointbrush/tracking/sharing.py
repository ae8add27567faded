"""Which points are no target for a thing, since another thing's prediction explains them better."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from pointbrush.tracking.fit import CLEAR, DOUBT, DOUBT_LARGE
from pointbrush.tracking.interface import F64, I64
from pointbrush.tracking.locate import FEWEST, Search
from pointbrush.tracking.near import bounds, within
from pointbrush.tracking.registration import Target, transform
from pointbrush.tracking.thing import Thing


def share_out(searches: Iterable[Search]) -> None:
    """Take out of each target what another thing's prediction explains clearly better."""
    searches = list(searches)
    sure = [s for s in searches if min(s.costs) < _limit(s.thing)]
    ghosts = {id(s): _ghost(s) for s in searches}
    new: list[tuple[Search, Target]] = []
    for search in searches:
        left = search.target
        drop = np.zeros(len(left.xyz), np.bool_)
        for other in sure:
            ghost, reach = ghosts[id(other)], 3 * other.thing.unit
            if other is search or not ghost.meets(ghosts[id(search)]):
                continue
            near = np.flatnonzero(within(left.xyz, ghost.lo - reach, ghost.hi + reach))
            if not len(near):
                continue
            theirs = ghost.gap(left, near, reach)
            near, theirs = near[theirs < reach], theirs[theirs < reach]
            if not len(near):
                continue
            drop[near] |= theirs < 0.5 * ghosts[id(search)].gap(left, near, 2 * reach)
        if drop.any() and (~drop).sum() >= FEWEST:
            new.append((search, Target(left.xyz[~drop], left.colour[~drop], left.weight)))
    for search, target in new:
        search.aim(target)


def _limit(thing: Thing) -> float:
    """Cost up to which a prediction is sure; what motion a thing has may not be known yet."""
    if thing.motion.fresh:
        return CLEAR if thing.handy else 0.0
    return DOUBT_LARGE if thing.large else DOUBT


@dataclass(frozen=True, slots=True, eq=False)
class _Ghost:
    """A thing where it is predicted, in place and colour; ``lo`` and ``hi`` bound its place."""

    surface: Target
    centre: F64
    radius: float
    lo: F64
    hi: F64

    def meets(self, other: _Ghost) -> bool:
        """Whether the two are near to each other."""
        away = float(np.linalg.norm(self.centre - other.centre))
        return away < 1.5 * (self.radius + other.radius)

    def gap(self, target: Target, points: I64, most: float) -> F64:
        """Distances in place and colour, at most ``most``, from some of the target."""
        return self.surface.nearest(target.xyz[points], target.colour[points], most)[0]


def _ghost(search: Search) -> _Ghost:
    model, many = search.thing.model, search.many
    world = transform(search.best, model.xyz[many])
    surface = Target(world, model.colour[many], search.target.weight)
    centre = transform(search.best, search.thing.motion.centre[None])[0]
    return _Ghost(surface, centre, model.radius, *bounds(world))
