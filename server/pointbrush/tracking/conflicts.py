"""Conflicting claims: tracks that lose points to others, or reappear after an occlusion."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from pointbrush.tracking.interface import I64
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.people.bodies import has_own_colours, reappearing_points, undisputed
from pointbrush.tracking.scene.depth import Background
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.association import Associations, LabelledPoints
from pointbrush.tracking.steps.claim import decide, without
from pointbrush.tracking.steps.predict import crop
from pointbrush.tracking.steps.relocate import register_and_claim
from pointbrush.tracking.steps.verdict import judge


def settle_conflicts(tracks: Mapping[int, Track], associations: Associations) -> Associations:
    """Make claims disjoint; an object that loses most points is searched for in free points."""
    view, options = associations.view, associations.view.options.relocate
    found, before = dict(associations.found), associations.claims
    claims = undisputed(before, tracks, options=view.options.body)
    owned = decide(len(view.xyz), claims)
    for label in sorted(found, key=lambda n: len(owned[n].indices) / (len(before[n].indices) + 1)):
        kept, all_ = len(owned[label].indices), len(before[label].indices)
        if kept >= options.kept_share * all_:
            continue
        others = [claim for other, claim in owned.items() if other != label]
        left = without(associations.free, others)
        search = crop(tracks[label], view, associations.background, left)
        if search is None:
            continue
        elsewhere = register_and_claim(tracks[label], view, search)
        relocated = {**claims, label: elsewhere.claim}
        better = decide(len(view.xyz), relocated)
        # If another track has nearly all points, that track is there and not this object.
        cheaper = elsewhere.registration.cost < found[label].registration.cost
        anothers = kept < options.others_share * all_ and cheaper
        gain = options.others_share if anothers else options.gain
        if len(better[label].indices) > gain * kept:
            owned, claims, found[label] = better, relocated, elsewhere
    settled = {
        label: replace(
            one,
            claim=owned[label],
            undisputed=len(owned[label].indices) / max(len(claims[label].indices), 1),
        )
        for label, one in found.items()
    }
    return replace(associations, found=settled)


def look_for(
    absent: Iterable[Track], tracks: Mapping[int, Track], associations: Associations
) -> tuple[Associations, dict[int, I64]]:
    """Find large occluded objects among unclaimed points.

    Returns the associations with the found ones, and by label the points (M,) where each of the
    others may be.
    """
    view, background = associations.view, associations.background
    loose: dict[int, I64] = {}
    free = associations.unclaimed()
    for track in absent:
        search = None if track.lost else crop(track, view, background, free)
        if search is None:
            continue
        one = register_and_claim(track, view, search)
        fit, points = one.registration, one.claim.indices
        seen = judge(track, view, fit.pose, fit.world, one.claim).found
        if view.lens is not None and len(points):
            seen = seen and _has_reappeared(track.label, tracks, background, view, points)
        if seen:
            associations = associations.put(track.label, one)
            free[points] = False
        else:
            loose[track.label] = search.moving
    return associations, loose


def _has_reappeared(
    label: int, tracks: Mapping[int, Track], background: Background, view: View, points: I64
) -> bool:
    """Return whether an occluded large object has certainly reappeared.

    It shows at its last position and depth, or in front of a known scene in its own colours.
    """
    options = view.options.relocate
    if float((background.reappearing_labels(view, points) == label).mean()) > options.shown_share:
        return True
    certain = float(background.certain(view, points).mean()) > options.shown_share
    return certain and has_own_colours(label, tracks, view, points)


def bodies_left(
    loose: Mapping[int, I64],
    tracks: Mapping[int, Track],
    associations: Associations,
    labelled: Mapping[int, LabelledPoints],
) -> dict[int, I64]:
    """Return by label the unclaimed bodies of objects that changed too much to be registered.

    ``loose``: points where each object may be, by label.
    """
    if not loose:
        return {}
    view = associations.view
    moving = np.unique(np.concatenate(list(loose.values())))
    left = np.ones(len(view.xyz), np.bool_)
    for found in labelled.values():
        left[found.points] = False
    moving = moving[left[moving] & associations.background.certain(view, moving)]
    return reappearing_points(view, {label: tracks[label] for label in loose}, moving)
