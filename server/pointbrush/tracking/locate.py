"""Where a thing is in the next frame: crop, share the points out, register from many guesses."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.tracking.background import Background
from pointbrush.tracking.explain import cost_of, look
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.nonrigid import warp
from pointbrush.tracking.place import Place
from pointbrush.tracking.recovery import nudges, proposals
from pointbrush.tracking.registration import (
    Fit,
    Target,
    excess,
    robust_fit,
    transform,
)
from pointbrush.tracking.thing import Thing
from pointbrush.tracking.view import View

PATIENT = 1_000_000
"""Frames after which what stands still beside a thing at rest is scenery: never."""
COARSE, FINE = 120, 400
"""Model points that a guess is judged by, and that the last iterations use."""
TARGET = 1200
FEWEST, LEAST = 5, 20
NARROW, WIDE = (3.0, 3.0, 3.0, 2.5), (10.0, 7.0, 5.0, 4.0, 3.0, 3.0)
"""Scales of the fits, in units, from a prediction and from anywhere."""
TRIES = 6
DOUBT, DOUBT_LARGE = 0.27, 0.6
"""Cost of the best prediction above which other places are tried; what bends never fits well."""
AVERTED = 0.3
"""What a pose costs that turns all of the model away from the side it was seen from."""
SURPRISE, TURNED = 0.6, 0.6
"""What a pose far from any prediction costs, and one turned half round against them."""


@dataclass(eq=False)
class Search:
    """A thing's part of the frame: points ``around`` its predictions.

    ``near`` are those in front of the background, ``moving`` those that were not there either
    in the last frame.

    ``few`` numbers the model points that guesses are judged by; ``costs`` of ``guesses``.
    """

    thing: Thing
    view: View
    box: tuple[F64, F64]
    around: I64
    near: I64
    moving: I64
    guesses: list[F64]
    few: I64
    many: I64
    target: Target
    costs: list[float] = field(default_factory=list)

    @cached_property
    def facing(self) -> float:
        """Share of the model that faces the sensor, where it is predicted."""
        return look(self.thing, self.view, self.few, self.guesses[0]).facing

    @property
    def best(self) -> F64:
        """The likeliest prediction."""
        return self.guesses[int(np.argmin(self.costs))]


def crop(thing: Thing, view: View, background: Background, free: Mask) -> Search | None:
    """Cut out what may be the thing, without what stood still; None where nothing is."""
    guesses = thing.motion.predictions()
    centre = thing.motion.centre[None]
    at = np.vstack([transform(g, centre) for g in guesses])
    radius, unit, gap = thing.span, thing.unit, min(thing.motion.gap, 8)
    margin = 1.5 * radius + 4 * unit + (0.6 * radius if thing.motion.fresh else 0.0)
    margin += (0.4 * thing.motion.speed + 2 * unit) * gap
    lo, hi = at.min(axis=0) - margin, at.max(axis=0) + margin
    around = view.box(lo, hi)
    around = around[free[around]]
    near = moving = around
    if len(around):
        far, still = background.static(view, around)
        if thing.large:
            # What stays while the thing has gone half its size on is no part of it.
            speed = thing.motion.speed
            stay = int(0.5 * radius / speed) + 2 if speed > unit else PATIENT
            far = far | background.scenery(view, around, stay)
        near, moving = around[~far], around[~(far | still)]
    if len(moving) < FEWEST:
        return None
    count = len(thing.model.xyz)
    search = Search(
        thing,
        view,
        (lo, hi),
        around,
        near,
        moving,
        guesses,
        np.arange(0, count, max(1, count // COARSE)),
        np.arange(0, count, max(1, count // FINE)),
        target_of(view, moving, thing.weight),
    )
    search.costs = _costs(search, guesses)
    return search


def target_of(view: View, indices: I64, weight: float) -> Target:
    """An even part of the points as a target of registration."""
    some = indices[:: max(1, -(-len(indices) // TARGET))]
    return Target(view.xyz[some].astype(np.float64), view.colour(some), weight)


def share_out(searches: Iterable[Search]) -> None:
    """Take out of each target what another thing's prediction explains clearly better."""
    sure = [s for s in searches if min(s.costs) < DOUBT and not s.thing.motion.fresh]
    new: list[tuple[Search, Target]] = []
    for search in searches:
        mine = _at(search)
        drop = np.zeros(len(search.target.xyz), np.bool_)
        for other in sure:
            if other is search or not _overlap(search, other):
                continue
            theirs = _to_model(other, search.target)
            drop |= (theirs < 3 * other.thing.unit) & (theirs < 0.5 * mine)
        if drop.any() and (~drop).sum() >= FEWEST:
            left = search.target
            kept = Target(left.xyz[~drop], left.colour[~drop], left.weight)
            new.append((search, kept))
    for search, target in new:
        search.target = target
        search.costs = _costs(search, search.guesses)


def find(search: Search) -> Place:
    """Register a thing, and bend it where it bends."""
    thing = search.thing
    fit = register(search)
    world = transform(fit.T, thing.model.xyz)
    if thing.bends:
        apart = max(thing.model.radius / 5, 3 * thing.unit)
        world = world + warp(world, thing.model.colour, search.target, apart, 4 * thing.unit)
    near = search.near if thing.motion.slow(thing.unit) else search.moving
    return Place(fit.T, world, search.box, search.around, near, search.moving, fit.cost)


def register(search: Search) -> Fit:
    """The best of the robust fits from the likeliest guesses."""
    motion = search.thing.motion
    order = np.argsort(search.costs, kind="stable")
    poses = [_fit(search, search.few, search.guesses[i], NARROW).T for i in order[:2]]
    scores = [_score(search, T) for T in poses]
    doubt = DOUBT_LARGE if search.thing.large or search.thing.bends else DOUBT
    if motion.gap > 1 or motion.fresh or min(scores) > doubt:
        others = proposals(search.thing.model, search.target, search.guesses[0])
        _try(search, others + search.guesses, TRIES, poses, scores)
        if motion.fresh or min(scores) > doubt:
            best = poses[int(np.argmin(scores))]
            _try(search, nudges(search.thing.model, best), TRIES // 2, poses, scores)
    best = poses[int(np.argmin(scores))]
    return _fit(search, search.many, best, (2.5, 2.0, 2.0))


def _try(
    search: Search, guesses: list[F64], most: int, poses: list[F64], scores: list[float]
) -> None:
    """Fit the likeliest of the guesses, and add them with their scores."""
    known = search.guesses
    thing, some = search.thing, search.few
    costs = [
        cost_of(thing, search.view, search.target, some, T, 6 * thing.unit)
        + _surprise(thing, T, known)
        for T in guesses
    ]
    for i in np.argsort(costs, kind="stable")[:most]:
        poses.append(_fit(search, search.few, guesses[i], WIDE).T)
        scores.append(_score(search, poses[-1]))


def _score(search: Search, pose: F64) -> float:
    """What a pose costs in all, the less the better."""
    thing, few = search.thing, search.few
    return (
        _cost(search, pose, 3 * thing.unit)
        + _surprise(thing, pose, search.guesses)
        + excess(transform(pose, thing.model.xyz[few]), search.target, thing.unit)
        + AVERTED * max(0.0, search.facing - look(thing, search.view, few, pose).facing)
    )


def _fit(search: Search, sample: I64, pose: F64, scales: Sequence[float]) -> Fit:
    """Fit what the sensor should see of the thing at ``pose``; ``scales`` in units."""
    model = search.thing.model
    seen = sample[look(search.thing, search.view, sample, pose).seen]
    if len(seen) < LEAST:
        seen = sample
    steps = [s * search.thing.unit for s in scales]
    return robust_fit(model.xyz[seen], model.colour[seen], search.target, pose, steps)


def _cost(search: Search, pose: F64, scale: float) -> float:
    return cost_of(search.thing, search.view, search.target, search.few, pose, scale)


def _costs(search: Search, poses: list[F64]) -> list[float]:
    return [_cost(search, T, 4 * search.thing.unit) for T in poses]


def _surprise(thing: Thing, pose: F64, predicted: list[F64]) -> float:
    """How far from all predictions, in place and turned, 0 to SURPRISE and TURNED."""
    centre = thing.motion.centre[None]
    at = transform(pose, centre)[0]
    reach = 3 * max(thing.model.radius, thing.unit) * thing.motion.gap
    off = min(float(np.linalg.norm(transform(p, centre)[0] - at)) for p in predicted) / reach
    if thing.motion.fresh:
        return 0.5 * SURPRISE * min(1.0, off)
    turn = max(float(np.einsum("ij,ij", p[:3, :3], pose[:3, :3])) for p in predicted)
    return SURPRISE * min(1.0, off) + TURNED * (3.0 - turn) / (4.0 * thing.motion.gap)


def _at(search: Search) -> F64:
    return _to_model(search, search.target)


def _to_model(search: Search, target: Target) -> F64:
    """Distance in place and colour from target points to the thing where it is predicted."""
    model, weight = search.thing.model, target.weight
    world = transform(search.best, model.xyz[search.many])
    colour: F32 = model.colour[search.many]
    tree = cKDTree(np.hstack([world, colour * weight]), balanced_tree=False, compact_nodes=False)
    distance, _ = tree.query(
        np.hstack([target.xyz, target.colour * weight]),
        distance_upper_bound=20 * search.thing.unit,
    )
    return np.minimum(np.asarray(distance, np.float64), 20 * search.thing.unit).astype(np.float64)


def _overlap(one: Search, other: Search) -> bool:
    ends = [transform(s.best, s.thing.motion.centre[None])[0] for s in (one, other)]
    reach = one.thing.model.radius + other.thing.model.radius
    return float(np.linalg.norm(ends[0] - ends[1])) < 1.5 * reach
