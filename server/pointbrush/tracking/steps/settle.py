"""Outcome of a track in a frame: its state, confidence and learnt points."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pointbrush.tracking.compute.grid import bounds, close_to, within
from pointbrush.tracking.compute.rigid import transform, transform_each
from pointbrush.tracking.interface import F32, F64, I64, State, TrackOptions, TrackState
from pointbrush.tracking.model.appearance import ColourHistogram
from pointbrush.tracking.model.confidence import Evidence, likelihood
from pointbrush.tracking.model.registration import Registration, no_points
from pointbrush.tracking.model.surface import remember
from pointbrush.tracking.model.track import LastObservation, Track
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.association import Association, LabelledPoints
from pointbrush.tracking.steps.claim import together
from pointbrush.tracking.steps.context import unexplained
from pointbrush.tracking.steps.update import Observation, learn, note_strain
from pointbrush.tracking.steps.verdict import Verdict, judge


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """The ``state`` of a track in a frame, and its sorted ``points`` (M,)."""

    state: TrackState
    points: I64


def evidence(track: Track, observation: Observation, points: I64) -> Evidence:
    """Return the features of a registration for the confidence; ``points`` (M,) are assigned."""
    view, fit, given = observation.view, observation.fit, observation.given
    found, verdict = given.claim, observation.verdict
    m = max(len(found.indices), 1)
    count = max(len(points), 1)
    some = points[:: max(1, len(points) // track.options.update.colour_points)]
    left, others = _moving_around(track, view, fit, points, given.owned)
    return Evidence(
        inliers=verdict.inliers,
        sure=float((track.model.hits[found.nearest] >= track.options.surface.sure_hits).mean()),
        gap=float(found.gap.mean() / track.reach),
        cost=float(found.cost.mean() / track.reach),
        fit=fit.cost,
        size=len(points) / max(track.size, 1.0),
        change=len(points) / max(track.last.points, 1),
        grown=1.0 - m / count,
        isolated=given.isolated,
        share=m / max(len(fit.moving), 1),
        appearance=track.appearance.likeness(view.colour(some)) - track.appearance.usual
        if track.body
        else 0.0,
        usual=track.usual_cost,
        points=count,
        pixels=view.lens is not None,
        scans=track.scanned,
        soft=track.soft,
        left=(left + 1) / (len(points) + 1),
        others=(others + 1) / (len(points) + 1),
        tall=_height(track, view, fit, points),
        bend=track.bending.share,
        coarse=track.unit / max(track.model.radius, track.unit),
        beside=_unclaimed_beside(track, observation, points),
    )


def _unclaimed_beside(track: Track, observation: Observation, points: I64) -> float:
    """Return the number of unclaimed moving points that touch a small object, over its ``points``.

    They may be sides of it that were not found.  Points of lidars are too sparse to touch.
    """
    view, fit, given = observation.view, observation.fit, observation.given
    if view.lens is None or track.large or not len(points):
        return 0.0
    taken = np.zeros(len(view.xyz), np.bool_)
    taken[np.concatenate([points, given.owned, given.neutral])] = True
    own, reach = view.xyz[points].astype(np.float64), view.options.claim.touching_units * track.unit
    lo, hi = bounds(own)
    rest = fit.moving[~taken[fit.moving]]
    rest = rest[within(view.xyz[rest], lo - reach, hi + reach)]
    if not len(rest):
        return 0.0
    return float(close_to(view.xyz[rest].astype(np.float64), own, reach).sum() / len(points))


def _moving_around(
    track: Track, view: View, fit: Registration, points: I64, others: I64
) -> tuple[int, int]:
    """Return the numbers of moving points around an object's ``points`` (M,).

    The first is of unassigned points, the second of points ``others`` (O,) of any track.  Both are
    0 except in lidar scans.
    """
    if not (track.scanned and len(points)):
        return 0, 0
    lo, hi = bounds(view.xyz[points])
    margin = track.options.update.new_surface_units * track.unit
    owned = np.zeros(len(view.xyz), np.bool_)
    owned[points] = True
    rest = fit.moving[~owned[fit.moving]]
    rest = rest[within(view.xyz[rest], lo - margin, hi + margin)]
    owned[others] = True
    count = int(owned[rest].sum())
    return len(rest) - count, count


def _height(track: Track, view: View, fit: Registration, points: I64) -> float:
    """Return the height of an object's ``points`` (M,) over its model's, for lidar scans."""
    if not (track.scanned and len(points)):
        return 1.0
    height = float(np.ptp(fit.world[:, view.up]))
    return float(np.ptp(view.xyz[points, view.up])) / max(height, track.unit)


def settle(
    track: Track,
    view: View,
    found: Association | None,
    given: LabelledPoints | None,
    track_options: TrackOptions,
    confidence_cap: float = 1.0,
) -> Outcome:
    """Judge the track in a frame by its points, and update it."""
    options = track.options.update
    if found is None or given is None:
        verdict = judge(track, view, None, None, None)
        return Outcome(_unseen(track, None, verdict, track_options), no_points())
    fit, claim = found.registration, given.claim
    verdict = judge(track, view, fit.pose, fit.world, claim)
    if not _seen(track, view, fit, verdict) or hides(track, view, fit, given, verdict.inliers):
        return Outcome(_unseen(track, fit.pose, verdict, track_options), no_points())
    track.frames_unseen = 0
    if track.scanned:
        at = transform(fit.pose, track.motion.centre[None])[0]
        distance = view.sensor_distance(at)
        if distance is not None:
            track.set_distance(distance)
    observation = Observation(view, fit, given, verdict)
    points = together(claim.indices, given.grown)
    features = evidence(track, observation, points)
    _trust(track, observation, features, _strays(track, view, found), confidence_cap)
    track.last = LastObservation(len(points), fit.alternatives_failed, features)
    _move(track, found, verdict)
    if fit.cost < options.motion_cost:
        note_strain(track, observation)
    # A bending object fits poorly as a rigid model, and well after deformation.
    followed = (
        track.soft and fit.cost < options.motion_cost and verdict.inliers > options.reappear_share
    )
    if fit.cost < options.teach_cost or followed or not track.rigid:
        learn(track, replace(observation, given=_learnable_points(track, observation)))
    if fit.cost < options.teach_cost and track.rigid:
        remember(track.carving_views, view, fit.pose, fit.world)
    rmse = float(np.sqrt(np.mean(claim.gap**2))) if len(claim.gap) else 0.0
    state = TrackState(fit.pose, rmse, verdict.inliers, track.confidence, len(points), "tracked")
    return Outcome(state, together(points, given.rim))


def _unseen(
    track: Track, pose: F64 | None, verdict: Verdict, track_options: TrackOptions
) -> TrackState:
    """Update an object not seen in a frame at ``pose`` (4, 4); return its state."""
    track.frames_unseen += 1
    track.motion = track.motion.unseen()
    lost = track.frames_unseen > track.options.update.lost_frames
    track.lost = lost and not track_options.continue_lost
    track.confidence = max(0.0, track.confidence - track.options.confidence.regain)
    state: State = "lost" if lost else "occluded"
    at = track.motion.poses[-1] if pose is None else pose
    return TrackState(at, 0.0, verdict.inliers, 0.0, 0, state)


def _trust(
    track: Track, observation: Observation, features: Evidence, strays: bool, cap: float
) -> None:
    """Update the confidence from this fit and earlier frames, with a maximum of ``cap``."""
    options, isolated = track.options, observation.given.isolated
    likely = likelihood(features, track.body, options=options.confidence)
    if isolated and observation.fit.cost < options.update.teach_cost:
        more = features.cost - track.usual_cost
        track.usual_cost += options.update.usual_cost_rate * more
        track.frames_alone += 1
    regain = options.confidence.regain_scanned if track.scanned else options.confidence.regain
    track.astray = (track.astray and not isolated) or (
        strays and (not isolated or bool(observation.view.people))
    )
    if track.astray:
        cap = min(cap, options.update.astray_confidence)
    track.confidence = min(likely, track.confidence + regain, cap)


def _strays(track: Track, view: View, found: Association) -> bool:
    """Return whether a doubtful object without distinctive colours is far from its predictions.

    A bending object has no shape to distinguish it from an arm.  An object that was at rest or
    among people, and is found elsewhere while occluded, may be a similar object.
    """
    if found.restarts_motion and (view.people or track.motion.rested is not None):
        return True
    options = track.options.update
    known = track.has_colour_key and not view.people
    if known or track.large or track.confidence > options.astray_confidence:
        return False
    centre = track.motion.centre[None]
    at = transform(found.registration.pose, centre)[0]
    expected = transform_each(track.motion.predictions, centre)[:, 0]
    off = np.linalg.norm(expected - at, axis=1).min()
    return bool(off > options.astray_radii * track.model.radius)


def _move(track: Track, found: Association, verdict: Verdict) -> None:
    """Update the motion of an object with its found pose."""
    # If the last frame restarted the motion as well, the object moved between both.
    options, fit = track.options.update, found.registration
    scrap = (
        track.large and track.last.points < options.scrap_share * track.size and not track.scanned
    )
    if scrap or (found.restarts_motion and not track.motion.is_unknown):
        track.motion = track.motion.begin(fit.pose)
    else:
        sure = track.large or fit.cost < options.motion_cost
        track.motion = track.motion.add(fit.pose, sure=sure)
    trusted = track.confidence >= track.options.smoothing.sure
    if track.hand_sized and trusted and is_clearly_visible(track, verdict, track.last.points):
        track.motion = track.motion.seen(track.unit)


def is_clearly_visible(track: Track, verdict: Verdict, count: int) -> bool:
    """Return whether a small object with ``count`` points is clear enough to decide if it rests.

    An object that turned or moved away has fewer points, but its motion is certain if visible.
    """
    options = track.options
    if track.motion.rests(track.unit):
        return count > options.update.clear_share * track.size
    in_sight = (
        verdict.visible > options.update.clear_share
        and verdict.inliers > options.update.reappear_share
    )
    return in_sight and count > options.track.hardly_share * track.size


def _seen(track: Track, view: View, fit: Registration, verdict: Verdict) -> bool:
    """Return whether the object was found; an occluded one must reappear clearly."""
    options = track.options.update
    clear = fit.cost < options.motion_cost and verdict.inliers > options.reappear_share
    if view.lens is None and np.array_equal(fit.pose, track.motion.poses[-1]):
        clear = verdict.inliers > options.stayed_share
    return verdict.found and (track.frames_unseen == 0 or track.large or clear)


def hides(
    track: Track, view: View, fit: Registration, given: LabelledPoints, inliers: float
) -> bool:
    """Return whether the found points occlude a small object instead of being the object.

    They fit poorly and have few colours of the painted object or its known surface.  Points of a
    component alone in the air are excluded.
    """
    options = track.options
    if track.carrier is not None and _has_clothes_colours(track, view.colour(given.claim.indices)):
        return True
    clear = fit.cost < options.update.motion_cost and inliers > options.update.reappear_share
    fits = fit.cost < options.update.teach_cost or clear
    if not track.has_colour_key or fits or given.isolated:
        return False
    colour = view.colour(given.claim.indices)
    if not track.appearance.unlike(colour):
        return False
    known = ColourHistogram.of(
        track.model.colour[track.model.hits >= options.surface.sure_hits], track.options.appearance
    )
    return known.likeness(colour) < known.usual - options.update.hiding_log_colour


def _has_clothes_colours(track: Track, colour: F32) -> bool:
    """Return whether too few of the colours (M, 3) are a carried object's instead of clothes'."""
    options = track.options.body
    over = track.over_clothes(colour)
    clear = np.count_nonzero(over > options.distinct_log)
    return bool(clear < options.carried_share * len(colour))


def _learnable_points(track: Track, observation: Observation) -> LabelledPoints:
    """Return the points for the model to learn.

    New points explained by an unlabelled mover, or of new colours, are excluded: an object may be
    held where it bends.
    """
    view, fit, given = observation.view, observation.fit, observation.given
    if given.isolated or track.large:
        return given
    found = given.claim
    keep = found.gap < track.options.surface.new_spacings * track.model.spacing
    new = np.flatnonzero(~keep)
    keep[new] = ~track.strange(view.colour(found.indices[new]))
    if not track.bends:
        keep[new] &= unexplained(track, view, fit, found.indices[new])
    return replace(given, claim=found.pick(keep))
