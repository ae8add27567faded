"""New surface beside claimed points, and whole objects alone in the air."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from pointbrush.tracking.compute.graph import pieces
from pointbrush.tracking.compute.grid import bounds, close_to, within
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.registration import Registration, no_points
from pointbrush.tracking.model.surface import carved
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.association import Association, Associations, LabelledPoints
from pointbrush.tracking.steps.claim import claim, cut_off, flying, outline, together
from pointbrush.tracking.steps.connectivity import Limits, blob, connected
from pointbrush.tracking.steps.context import contested, explained_by_movers, step_of, unexplained


def own_points(track: Track, view: View, fit: Registration) -> Association:
    """Return the claim on points near the model that no unlabelled object explains better."""
    # Points beside a large object are decided by connectivity.
    options = track.options
    wide = (options.claim.reaches if track.large else options.claim.new_reaches) * track.reach
    near = claim(view, fit.near, fit.world, track.model.colour, track.weight, wide)
    not_its = contested(view, near, track, fit)
    neutral = near.indices[~not_its]
    not_its &= near.cost > track.reach
    moving = np.zeros(len(view.xyz), np.bool_)
    moving[fit.moving] = True
    if view.roams:
        moving |= view.low
    not_its |= ~moving[near.indices] & (near.cost > options.claim.still_reaches * track.reach)
    not_its |= _barely_in_front(view, fit)[near.indices] & (
        (near.cost > track.reach) | (track.model.hits[near.nearest] < options.surface.sure_hits)
    )
    beyond = track.reach if track.large else track.unit
    unlike = near.cost > track.reach + (options.claim.reaches_coloured - 1) * beyond
    unlike &= near.gap > options.claim.shaded_reaches * track.reach
    if not track.painted.flat:  # The ground touches objects on it, and continues.
        not_its |= view.low[near.indices] & (near.gap > options.claim.foot_reaches * track.reach)
    found = near.pick(
        ~not_its & ~unlike & (near.gap < track.reach + (options.claim.reaches - 1) * beyond)
    )
    # Poses are inexact: points on well confirmed surface are claimed in any case.
    firm = (track.model.hits[found.nearest] >= options.surface.sure_hits) & (
        found.gap < options.claim.firm_reaches * track.reach
    )
    found = found.pick(firm | ~_carved(track, view, fit, found.indices))
    return Association(fit, found, neutral)


def _barely_in_front(view: View, fit: Registration) -> Mask:
    """Return a mask (N,) of points barely in front of the background."""
    result = np.zeros(len(view.xyz), np.bool_)
    result[fit.faint] = True
    return result


def _carved(track: Track, view: View, fit: Registration, points: I64) -> Mask:
    """Mark the points (M,) where earlier views saw through; none if the pose is uncertain."""
    if not track.stiff or fit.cost > track.options.claim.sharp_cost:
        return np.zeros(len(points), np.bool_)
    return carved(track.carving_views, view, fit.pose, points, track.unit)


@dataclass(frozen=True, slots=True, eq=False)
class Grown:
    """Points of each track by label; ``taken`` (N,): mask of points of any track."""

    labelled: dict[int, LabelledPoints]
    taken: Mask


def grow(tracks: Mapping[int, Track], associations: Associations) -> Grown:
    """Add free moving points connected to an object to its claim, except for large objects.

    Claims lose their flying pixels, which are no evidence of another moving object.
    """
    view = associations.view
    taken = ~associations.unclaimed()
    labelled = {n: LabelledPoints.of(view, one) for n, one in associations.found.items()}
    grown: list[int] = []
    for label, association in associations.found.items():
        track, few = tracks[label], view.options.claim.min_claim_points
        if len(association.claim.indices) >= few and not track.large:
            found = _with_new(track, associations, labelled[label], taken)
            taken[found.grown] = True
            labelled[label] = _solid(track, view, found)
            grown.append(label)
    for label in grown:
        labelled[label] = _outlined(tracks[label], associations, labelled[label], taken)
    return Grown(labelled, taken)


def _with_new(
    track: Track,
    associations: Associations,
    found: LabelledPoints,
    taken: Mask,
) -> LabelledPoints:
    """New surface beside a claim: a closed component, or what adjoins.

    ``taken`` (N,) points that some track has.
    """
    view = associations.view
    fit, core = associations.found[track.label].registration, found.claim.indices
    rest = fit.moving[~taken[fit.moving]]
    if len(rest):
        component = closed_component(track, view, fit, core, taken, associations.free)
        found = replace(
            found,
            neutral=np.concatenate([found.neutral, component.neutral]),
            isolated=component.isolated,
            end_on=component.end_on,
        )
        if component.points is not None:
            return replace(found, grown=component.points)
    beside = _adjoining_points(track, view, fit, core, rest)
    if track.rigid:
        beside = together(np.sort(beside), _new_sides(track, view, fit, core, rest))
    return replace(found, grown=beside)


def _new_sides(track: Track, view: View, fit: Registration, core: I64, rest: I64) -> I64:
    """Select the pieces of the free moving points ``rest`` (R,) that are new sides of an object.

    A side begins beside the claimed points ``core`` (C,), ends all round, has no more points than
    they, and is flat and broader than a hand.  An arm goes on, and a hand is round.
    """
    options = track.options.growth
    if view.lens is None or fit.cost > options.side_cost or not _turned(track, fit):
        return rest[:0]
    xyz, reach = view.xyz[core].astype(np.float64), options.side_units * track.unit
    lo, hi = bounds(xyz)
    margin = reach + options.side_radii * track.model.radius
    rest = rest[within(view.xyz[rest], lo - margin, hi + margin)]
    if not len(rest):
        return rest
    at = view.xyz[rest].astype(np.float64)
    inside = within(at, lo - margin + reach, hi + margin - reach)
    beside = close_to(at, xyz, reach)
    sides = np.zeros(len(rest), np.bool_)
    number = pieces(at, track.unit, track.options.link)
    for n in np.unique(number[beside]).tolist():
        own = number == n
        some = options.new_points < np.count_nonzero(own) < len(core)
        sides |= own & (some and inside[own].all() and _flat_and_broad(track, at[own]))
    return np.sort(rest[sides])


def _turned(track: Track, fit: Registration) -> bool:
    """Test whether an object has turned enough, within the remembered poses, to show new sides.

    Background that an object uncovers is flat and beside it, too.
    """
    turn = fit.pose[:3, :3] @ track.motion.poses[0][:3, :3].T
    cosine = np.clip((np.trace(turn) - 1) / 2, -1, 1)
    return bool(np.degrees(np.arccos(cosine)) > track.options.growth.side_turn_deg)


def _flat_and_broad(track: Track, xyz: F64) -> bool:
    """Test whether points (M, 3) lie in a plane, and are spread farther in it than a hand's."""
    options = track.options.growth
    spread = np.sqrt(np.maximum(np.linalg.eigvalsh(np.cov(xyz.T)), 0.0))
    return bool(spread[0] < options.flat_units * track.unit and spread[1] > options.hand_m)


def _solid(track: Track, view: View, found: LabelledPoints) -> LabelledPoints:
    """The points of what is on the move without flying pixels.

    Thin parts and rims of what stays in its place are known; of what has just been painted little
    is known but that it is there.
    """
    if track.motion.is_unknown or track.motion.rests(track.unit):
        return found
    points = found.points
    kept = ~flying(view, points, track.unit)
    return found if kept.all() else _pick_points(found, kept, points[~kept])


def _pick_points(found: LabelledPoints, kept: Mask, neutral: I64) -> LabelledPoints:
    """The points that are ``kept`` (M,), and more that are ``neutral``."""
    count = len(found.claim.indices)
    return replace(
        found,
        claim=found.claim.pick(kept[:count]),
        grown=found.grown[kept[count:]],
        neutral=np.concatenate([found.neutral, neutral]),
    )


def _outlined(
    track: Track, associations: Associations, found: LabelledPoints, taken: Mask
) -> LabelledPoints:
    """Return a slow object's points without flying pixels.

    Its rim includes missed pixels of the outline, and flying pixels if painted with them.
    """
    view, background = associations.view, associations.background
    fit = associations.found[track.label].registration
    if view.lens is None or not track.motion.slow(track.unit):
        return found
    own = found.points
    rest = fit.around[~taken[fit.around]]
    rest = rest[~background.static(view, rest)[0] | background.faint(view, rest)]
    flies, rim = outline(view, own, rest, track.unit)
    missed = rest[rim]
    if track.painted.with_flying:
        found = replace(_pick_points(found, ~flies, own[:0]), rim=together(missed, own[flies]))
    else:
        found = replace(_pick_points(found, ~flies, own[flies]), rim=missed)
        taken[own[flies]] = False
    taken[missed] = True
    return found


def _adjoining_points(track: Track, view: View, fit: Registration, core: I64, rest: I64) -> I64:
    """Points beside the core, of its colour, that nothing unlabelled explains."""
    options = track.options.claim
    colour = view.colour(rest)
    own = track.distinct(colour)
    own |= track.over_clothes(colour) > track.options.body.distinct_log
    may = own | (unexplained(track, view, fit, rest) & ~track.strange(colour))
    rest, own = rest[may], own[may]
    weight = track.weight * (options.bent_colour_weight if track.bends else 1.0)
    joined = connected(
        _place_and_colour(view, core, weight),
        _place_and_colour(view, rest, weight),
        (options.coloured_units_bent if track.bends else options.coloured_units) * track.unit,
        options.bent_steps if track.bends else 1,
    )
    if own.any():  # Nothing else has its colours: it goes on as far as they do.
        front = np.concatenate([core, rest[joined]])
        more = np.flatnonzero(own & ~joined)
        at, beside = (view.xyz[points].astype(np.float64) for points in (front, rest[more]))
        on = connected(at, beside, options.coloured_units * track.unit, options.own_colour_steps)
        joined[more[on]] = True
    return rest[joined]


def _place_and_colour(view: View, indices: I64, weight: float) -> F64:
    """(M, 6) place and weighted colour."""
    return np.hstack([view.xyz[indices], view.colour(indices) * weight]).astype(np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class ClosedComponent:
    """Connected component of moving points around a claim.

    ``points`` (M,): its points beside the claim, None if it is not a single isolated object; other
    fields: see ``LabelledPoints``.
    """

    points: I64 | None
    isolated: bool = False
    end_on: bool = False
    neutral: I64 = field(default_factory=no_points)


def closed_component(
    track: Track, view: View, fit: Registration, core: I64, taken: Mask, free: Mask
) -> ClosedComponent:
    """Return the component of moving points around the claimed points ``core`` (C,).

    ``taken`` (N,): mask of points of any track; ``free`` (N,): mask of points the run may take.
    """
    options, other = track.options.growth, free.copy()
    if track.bends:
        return ClosedComponent(None)
    other[core] = False
    more = options.new_share_moving_scanner if view.roams else options.new_share
    most = int(
        max(
            more * len(core) + options.new_points,
            options.new_size_share * track.size - len(core),
        )
    )
    new = blob(view, core, *_searched(track, view, fit, other, most))
    if new is None or not len(new):
        return ClosedComponent(new, isolated=new is not None)
    before = explained_by_movers(track, view, new)
    # An object painted in part has many times the known points.
    along = len(new) <= most or (
        explained_by_movers(track, view, new, step_of(track, fit)).mean() >= options.along_share
    )
    neutral = new[~before] if along else new[:0]
    if taken[new].any():
        return ClosedComponent(None, neutral=neutral)
    if along and not _may_be_a_hand(track, view, fit, core, new, before):
        return ClosedComponent(new, isolated=True)
    if _painted_end_on(track, view, core, new, before):
        return ClosedComponent(new, isolated=True, end_on=True)
    return ClosedComponent(None, neutral=neutral)


def _painted_end_on(track: Track, view: View, core: I64, new: I64, before: Mask) -> bool:
    """Return whether ``new`` surface (M,) is the length of an object that was painted end on.

    It makes a moving object, not yet seen alone often enough, much longer, and is isolated.  Beside
    tracked people it may be part of a person.  A hand has other colours, continues behind another
    surface than the object, or was mostly there, unlabelled, in the last frame: ``before`` (M,).
    """
    options = track.options.growth
    known = track.frames_alone >= options.known_frames or track.motion.slow(track.unit)
    if view.lens is None or known or view.people or not track.has_colour_key:
        return False
    if track.strange(view.colour(new)).mean() > options.strange_colours_share:
        return False
    whole = np.concatenate([core, new])
    if cut_off(view, new, track.unit, ~view.marked(whole)):
        return False
    if _share_there(track, view, new, before) >= options.was_there_share_end_on:
        return False
    return _length(view, whole) > options.end_on_ratio * _length(view, core)


def _length(view: View, points: I64) -> float:
    """Return the standard deviation (m) of ``points`` (M,) along their longest axis."""
    return float(np.sqrt(np.linalg.norm(np.cov(view.xyz[points].T), 2)))


def _searched(
    track: Track, view: View, fit: Registration, other: Mask, most: int
) -> tuple[I64, Limits]:
    """Return points (M,) of ``other`` (N,) that may be connected with a track, and the limits.

    A moving object in front of a camera may be longer than known, and have more than ``most`` new
    points.
    """
    options = track.options.growth
    slow = track.motion.slow(track.unit)
    around, (lo, hi) = fit.around, fit.box
    if view.lens is not None and not slow:
        longer = options.longer_radii * track.model.radius
        lo, hi = lo - longer, hi + longer
        around = view.box(lo, hi)
    near = around[other[around]]
    flies = view.lens is not None and not (track.motion.is_unknown or slow)
    reach = options.step_units * track.unit
    most = len(near) if flies else most
    known = track.frames_alone >= options.known_frames
    steps = options.max_steps if known else options.max_steps_unknown
    return near, Limits(reach, steps, most, lo + reach, hi - reach)


def _may_be_a_hand(
    track: Track, view: View, fit: Registration, core: I64, new: I64, before: Mask
) -> bool:
    """Return whether new surface may be a hand that throws or catches an object.

    A hand was there, unlabelled, in the last frame: ``before`` (M,) of the new surface.  An arm
    continues beyond the searched box; without distinctive colours only points inside it count.

    A moving sensor sees new sides all the time, and surface missed in earlier frames.  Surface that
    continues behind a nearer one, without the painted colours, may be a hand with a hidden arm.
    """
    options = track.options.growth
    if view.roams:
        return False
    if not cut_off(view, new, track.unit):
        return _share_there(track, view, new, before) >= options.was_there_share_open
    colour = view.colour(new)
    if (
        len(new) > options.strange_size_share * len(core)
        and track.strange(colour).mean() > options.strange_colours_share
    ):
        return True
    painted, least = track.appearance, track.options.appearance.alike_share
    if painted.share(colour) < least or painted.unlike(colour):
        before = explained_by_movers(track, view, new, step_of(track, fit))
    return _share_there(track, view, new, before) >= options.was_there_share_cut


def _share_there(track: Track, view: View, new: I64, before: Mask) -> float:
    """Return the share of points ``new`` (M,) that were there ``before`` (M,); 0 if unknown."""
    is_known = track.other_movers.in_searched_box(view.xyz[new]) | track.has_colour_key
    return float(before[is_known].mean()) if is_known.any() else 0.0
