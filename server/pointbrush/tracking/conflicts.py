"""Claims in conflict: tracks that lose points to others, or come out of hiding."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from pointbrush.tracking.interface import I64
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.people.bodies import reclaim, recognised, undisputed
from pointbrush.tracking.scene.depth import Background
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import Associations, decide, without
from pointbrush.tracking.steps.predict import crop
from pointbrush.tracking.steps.relocate import register_and_claim
from pointbrush.tracking.steps.verdict import judge


def settle_conflicts(tracks: Mapping[int, Track], associations: Associations) -> None:
    """Let claims share no point; an object that lost most of its is looked for in what is left."""
    view, fits = associations.view, associations.fits
    before, claims = (
        associations.claims,
        undisputed(associations.claims, tracks, options=associations.view.options.body),
    )
    decided = decide(len(view.xyz), claims)
    for label in sorted(fits, key=lambda n: len(decided[n].indices) / (len(before[n].indices) + 1)):
        if len(decided[label].indices) >= associations.view.options.relocate.kept_share * len(
            before[label].indices
        ):
            continue
        others = [found for other, found in decided.items() if other != label]
        left = without(associations.free, others)
        search = crop(tracks[label], view, associations.background, left)
        if search is None:
            continue
        fit, claim = register_and_claim(tracks[label], view, search)
        again = {**claims, label: claim}
        better = decide(len(view.xyz), again)
        points_before, points_after = len(decided[label].indices), len(better[label].indices)
        # Where nearly all is another's, the other is, and not the object.
        anothers = (
            points_before
            < associations.view.options.relocate.others_share * len(before[label].indices)
            and fit.cost < fits[label].cost
        )
        if (
            points_after
            > (
                associations.view.options.relocate.others_share
                if anothers
                else associations.view.options.relocate.gain
            )
            * points_before
        ):
            decided, claims, fits[label] = better, again, fit
    for label in fits:
        share = len(decided[label].indices) / max(len(claims[label].indices), 1)
        associations.note(label, undisputed=share)
    associations.claims = decided


def look_for(
    absent: Iterable[Track], tracks: Mapping[int, Track], associations: Associations
) -> dict[int, I64]:
    """Find large objects that were hidden in what the claims of the others leave.

    ``associations`` take in those that were found; label → points (M,) where the others may be.
    """
    view, background = associations.view, associations.background
    loose: dict[int, I64] = {}
    free = associations.unclaimed()
    for track in absent:
        search = None if track.lost else crop(track, view, background, free)
        if search is None:
            continue
        fit, found = register_and_claim(track, view, search)
        seen = judge(track, view, fit.pose, fit.world, found).found
        if view.lens is not None and len(found.indices):
            seen = seen and _surely(track.label, tracks, background, view, found.indices)
        if seen:
            associations.put(track.label, fit, found)
            free[found.indices] = False
        else:
            loose[track.label] = search.moving
    return loose


def _surely(
    label: int, tracks: Mapping[int, Track], background: Background, view: View, points: I64
) -> bool:
    """Whether a large object that was hidden is there: it shows where and as it was last seen, or
    before a known scene, in its own clothes."""
    options = view.options.relocate
    if float((background.again(view, points) == label).mean()) > options.shown_share:
        return True
    certain = float(background.certain(view, points).mean()) > options.shown_share
    return certain and recognised(label, tracks, view, points)


def bodies_left(
    loose: Mapping[int, I64],
    tracks: Mapping[int, Track],
    associations: Associations,
    grown: Mapping[int, I64],
) -> dict[int, I64]:
    """The bodies no one has of objects so changed that they have to be learnt anew.

    ``loose``: the points where each of them may be.
    """
    if not loose:
        return {}
    view = associations.view
    moving = np.unique(np.concatenate(list(loose.values())))
    left = without(np.ones(len(view.xyz), np.bool_), associations.claims.values())
    for points in grown.values():
        left[points] = False
    moving = moving[left[moving] & associations.background.certain(view, moving)]
    return reclaim(view, {label: tracks[label] for label in loose}, moving)
