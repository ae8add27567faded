"""Search in the whole frame for lost tracks."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from pointbrush.tracking.compute.graph import pieces
from pointbrush.tracking.compute.rigid import excess, transform, transform_each
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.scene.depth import Background
from pointbrush.tracking.sensors.sights import any_of
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.association import Association, Associations
from pointbrush.tracking.steps.claim import Claim
from pointbrush.tracking.steps.grow import own_points
from pointbrush.tracking.steps.predict import Search, crop
from pointbrush.tracking.steps.propose import alike, turned_at
from pointbrush.tracking.steps.register import find
from pointbrush.tracking.steps.verdict import judge, look


def find_astray(
    tracks: Iterable[Track], astray: dict[int, int], associations: Associations
) -> Associations:
    """Search for ``tracks`` with a poor fit or none; return the associations with found ones.

    ``astray``: number of frames, by label, in which an object was far from its predictions; updated
    in place.
    """
    view, background = associations.view, associations.background
    some = [track for track in tracks if _is_astray(track, astray, associations)]
    if not some:
        return associations
    left = associations.unclaimed(but={track.label for track in some})
    points = np.flatnonzero(left)
    far, still = background.static(view, points)
    points = points[~(far | still)]
    for track in some:
        before = _own_registration(track, associations)
        found = _best_fit(track, background, view, left, points[left[points]], before)
        if found is not None and not (track.carrier and _is_beyond_reach(track, found)):
            associations = associations.put(track.label, found)
            left[found.claim.indices] = False
            astray.pop(track.label, None)
    return associations


def _is_astray(track: Track, astray: dict[int, int], associations: Associations) -> bool:
    """Return whether to search for an object in this frame, and count its frames in doubt."""
    options = track.options.relocate
    view, fit = associations.view, _own_registration(track, associations)
    if view.lens is None or track.lost or not track.rigid:
        return False
    if track.motion.rested is not None and _hidden_at_rest(track, view):
        return False
    if fit is not None and fit.cost < options.doubt:
        astray.pop(track.label, None)
        return False
    count = astray[track.label] = astray.get(track.label, 0) + 1
    return (
        count <= options.patient_frames or (view.number + track.label) % options.retry_frames == 0
    )


def _hidden_at_rest(track: Track, view: View) -> bool:
    """Return whether the resting place of an object is occluded or unmeasured.

    The object is then assumed to be there, and not at a similar object.
    """
    options = track.options
    count = len(track.model.xyz)
    some = np.arange(0, count, max(1, count // options.search.coarse_points))
    at = look(track, view, some, track.motion.resting_pose[None])
    measured = any_of(np.isfinite(view.depth[cell]) for cell, _ in view.project(at.world[0]))
    shown = at.seen[0] & measured
    return float(shown.mean()) < options.register.open_share * float(at.facing[0])


def _own_registration(track: Track, associations: Associations) -> Registration | None:
    """Return the registration of an object.

    None: it is on another object's points, or shows too little far from its predictions.
    """
    found = associations.found.get(track.label)
    if found is None or found.undisputed < track.options.relocate.others_share:
        return None
    return None if _is_scrap(track, found) else found.registration


def _prediction_distance(track: Track, found: Association) -> float:
    """Return the distance (m) of a found object from all its predictions."""
    at = transform(found.registration.pose, track.motion.centre[None])
    return float(np.linalg.norm(_predicted_centres(track) - at, axis=1).min())


def _is_beyond_reach(track: Track, found: Association) -> bool:
    """Return whether a carried object was found beyond its carrier's arm length."""
    return _prediction_distance(track, found) > track.options.relocate.arm_m


def _is_scrap(track: Track, found: Association) -> bool:
    """Return whether too little of an object shows at a place far from its predictions."""
    return bool(
        _prediction_distance(track, found) > track.model.radius
        and len(found.claim.indices) < track.options.relocate.shown_far_share * track.size
    )


def _predicted_centres(track: Track) -> F64:
    """Return (K, 3) predicted centres of an object."""
    return transform_each(track.motion.predictions, track.motion.centre[None])[:, 0]


def _best_fit(
    track: Track,
    background: Background,
    view: View,
    left: Mask,
    points: I64,
    before: Registration | None,
) -> Association | None:
    """Return the best fit of the object to clusters of ``points`` (M,).

    None: it is not good, or not much better than ``before``.
    """
    options = track.options
    best, most = None, options.relocate.clear_cost
    if before is not None:
        most = min(most, options.relocate.better_ratio * before.cost)
    last = track.motion.poses[-1]
    hypotheses = [turned_at(track.model, last, at) for at in _clusters(track, view, points)]
    searches = [crop(track, view, background, left, some) for some in hypotheses]
    likely = [search for search in searches if search is not None]
    for search in sorted(likely, key=lambda search: float(search.costs.min()))[
        : options.relocate.tries
    ]:
        fit = find(search)
        beside = excess(fit.world[None], search.target, track.unit, options=options.register)
        cost = fit.cost + float(beside[0])
        if cost >= most:
            continue
        found = own_points(track, view, fit)
        if _is_scrap(track, found):
            continue
        verdict = judge(track, view, fit.pose, fit.world, found.claim)
        if (
            verdict.found
            and verdict.inliers > options.relocate.matched_share
            and _looks_like(track, view, found.claim)
        ):
            best = replace(found, restarts_motion=_is_elsewhere(track, fit, before))
            most = cost
    return best


def _looks_like(track: Track, view: View, claim: Claim) -> bool:
    """Return whether claimed points have the colours of the painted object, unlike an arm."""
    return (
        track.appearance.share(view.colour(claim.indices))
        > track.options.relocate.painted_colours_share
    )


def _is_elsewhere(track: Track, fit: Registration, before: Registration | None) -> bool:
    """Return whether an object is at another place than ``before``, instead of only rotated."""
    if before is None:
        return True
    place, former = (transform(at.pose, track.model.centre[None]) for at in (fit, before))
    return float(np.linalg.norm(place - former)) > track.model.radius


def _clusters(track: Track, view: View, points: I64) -> list[F64]:
    """Return centres (3,) of components in the object's colours, the most likely sizes first."""
    options = track.options
    if track.weight > 0.0:
        points = points[alike(track.model, view.colour(points), options.propose)]
        points = points[track.over_clothes(view.colour(points)) >= 0.0]
    if not len(points):
        return []
    xyz = view.xyz[points].astype(np.float64)
    piece = pieces(xyz, track.unit, options=options.link)
    size = np.bincount(piece)
    fitting = np.flatnonzero(
        (size >= options.relocate.size_share_min * track.size)
        & (size <= options.relocate.size_share_max * track.size)
    )
    order = np.argsort(np.abs(np.log(size[fitting] / track.size)), kind="stable")
    return [
        xyz[piece == one].mean(axis=0)
        for one in fitting[order][: options.propose.clusters].tolist()
    ]


def register_and_claim(track: Track, view: View, search: Search) -> Association:
    """Register an object and claim its points.

    It claims none if it should be occluded and the found position is too far away.
    """
    fit = find(search)
    if track.body and _far_off(track, search, fit):
        return Association(fit, Claim.nothing())
    return own_points(track, view, fit)


def _far_off(track: Track, search: Search, fit: Registration) -> bool:
    """Return whether a large object is too far from its occluded position to be the same one."""
    options = track.options
    motion = track.motion
    if motion.is_unknown or track.painted.cut:  # a partly painted object grows as it appears
        return False
    centre = motion.centre[None]
    at = transform(fit.pose, centre)[0]
    off = np.linalg.norm(transform_each(search.hypotheses, centre)[:, 0] - at, axis=1).min()
    if off < (options.relocate.hidden_radii * track.span + motion.speed) * motion.gap:
        return False
    hypotheses = transform_each(search.hypotheses, track.model.xyz[search.few])
    hidden = search.view.hides(hypotheses.reshape(-1, 3), options.verdict.hidden_units * track.unit)
    return bool(
        hidden.reshape(len(hypotheses), -1).mean(axis=1).max() > options.relocate.shown_share
    )
