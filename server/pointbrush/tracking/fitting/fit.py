"""Register a thing: robust fits from the likeliest guesses, the best by what the sensor saw."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.fitting.explain import costs_of, look
from pointbrush.tracking.fitting.recovery import nudges, proposals, shifts
from pointbrush.tracking.fitting.search import Search
from pointbrush.tracking.geometry.deformation import warp
from pointbrush.tracking.geometry.registration import (
    Fits,
    Source,
    Target,
    excess,
    robust_fits,
    transform,
    transform_each,
)
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.objects.place import Place
from pointbrush.tracking.objects.thing import Thing

LEAST = 20
"""Points of the model that should be seen, from which the others are left out of a fit."""
NARROW, WIDE = (3.0, 3.0, 3.0, 2.5), (10.0, 7.0, 5.0, 4.0, 3.0, 3.0)
LAST = (2.5, 2.0, 2.0)
"""Scales of the fits, in units, from a prediction and from anywhere, and of the best of them."""
AROUND = 4.0
"""Times the first of the last scales around the best pose that is left of a target: no points are
paired that are farther apart."""
TRIES, TRIES_FRESH = 6, 18
"""Guesses that are fitted beside the predictions, and while the motion is unknown."""
STILL, STILL_FIRST, STILL_ROAMING, AS_WELL = 1.0, 3.0, 1.5, 0.03
"""Units by which a thing at rest seems to move at most, more before a lidar in the first frames,
since it slips along its rings, which on the move are other ones in every frame; and what it may
cost more to leave it."""
OPEN = 0.6
"""Share of what faces the sensor from which a thing is seen well enough to tell how it moves."""
SAME = 1.0
"""Units by which no point of the model moves between two guesses that are one when judged."""
DOUBT, DOUBT_LARGE = 0.27, 0.6
"""Cost of the best prediction above which other places are tried; what bends never fits well."""
AVERTED = 0.3
"""What a pose costs that turns all of the model away from the side it was seen from, or, where
there is no depth image, that hides it."""
CLEAR, GOOD, HARDLY_WORSE = 0.12, 0.2, 1.25
"""Costs of a fit at which nothing else is tried though the motion is unknown, and not the next
guess; and how many times the cost of the best guess the next may have to be tried."""
NODES, NODES_SOFT, STEP, PULLED = 5, 8, 3.0, 4.0
"""Nodes of a bending surface on its radius, more of what is soft, but none closer than so many
units; and units within which they are pulled."""
JUDGED, JUDGED_FAR, STAYED = 3.0, 6.0, 2.0
"""Units that distances are judged by: of fits, of guesses that nothing was fitted to, and of what
stays where it was."""
SELDOM = 4
"""Frames in one of which other places are tried again where they were no better before."""
ELSEWHERE = 0.5
"""Radii between two guesses from which they are at different places."""
SURPRISE, TURNED, FARTHEST = 0.6, 0.6, 3.0
"""What a pose far from any prediction costs, and one turned half round against them; and the radii,
for each frame since the thing was seen, from which it is far."""
LEASH, LEASH_FRESH, SLACK, BEYOND = 0.5, 1.5, 3.0, 2.0
"""Share of its radius by which what a lidar sees may be off its predictions, more while its motion
is unknown; with a share of its speed and units for each frame since it was seen; and what a pose
costs that is farther: nothing of that weight changes its way so fast, and a car that goes farther
than that is another."""


def find(search: Search) -> Place:
    """Register a thing, and bend it where it bends."""
    thing = search.thing
    pose, cost, tried, costs = register(search)
    world = transform(pose, thing.model.xyz)
    if thing.bends or thing.soft:
        world = bent(thing, world, thing.model.colour, search.target)
    place = Place(
        pose,
        world,
        search.box,
        search.around,
        search.near,
        search.moving,
        cost,
        predicted=search.guesses,
        tried=tried,
        costs=costs,
    )
    place.vain = search.vain
    place.faint = search.faint
    if search.view.roams:
        place.beside = search.near
    return place


def bent(thing: Thing, world: F64, colour: F32, target: Target) -> F64:
    """Surface of a thing, at ``world`` (M, 3) with ``colour`` (M, 3), bent onto the target."""
    apart = max(thing.model.radius / (NODES_SOFT if thing.soft else NODES), STEP * thing.unit)
    return np.asarray(world + warp(world, colour, target, apart, PULLED * thing.unit))


class Registered(NamedTuple):
    """The best ``pose`` (4, 4) and its ``cost``; those ``tried`` (H, 4, 4), and their ``costs``."""

    pose: F64
    cost: float
    tried: F64
    costs: F64


def register(search: Search) -> Registered:
    """Take the best of the robust fits from the likeliest guesses."""
    motion, model = search.thing.motion, search.thing.model
    poses, scores = _repeated(search)
    doubt = DOUBT_LARGE if search.thing.large or search.thing.bends else DOUBT
    doubtful = min(scores) > doubt and _asked(search)
    unknown = motion.gap > 1 or (motion.fresh and min(scores) > CLEAR)
    if unknown or doubtful:
        before = min(scores)
        others = [*_elsewhere(search), *search.guesses]
        tries = TRIES_FRESH if motion.fresh and search.thing.handy else TRIES
        poses, scores = _try(search, others, tries, poses, scores)
        if motion.fresh or min(scores) > doubt:
            others = _nudged(search, poses, scores)
            tries = TRIES if motion.fresh and search.thing.handy else TRIES // 2
            poses, scores = _try(search, others, tries, poses, scores)
        search.vain = min(scores) > before - AS_WELL
    elif min(scores) > doubt:
        search.vain = search.thing.last.vain
    best = poses[np.argmin(scores)]
    if _rests(search, best, float(np.min(scores))):
        best = motion.resting_pose
        rest = _fits(search, search.many, best[None], (STAYED,))
        return Registered(best, float(rest.cost[0]), poses, scores)
    # What no point can be paired with is left out.
    world = transform(best, model.xyz)
    near = search.target.around(world, AROUND * LAST[0] * search.thing.unit)
    fit = _fits(search, search.many, best[None], LAST, target=near)
    return Registered(fit.T[0], float(fit.cost[0]), poses, scores)


def _elsewhere(search: Search) -> list[F64]:
    """Other poses than the predicted ones; what a lidar sees stands upright."""
    model, guess = search.thing.model, search.guesses[0]
    if search.thing.scanned:
        return shifts(model.xyz[search.few], search.target.xyz, guess, search.thing.unit)
    return proposals(search.thing, search.target, guess)


def _nudged(search: Search, poses: F64, scores: F64) -> list[F64]:
    """Poses beside the best and, while the motion is unknown, beside the best at another place."""
    thing, best = search.thing, int(np.argmin(scores))
    others = nudges(thing.model, poses[best])
    if thing.motion.fresh and thing.handy:
        at = transform_each(poses, thing.model.centre[None])[:, 0]
        away = np.linalg.norm(at - at[best], axis=1) > ELSEWHERE * thing.model.radius
        if away.any():
            others += nudges(thing.model, poses[np.argmin(np.where(away, scores, np.inf))])
    return others


def _rests(search: Search, pose: F64, score: float) -> bool:
    """Whether a thing found at ``pose`` may as well have stayed where it was.

    What half hides it would push it away bit by bit.
    """
    thing, last = search.thing, search.thing.motion.resting_pose
    if thing.stands and search.view.shade is not None and _hidden(search, last):
        return True  # what drives by before a parked car is not that car, however alike
    if thing.bends:
        return False
    if search.view.lens is None:
        some = thing.model.xyz[search.few]
        moved = np.linalg.norm(transform(pose, some) - transform(last, some), axis=1).max()
        slips = thing.scanned and thing.motion.fresh
        first = STILL_ROAMING if search.view.roams else STILL_FIRST
        still = first if slips else STILL
        may = bool(moved <= still * thing.unit)
    else:
        may = thing.handy and thing.motion.rested is not None and _hidden(search, last)
    return may and float(_scores(search, last[None])[0]) < score + AS_WELL


def _hidden(search: Search, pose: F64) -> bool:
    """Whether other things hide most of what faces the sensor at a pose (4, 4)."""
    at = look(search.thing, search.view, search.few, pose[None])
    return float(at.seen.mean()) < OPEN * float(at.facing[0])


def _asked(search: Search) -> bool:
    """Whether other places are tried in this frame.

    Seldom where a thing that hardly moves was found in none of them before; what moves may be
    anywhere in every frame.
    """
    turn = (search.view.number + search.thing.label) % SELDOM == 0
    thing = search.thing
    return turn or not thing.last.vain or not thing.motion.slow(thing.unit)


def _repeated(search: Search) -> tuple[F64, F64]:
    """Fits from the likeliest guess and, unless that one is good, the next: poses and scores."""
    poses, scores = np.empty((0, 4, 4)), np.empty(0)
    for guess in _likeliest(search).tolist():
        # Without a depth image a wrong turn may fit as well.
        if not len(scores) or scores[0] > GOOD or search.view.lens is None:
            seen = search.at.seen[guess : guess + 1]
            new = _fits(search, search.few, search.guesses[guess][None], NARROW, seen=seen).T
            poses = np.concatenate([poses, new])
            scores = np.concatenate([scores, _scores(search, new)])
    return poses, scores


def _likeliest(search: Search) -> I64:
    """Number of the best of the guesses, and of the next that is another and hardly worse."""
    costs = search.costs
    order = np.argsort(costs, kind="stable")
    likely = order[costs[order] < HARDLY_WORSE * costs[order[0]] + 1e-9]
    away = search.at.world[likely] - search.at.world[order[0]]
    apart = np.sqrt(np.einsum("kmi,kmi->km", away, away).max(axis=1))
    others = likely[apart > SAME * search.thing.unit]
    return np.array([order[0], *others[:1]])


def _try(search: Search, guesses: list[F64], most: int, poses: F64, scores: F64) -> tuple[F64, F64]:
    """Fit the likeliest of the guesses, and add them with their scores.

    Half of them are chosen by what is seen alone, in turn over the places: what is thrown or
    knocked goes on elsewhere than any prediction, and the likeliest may all be at one wrong place.
    """
    thing, some, tried = search.thing, search.few, np.stack(guesses)
    at = look(thing, search.view, some, tried, search.own)
    seen = costs_of(thing, search.target, some, at, JUDGED_FAR * thing.unit)
    order = np.argsort(seen + _surprise(search, tried), kind="stable")
    first, rest = np.split(order, [most - most // 2])
    rest = rest[np.argsort(seen[rest], kind="stable")]
    if thing.handy:
        rest = _over_places(thing, tried, first, rest)
    likely = tried[np.append(first, rest[: most // 2])]
    new = _fits(search, some, likely, WIDE).T
    return np.concatenate([poses, new]), np.concatenate([scores, _scores(search, new)])


def _over_places(thing: Thing, poses: F64, first: I64, rest: I64) -> I64:
    """The ``rest`` (M,) of the poses (K, 4, 4), in turn over the places that the thing has there.

    The ``first`` (N,) have had their turns.
    """
    at = transform_each(poses, thing.model.centre[None])[:, 0]
    turn = _turns(at[np.concatenate([first, rest])], ELSEWHERE * thing.model.radius)
    return rest[np.argsort(turn[len(first) :], kind="stable")]


@compiled
def _turns(at: F64, apart: float) -> I64:
    """(N,) how many of the points (N, 3) before each have been at its place.

    A place is where the first was that was more than ``apart`` metres from all places before.
    """
    turn, turns = np.empty(len(at), np.int64), np.zeros(len(at), np.int64)
    places, count = np.empty_like(at), 0
    for i in range(len(at)):
        nearest, least = -1, apart
        for k in range(count):
            square = 0.0
            for a in range(3):
                square += (places[k, a] - at[i, a]) ** 2
            away = np.sqrt(square)
            if away < least or (nearest < 0 and away == apart):
                nearest, least = k, away
        if nearest < 0:
            places[count] = at[i]
            nearest = count
            count += 1
        turn[i] = turns[nearest]
        turns[nearest] += 1
    return turn


def _scores(search: Search, poses: F64) -> F64:
    """What each of ``poses`` (K, 4, 4) costs in all, the less the better."""
    thing = search.thing
    at = look(thing, search.view, search.few, poses, search.own)
    beside = [excess(world, search.target, thing.unit) for world in at.world]
    away = search.at.facing[0] - at.facing
    if search.view.lens is None:
        away = search.at.seen[0].mean() - at.seen.mean(axis=1)
    return np.asarray(
        costs_of(thing, search.target, search.few, at, JUDGED * thing.unit)
        + _surprise(search, poses)
        + beside
        + AVERTED * np.maximum(0.0, away)
    )


def _fits(
    search: Search,
    sample: I64,
    poses: F64,
    scales: Sequence[float],
    *,
    seen: Mask | None = None,
    target: Target | None = None,
) -> Fits:
    """Fit what the sensor should see of the thing at each of ``poses``; ``scales`` in units.

    ``seen`` (K, M): which of the sample that is, where it is known; ``target`` in place of the
    search's.
    """
    model = search.thing.model
    if seen is None:
        seen = look(search.thing, search.view, sample, poses, search.own).seen
    seen = seen | (np.count_nonzero(seen, axis=1) < LEAST)[:, None]
    steps = [s * search.thing.unit for s in scales]
    source = Source(model.xyz[sample], model.colour[sample])
    return robust_fits(source, seen, target or search.target, poses, steps)


def _surprise(search: Search, poses: F64) -> F64:
    """(K,) how far from all predictions, in place and turned, 0 to SURPRISE and TURNED."""
    motion, model, guesses = search.thing.motion, search.thing.model, search.guesses
    at, expected = (transform_each(T, motion.centre[None])[:, 0] for T in (poses, guesses))
    reach = FARTHEST * max(model.radius, search.thing.unit) * motion.gap
    off = np.linalg.norm(at[:, None] - expected, axis=2).min(axis=1) / reach
    cost = SURPRISE * np.minimum(1.0, off)
    if search.thing.scanned:
        size = (LEASH_FRESH if motion.fresh else LEASH) * model.radius
        change = LEASH * motion.speed + SLACK * search.thing.unit
        far = BEYOND * (off * reach > size + change * motion.gap)
    else:
        far = np.zeros(len(off))
    if motion.fresh:
        return np.asarray(0.5 * cost + far)
    turns = poses[:, :3, :3].reshape(-1, 9) @ guesses[:, :3, :3].reshape(-1, 9).T
    # The trace of a rotation is 3 for none, and -1 for half a turn.
    turned = (3.0 - turns.max(axis=1)) / (4.0 * motion.gap)
    return np.asarray(cost + TURNED * turned + far)
