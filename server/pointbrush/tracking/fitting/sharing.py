"""Which points are no target for a thing, since another thing's prediction explains them better."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.fitting.search import Search
from pointbrush.tracking.geometry.columns import Columns, nearest_one, spans, toned
from pointbrush.tracking.geometry.near import bounds
from pointbrush.tracking.geometry.registration import Target, transform
from pointbrush.tracking.interface import F32, F64, Mask
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.options import SearchOptions


def share_out(searches: Iterable[Search], options: SearchOptions) -> None:
    """Take out of each target what another thing's prediction explains clearly better."""
    searches = list(searches)
    ghosts = [_ghost(search) for search in searches]
    sure = [n for n, s in enumerate(searches) if min(s.costs) < _limit(s.thing)]
    new: list[tuple[Search, Target]] = []
    for search, ghost in zip(searches, ghosts, strict=True):
        left = search.target
        drop = np.zeros(len(left.xyz), np.bool_)
        for number in sure:
            if searches[number] is not search and ghosts[number].meets(ghost, options=options):
                reach = options.explained_units * searches[number].thing.unit
                own, theirs = ghost.surface, ghosts[number].surface
                _drop_theirs(
                    drop,
                    left.xyz,
                    left.colour,
                    own,
                    theirs,
                    reach,
                    options.clearly_nearer_share,
                )
        if drop.any() and (~drop).sum() >= options.min_moving_points:
            new.append((search, Target(left.xyz[~drop], left.colour[~drop], left.weight)))
    for search, target in new:
        search.aim(target)


def _limit(thing: Thing) -> float:
    """Cost up to which a prediction is sure; what motion a thing has may not be known yet."""
    options = thing.options.register
    if thing.motion.fresh:
        return options.clear_cost if thing.handy else 0.0
    return options.doubt_body if thing.large else options.doubt


class _Surface(NamedTuple):
    """Sorted points, and the corners (3,) of the box that they lie in."""

    columns: Columns
    lo: F64
    hi: F64


@dataclass(frozen=True, slots=True, eq=False)
class _Ghost:
    """A thing where it is predicted, in place and colour."""

    surface: _Surface
    centre: F64
    radius: float

    def meets(self, other: _Ghost, options: SearchOptions) -> bool:
        """Whether the two are near to each other."""
        away = self.centre - other.centre
        return float(away @ away) < (options.meeting_radii * (self.radius + other.radius)) ** 2


def _ghost(search: Search) -> _Ghost:
    model, many, weight = search.thing.model, search.many, search.target.weight
    world = transform(search.best, model.xyz[many])
    columns = Target(world, model.colour[many], weight).columns
    centre = transform(search.best, search.thing.motion.centre[None])[0]
    return _Ghost(_Surface(columns, *bounds(world)), centre, model.radius)


@compiled
def _drop_theirs(
    drop: Mask,
    xyz: F64,
    colour: F32,
    own: _Surface,
    theirs: _Surface,
    reach: float,
    clearly_nearer_share: float,
) -> None:
    """Mark which points (N, 3) are nearer to another's surface than half as far as to their own."""
    mine, others = own.columns, theirs.columns
    room, other_room = spans(mine), spans(others)
    for i in range(len(xyz)):
        x, y, z = xyz[i, 0], xyz[i, 1], xyz[i, 2]
        away = max(theirs.lo[0] - x, x - theirs.hi[0], theirs.lo[1] - y, y - theirs.hi[1])
        if drop[i] or max(away, theirs.lo[2] - z, z - theirs.hi[2]) > reach:
            continue
        tint = toned(others, colour, i)
        square, at = nearest_one(others, (x, y, z), tint, reach, other_room)
        if at >= 0:
            tint = toned(mine, colour, i)
            drop[i] = (
                square
                < clearly_nearer_share**2 * nearest_one(mine, (x, y, z), tint, 2 * reach, room)[0]
            )
