"""Registration of an object: robust fits from the most likely hypotheses, ranked by evidence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.compute.deformation import warp
from pointbrush.tracking.compute.rigid import (
    Fits,
    Source,
    Target,
    excess,
    robust_fits,
    transform,
    transform_each,
)
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.steps.predict import Search
from pointbrush.tracking.steps.propose import nudges, proposals, shifts
from pointbrush.tracking.steps.verdict import costs_of, look


def find(search: Search) -> Registration:
    """Return the registration of an object, with its surface deformed if it bends."""
    track = search.track
    best = register(search)
    world = transform(best.pose, track.model.xyz)
    if track.bends or track.soft:
        world = bent(track, world, track.model.colour, search.target)
    return Registration(
        best.pose,
        world,
        search.box,
        search.around,
        search.near,
        search.moving,
        best.cost,
        predicted=search.hypotheses,
        tried=best.tried,
        costs=best.costs,
        alternatives_failed=best.alternatives_failed,
        faint=search.faint,
    )


def bent(track: Track, world: F64, colour: F32, target: Target) -> F64:
    """Return the surface ``world`` (M, 3) with ``colour`` (M, 3), deformed to the target."""
    options = track.options
    apart = max(
        track.model.radius / options.register.nodes_per_radius,
        options.register.node_units * track.unit,
    )
    pull = options.register.pull_units * track.unit
    return world + warp(world, colour, target, apart, pull, options=options.deform)


class Registered(NamedTuple):
    """The best ``pose`` (4, 4) and its ``cost``; hypotheses ``tried`` (H, 4, 4), with ``costs``.

    ``alternatives_failed``: whether poses other than the predicted ones were tried without success.
    """

    pose: F64
    cost: float
    tried: F64
    costs: F64
    alternatives_failed: bool


def register(search: Search) -> Registered:
    """Return the best of the robust fits from the most likely hypotheses."""
    options = search.options.register
    motion = search.track.motion
    poses, scores = _repeated(search)
    doubt = options.doubt if search.track.rigid else options.doubt_body
    doubtful = min(scores) > doubt and _retries_now(search)
    failed = False
    unknown = motion.gap > 1 or (motion.is_unknown and min(scores) > options.clear_cost)
    if unknown or doubtful:
        before = min(scores)
        others = [*_unpredicted_poses(search), *search.hypotheses]
        tries = (
            options.tries_unknown_motion
            if motion.is_unknown and search.track.hand_sized
            else options.tries
        )
        poses, scores = _fit_likeliest(search, others, tries, poses, scores)
        if motion.is_unknown or min(scores) > doubt:
            others = _nudged(search, poses, scores)
            tries = (
                options.tries
                if motion.is_unknown and search.track.hand_sized
                else options.tries // 2
            )
            poses, scores = _fit_likeliest(search, others, tries, poses, scores)
        failed = min(scores) > before - options.rest_cost
    elif min(scores) > doubt:
        failed = search.track.last.alternatives_failed
    best = poses[np.argmin(scores)]
    if _rests(search, best, float(np.min(scores))):
        best = motion.resting_pose
        rest = _fits(search, search.many, best[None], (options.judged_units_rest,))
        return Registered(best, float(rest.cost[0]), poses, scores, bool(failed))
    fit = _fits(search, search.many, best[None], options.final_scales)
    return Registered(fit.T[0], float(fit.cost[0]), poses, scores, bool(failed))


def _unpredicted_poses(search: Search) -> list[F64]:
    """Return poses other than the predicted ones; in lidar scans objects stay upright."""
    track, hypothesis = search.track, search.hypotheses[0]
    if track.scanned:
        some = track.model.xyz[search.few]
        return shifts(some, search.target.xyz, hypothesis, track.unit, search.options.propose)
    return proposals(track, search.target, hypothesis)


def _nudged(search: Search, poses: F64, scores: F64) -> list[F64]:
    """Return poses near the best and, if the motion is unknown, near the best at another place."""
    track, best = search.track, int(np.argmin(scores))
    others = nudges(track.model, poses[best], track.options.propose)
    if track.motion.is_unknown and track.hand_sized:
        at = transform_each(poses, track.model.centre[None])[:, 0]
        apart = (
            np.linalg.norm(at - at[best], axis=1)
            > search.options.register.other_place_radii * track.model.radius
        )
        if apart.any():
            other = poses[np.argmin(np.where(apart, scores, np.inf))]
            others += nudges(track.model, other, track.options.propose)
    return others


def _rests(search: Search, pose: F64, score: float) -> bool:
    """Return whether an object found at ``pose`` may be at rest at its last pose.

    Partial occlusion would otherwise shift it gradually.
    """
    options = search.options.register
    track, last = search.track, search.track.motion.resting_pose
    if track.stands and search.view.shaded and _hidden(search, last):
        return True  # a similar vehicle passing in front of a parked car is not that car
    if track.bends:
        return False
    if search.view.lens is None:
        some = track.model.xyz[search.few]
        moved = np.linalg.norm(transform(pose, some) - transform(last, some), axis=1).max()
        slips = track.scanned and track.motion.is_unknown
        first = (
            options.rest_units_moving_scanner
            if search.view.roams
            else options.rest_units_first_scans
        )
        still = first if slips else options.rest_units
        may = bool(moved <= still * track.unit)
    else:
        may = track.hand_sized and track.motion.rested is not None and _hidden(search, last)
    return may and float(_scores(search, last[None])[0]) < score + options.rest_cost


def _hidden(search: Search, pose: F64) -> bool:
    """Return whether other objects occlude most of the side facing the sensor at a pose (4, 4)."""
    at = look(search.track, search.view, search.few, pose[None])
    return float(at.seen.mean()) < search.options.register.open_share * float(at.facing[0])


def _retries_now(search: Search) -> bool:
    """Return whether other places are tried in this frame.

    They are tried seldom for a slow object after a failed search, and always for moving objects.
    """
    turn = (search.view.number + search.track.label) % search.options.register.retry_frames == 0
    track = search.track
    return turn or not track.last.alternatives_failed or not track.motion.slow(track.unit)


def _repeated(search: Search) -> tuple[F64, F64]:
    """Return poses and scores of fits from the best hypothesis and, unless it is good, the next."""
    options = search.options.register
    poses, scores = np.empty((0, 4, 4)), np.empty(0)
    for hypothesis in _likeliest(search).tolist():
        # Without a depth image a wrong rotation may fit equally well.
        if not len(scores) or scores[0] > options.good_cost or search.view.lens is None:
            seen = search.at.seen[hypothesis : hypothesis + 1]
            new = _fits(
                search,
                search.few,
                search.hypotheses[hypothesis][None],
                options.predicted_scales,
                seen=seen,
            ).T
            poses = np.concatenate([poses, new])
            scores = np.concatenate([scores, _scores(search, new)])
    return poses, scores


def _likeliest(search: Search) -> I64:
    """Return indices of the best hypothesis and of the next different one that is little worse."""
    options = search.options.register
    costs = search.costs
    order = np.argsort(costs, kind="stable")
    likely = order[costs[order] < options.try_next_ratio * costs[order[0]] + 1e-9]
    offset = search.at.world[likely] - search.at.world[order[0]]
    apart = np.sqrt(np.einsum("kmi,kmi->km", offset, offset).max(axis=1))
    others = likely[apart > options.same_pose_units * search.track.unit]
    return np.array([order[0], *others[:1]])


def _fit_likeliest(
    search: Search, hypotheses: list[F64], most: int, poses: F64, scores: F64
) -> tuple[F64, F64]:
    """Fit the most likely hypotheses; return all poses with their scores.

    Half of them are chosen by visible evidence alone, alternating over places: a thrown object may
    leave all predictions, and the most likely hypotheses may all be at the same wrong place.
    """
    options = search.options.register
    track, some, tried = search.track, search.few, np.stack(hypotheses)
    at = look(track, search.view, some, tried, search.own)
    seen = costs_of(track, search.target, some, at, options.judged_units_unfitted * track.unit)
    order = np.argsort(seen + _prediction_cost(search, tried), kind="stable")
    first, rest = np.split(order, [most - most // 2])
    rest = rest[np.argsort(seen[rest], kind="stable")]
    if track.hand_sized:
        rest = _over_places(track, tried, first, rest)
    likely = tried[np.append(first, rest[: most // 2])]
    new = _fits(search, some, likely, options.anywhere_scales).T
    return np.concatenate([poses, new]), np.concatenate([scores, _scores(search, new)])


def _over_places(track: Track, poses: F64, first: I64, rest: I64) -> I64:
    """Return the ``rest`` (M,) of the poses (K, 4, 4), alternating over places of the object.

    The ``first`` (N,) were used before and count.
    """
    at = transform_each(poses, track.model.centre[None])[:, 0]
    turn = _turns(
        at[np.concatenate([first, rest])],
        track.options.register.other_place_radii * track.model.radius,
    )
    return rest[np.argsort(turn[len(first) :], kind="stable")]


@compiled
def _turns(at: F64, apart: float) -> I64:
    """Return (N,) the number of earlier points (N, 3) at the place of each point.

    A point more than ``apart`` metres from all earlier places starts a new place.
    """
    turn, turns = np.empty(len(at), np.int64), np.zeros(len(at), np.int64)
    places, count = np.empty_like(at), 0
    for i in range(len(at)):
        nearest, least = -1, apart
        for k in range(count):
            square = 0.0
            for a in range(3):
                square += (places[k, a] - at[i, a]) ** 2
            distance = np.sqrt(square)
            if distance < least or (nearest < 0 and distance == apart):
                nearest, least = k, distance
        if nearest < 0:
            places[count] = at[i]
            nearest = count
            count += 1
        turn[i] = turns[nearest]
        turns[nearest] += 1
    return turn


def _scores(search: Search, poses: F64) -> F64:
    """Return the total cost (K,) of each of ``poses`` (K, 4, 4)."""
    options = search.options.register
    track = search.track
    at = look(track, search.view, search.few, poses, search.own)
    facing_loss = search.at.facing[0] - at.facing
    if search.view.lens is None:
        facing_loss = search.at.seen[0].mean() - at.seen.mean(axis=1)
    return np.asarray(
        costs_of(track, search.target, search.few, at, options.judged_units * track.unit)
        + _prediction_cost(search, poses)
        + excess(at.world, search.target, track.unit, options)
        + options.averted_cost * np.maximum(0.0, facing_loss)
    )


def _fits(
    search: Search,
    sample: I64,
    poses: F64,
    scales: Sequence[float],
    *,
    seen: Mask | None = None,
) -> Fits:
    """Return fits of the visible part of the object at each of ``poses``; ``scales`` in units.

    ``seen`` (K, M): mask of visible points of the sample, if known.
    """
    model = search.track.model
    if seen is None:
        seen = look(search.track, search.view, sample, poses, search.own).seen
    seen = (
        seen
        | (np.count_nonzero(seen, axis=1) < search.options.register.min_visible_points)[:, None]
    )
    steps = [s * search.track.unit for s in scales]
    source = Source(model.xyz[sample], model.colour[sample])
    return robust_fits(source, seen, search.target, poses, steps, options=search.options.register)


def _prediction_cost(search: Search, poses: F64) -> F64:
    """Return (K,) the cost of the distance of poses from all predictions, in place and rotation."""
    options = search.options.register
    motion, model, hypotheses = search.track.motion, search.track.model, search.hypotheses
    at, expected = (transform_each(T, motion.centre[None])[:, 0] for T in (poses, hypotheses))
    reach = options.surprise_radii * max(model.radius, search.track.unit) * motion.gap
    off = np.linalg.norm(at[:, None] - expected, axis=2).min(axis=1) / reach
    cost = options.surprise_cost * np.minimum(1.0, off)
    if search.track.scanned:
        size = (
            options.limit_radii_unknown if motion.is_unknown else options.limit_radii
        ) * model.radius
        change = options.limit_radii * motion.speed + options.limit_units * search.track.unit
        far = options.beyond_cost * (off * reach > size + change * motion.gap)
    else:
        far = np.zeros(len(off))
    if motion.is_unknown:
        return np.asarray(0.5 * cost + far)
    turns = poses[:, :3, :3].reshape(-1, 9) @ hypotheses[:, :3, :3].reshape(-1, 9).T
    # The trace of a rotation is 3 for none, and -1 for half a turn.
    turned = (3.0 - turns.max(axis=1)) / (4.0 * motion.gap)
    return np.asarray(cost + options.surprise_cost * turned + far)
