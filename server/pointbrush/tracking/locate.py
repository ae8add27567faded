"""Where a thing is in the next frame: crop, share the points out, register from many guesses."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.tracking.background import Background
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.recovery import proposals
from pointbrush.tracking.registration import (
    Fit,
    Target,
    cost_at,
    excess,
    robust_fit,
    transform,
)
from pointbrush.tracking.thing import Thing
from pointbrush.tracking.view import View

COARSE, FINE = 64, 200
"""Model points that a guess is judged by, and that the last iterations use."""
TARGET = 1200
FEWEST = 5
DOUBT = 0.3
"""Cost of the best prediction above which other places are tried."""
AVERTED = 0.3
"""What a pose costs that turns all of the model away from the side it was seen from."""
SURPRISE = 0.3
"""What a pose far from any prediction costs."""


@dataclass(eq=False)
class Search:
    """A thing's part of the frame: points ``around`` its predictions.

    ``near`` are those in front of the background, ``moving`` those that were not there either
    in the last frame.

    ``few`` numbers the model points that guesses are judged by; ``costs`` of ``guesses``.
    """

    thing: Thing
    box: tuple[F64, F64]
    around: I64
    near: I64
    moving: I64
    guesses: list[F64]
    few: I64
    many: I64
    target: Target
    costs: list[float] = field(default_factory=list)

    @property
    def best(self) -> F64:
        """The likeliest prediction."""
        return self.guesses[int(np.argmin(self.costs))]


def crop(thing: Thing, view: View, background: Background, free: Mask) -> Search | None:
    """Cut out what may be the thing, without what stood still; None where nothing is."""
    guesses = thing.motion.predictions()
    centre = thing.motion.centre[None]
    at = np.vstack([transform(g, centre) for g in guesses])
    radius, unit, gap = thing.model.radius, thing.unit, min(thing.motion.gap, 8)
    margin = 1.5 * radius + 4 * unit + (0.6 * radius if thing.motion.fresh else 0.0)
    margin += (0.4 * thing.motion.speed + 2 * unit) * gap
    lo, hi = at.min(axis=0) - margin, at.max(axis=0) + margin
    around = view.box(lo, hi)
    around = around[free[around]]
    near = moving = around
    if len(around):
        far, still = background.static(view, around)
        near, moving = around[~far], around[~(far | still)]
    if len(moving) < FEWEST:
        return None
    visible = np.flatnonzero(expected(thing, view, guesses[0]))
    if len(visible) < 10:
        visible = np.arange(len(thing.model.xyz))
    search = Search(
        thing,
        (lo, hi),
        around,
        near,
        moving,
        guesses,
        visible[:: max(1, len(visible) // COARSE)],
        visible[:: max(1, len(visible) // FINE)],
        target_of(view, moving, thing.weight),
    )
    search.costs = _costs(search, guesses)
    return search


def target_of(view: View, indices: I64, weight: float) -> Target:
    """An even part of the points as a target of registration."""
    some = indices[:: max(1, -(-len(indices) // TARGET))]
    return Target(view.xyz[some].astype(np.float64), view.colour(some), weight)


def expected(thing: Thing, view: View, pose: F64) -> Mask:
    """Model points that the sensor should see: facing it, and nothing in front."""
    seen = thing.model.facing(pose, view.eye)
    if view.lens is not None:
        cell, depth = view.project(transform(pose, thing.model.xyz))
        with np.errstate(invalid="ignore"):
            seen &= ~(view.depth[cell] < depth - 4 * thing.unit) & (cell >= 0)
    return seen


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


def register(search: Search, eye: F64 | None) -> Fit:
    """The best of the robust fits from the likeliest guesses."""
    thing, target = search.thing, search.target
    model, unit = thing.model, thing.unit
    xyz, colour = model.xyz[search.few], model.colour[search.few]
    guesses, costs = list(search.guesses), list(search.costs)
    known = len(guesses)
    if thing.motion.gap > 1 or thing.motion.fresh or min(costs) > DOUBT:
        others = proposals(model, target, guesses[0])
        costs += _costs(search, others)
        guesses += others
    costs = [c + _surprise(thing, g, guesses[:known]) for c, g in zip(costs, guesses, strict=True)]
    best = np.argsort(costs, kind="stable")[: 2 if len(guesses) == known else 6]
    near, far = (3.0, 3.0, 3.0, 2.5), (5.0, 4.0, 4.0, 3.0, 3.0)
    fits = [
        robust_fit(
            xyz,
            colour,
            target,
            guesses[i],
            [s * unit for s in (near if i < known and costs[i] < DOUBT else far)],
        )
        for i in best
    ]
    fit = fits[0]
    if len(fits) > 1:
        scores = [
            cost_at(xyz, colour, target, f.T, 3 * unit)
            + _surprise(thing, f.T, guesses[:known])
            + excess(xyz, target, f.T, unit)
            + AVERTED * float(1.0 - model.facing(f.T, eye)[search.few].mean())
            for f in fits
        ]
        fit = fits[int(np.argmin(scores))]
    xyz, colour = model.xyz[search.many], model.colour[search.many]
    return robust_fit(xyz, colour, target, fit.T, [2.5 * unit, 2 * unit, 2 * unit])


def _costs(search: Search, poses: list[F64]) -> list[float]:
    model, few = search.thing.model, search.few
    scale = 4 * search.thing.unit
    return [cost_at(model.xyz[few], model.colour[few], search.target, T, scale) for T in poses]


def _surprise(thing: Thing, pose: F64, predicted: list[F64]) -> float:
    """How far from all predictions, 0 to SURPRISE."""
    centre = thing.motion.centre[None]
    at = transform(pose, centre)[0]
    off = min(float(np.linalg.norm(transform(p, centre)[0] - at)) for p in predicted)
    return SURPRISE * min(1.0, off / (3 * thing.model.radius * thing.motion.gap))


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
