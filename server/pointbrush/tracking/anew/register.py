"""Predict and register: the search window, hypotheses and fit of each track.

The steps are those of `auto`, which read a track and change nothing.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pointbrush.tracking.anew.label import Labelling, label
from pointbrush.tracking.anew.priors import NextOptions
from pointbrush.tracking.anew.track import Track
from pointbrush.tracking.compute.graph import pieces
from pointbrush.tracking.compute.rigid import excess, transform, transform_each
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.scene.depth import Background
from pointbrush.tracking.sensors.sights import any_of
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import claim
from pointbrush.tracking.steps.predict import crop, share_out
from pointbrush.tracking.steps.propose import alike, turned_at
from pointbrush.tracking.steps.register import find
from pointbrush.tracking.steps.verdict import judge, look

Fits = dict[int, Registration]


def register(tracks: Mapping[int, Track], view: View, background: Background, free: Mask) -> Fits:
    """Return the registration of each track at the best of its predictions and proposals."""
    cut = {n: crop(track.as_auto, view, background, free) for n, track in tracks.items()}
    searches = {n: search for n, search in cut.items() if search is not None}
    shared = share_out(searches, options=view.options.search)
    return {n: find(search) for n, search in shared.items()}


def resolve(
    tracks: Mapping[int, Track],
    fits: Fits,
    labels: Labelling,
    view: View,
    background: Background,
    free: Mask,
    options: NextOptions,
) -> tuple[Fits, Labelling]:
    """Register tracks again that lost most points to others, in the points left for them."""
    relocate = view.options.relocate
    for n in sorted(labels.shares, key=lambda n: _kept(labels, n)):
        if _kept(labels, n) >= relocate.kept_share:
            continue
        left = free & ~labels.taken(len(view.xyz), but=n)
        search = crop(tracks[n].as_auto, view, background, left)
        if search is None:
            continue
        tried = fits | {n: find(search)}
        again = label(tracks, tried, view, background, free, options)
        cheaper = tried[n].cost < fits[n].cost
        anothers = _kept(labels, n) < relocate.others_share and cheaper
        gain = relocate.others_share if anothers else relocate.gain
        if _count(again, n) > gain * _count(labels, n):
            fits, labels = tried, again
    return fits, labels


def _count(labels: Labelling, n: int) -> int:
    return len(labels.shares[n].claim.indices) if n in labels.shares else 0


def _kept(labels: Labelling, n: int) -> float:
    """Return the share of the points a track would have without other tracks that it has."""
    return _count(labels, n) / (labels.shares[n].alone + 1)


def relocated(
    track: Track,
    fit: Registration | None,
    labels: Labelling,
    view: View,
    background: Background,
    free: Mask,
) -> Registration | None:
    """Return a better registration of a doubtful track among unexplained movers; None: none."""
    options = track.options
    left = free & ~labels.taken(len(view.xyz), but=track.label)
    points = np.flatnonzero(left)
    far, still = background.static(view, points)
    points = points[~(far | still)]
    best, most = None, options.relocate.clear_cost
    if fit is not None:
        most = min(most, options.relocate.better_ratio * fit.cost)
    last = track.motion.poses[-1]
    places = [turned_at(track.model, last, at) for at in _clusters(track, view, points)]
    searches = [crop(track.as_auto, view, background, left, some) for some in places]
    likely = [search for search in searches if search is not None]
    likely.sort(key=lambda search: float(search.costs.min()))
    for search in likely[: options.relocate.tries]:
        new = find(search)
        beside = excess(new.world[None], search.target, track.unit, options=options.register)
        cost = new.cost + float(beside[0])
        if cost < most and _is_it(track, view, new):
            best, most = new, cost
    return best


def is_doubtful(track: Track, fit: Registration | None, labels: Labelling, view: View) -> bool:
    """Return whether a track may be elsewhere, so that the whole frame is searched."""
    options = track.options.relocate
    if track.lost or (track.motion.rested is not None and hidden_at_rest(track, view)):
        return False
    if fit is None:
        return True
    share = labels.shares.get(track.label)
    if share is None or _kept(labels, track.label) < options.others_share:
        return True
    return fit.cost >= options.doubt or _is_scrap(track, fit, len(share.claim.indices))


def off_predictions(track: Track, fit: Registration) -> float:
    """Return the distance (m) of a fit from all predictions."""
    centre = track.motion.centre[None]
    at, expected = transform(fit.pose, centre), transform_each(track.motion.predictions, centre)
    return float(np.linalg.norm(expected[:, 0] - at, axis=1).min())


def hidden_at_rest(track: Track, view: View) -> bool:
    """Return whether the resting place of a track is occluded or unmeasured."""
    options, count = track.options, len(track.model.xyz)
    some = np.arange(0, count, max(1, count // options.search.coarse_points))
    at = look(track.as_auto, view, some, track.motion.resting_pose[None])
    measured = any_of(np.isfinite(view.depth[cell]) for cell, _ in view.project(at.world[0]))
    shown = at.seen[0] & measured
    return float(shown.mean()) < options.register.open_share * float(at.facing[0])


def _is_scrap(track: Track, fit: Registration, count: int) -> bool:
    """Return whether too little of a track shows at a place far from its predictions."""
    return (
        off_predictions(track, fit) > track.model.radius
        and count < track.options.relocate.shown_far_share * track.size
    )


def _is_it(track: Track, view: View, fit: Registration) -> bool:
    options, reach = track.options, track.options.claim.reaches * track.reach
    found = claim(view, fit.near, fit.world, track.model.colour, track.weight, reach)
    found = found.pick(found.cost < options.claim.reaches_coloured * track.reach)
    if _is_scrap(track, fit, len(found.indices)):
        return False
    verdict = judge(track.as_auto, view, fit.pose, fit.world, found)
    colours = track.appearance.share(view.colour(found.indices))
    return (
        verdict.found
        and verdict.inliers > options.relocate.matched_share
        and colours > options.relocate.painted_colours_share
    )


def _clusters(track: Track, view: View, points: I64) -> list[F64]:
    """Return centres (3,) of components in the track's colours, the most likely sizes first."""
    options = track.options
    if track.weight > 0.0:
        points = points[alike(track.model, view.colour(points), options.propose)]
    if not len(points):
        return []
    xyz = view.xyz[points].astype(np.float64)
    piece = pieces(xyz, track.unit, options=options.link)
    size = np.bincount(piece)
    low, high = options.relocate.size_share_min, options.relocate.size_share_max
    fitting = np.flatnonzero((size >= low * track.size) & (size <= high * track.size))
    order = np.argsort(np.abs(np.log(size[fitting] / track.size)), kind="stable")
    some = fitting[order][: options.propose.clusters].tolist()
    return [xyz[piece == one].mean(axis=0) for one in some]
