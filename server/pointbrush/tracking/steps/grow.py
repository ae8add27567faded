"""New surface beside claimed points, and the whole of an object alone in the air."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from pointbrush.tracking.compute.graph import pieces
from pointbrush.tracking.compute.grid import bounds, close_to, within
from pointbrush.tracking.compute.rigid import transform
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.registration import Registration, no_points
from pointbrush.tracking.model.surface import carved
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.association import Association, Associations, LabelledPoints
from pointbrush.tracking.steps.claim import claim, cut_off, flying, outline, together
from pointbrush.tracking.steps.connectivity import Limits, blob, connected
from pointbrush.tracking.steps.context import contested, step_of, unexplained, was_there


def own_points(track: Track, view: View, fit: Registration) -> Association:
    """Claim points like the model at its place, and not more like something unlabelled."""
    # What is beside a large object is told by what hangs together.
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
    not_its |= _hardly(view, fit)[near.indices] & (
        (near.cost > track.reach) | (track.model.hits[near.nearest] < options.surface.sure_hits)
    )
    beyond = track.reach if track.large else track.unit
    unlike = near.cost > track.reach + (options.claim.reaches_coloured - 1) * beyond
    unlike &= near.gap > options.claim.shaded_reaches * track.reach
    if not track.painted.flat:  # The ground touches what stands on it, and goes on.
        not_its |= view.low[near.indices] & (near.gap > options.claim.foot_reaches * track.reach)
    found = near.pick(
        ~not_its & ~unlike & (near.gap < track.reach + (options.claim.reaches - 1) * beyond)
    )
    # A pose is never exact: what lies on well confirmed surface is not asked.
    firm = (track.model.hits[found.nearest] >= options.surface.sure_hits) & (
        found.gap < options.claim.firm_reaches * track.reach
    )
    found = found.pick(firm | ~_carved(track, view, fit, found.indices))
    return Association(fit, found, neutral)


def _hardly(view: View, fit: Registration) -> Mask:
    """(N,) points that hardly stand out against the background."""
    hardly = np.zeros(len(view.xyz), np.bool_)
    hardly[fit.faint] = True
    return hardly


def _carved(track: Track, view: View, fit: Registration, points: I64) -> Mask:
    """Mark the points (M,) where earlier views looked through; none where the pose is not sure."""
    if not track.stiff or fit.cost > track.options.claim.sharp_cost:
        return np.zeros(len(points), np.bool_)
    return carved(track.carving_views, view, fit.pose, points, track.unit)


@dataclass(frozen=True, slots=True, eq=False)
class Grown:
    """Label → points of each track; ``taken`` (N,) those that some track has."""

    labelled: dict[int, LabelledPoints]
    taken: Mask


def grow(tracks: Mapping[int, Track], associations: Associations) -> Grown:
    """Add moving points that hang together with an object, free and no track's, to its claim.

    Of all but large objects.  Claims lose their flying pixels, which are other movers of nothing.
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
    beside = _adjoin(track, view, fit, core, rest)
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
    """Test whether an object has moved, or turned, within the frames that are remembered."""
    away = transform(fit.pose, track.ends) - transform(track.motion.poses[0], track.ends)
    return bool(np.abs(away).max() > track.options.register.rest_units * track.unit)


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
    if track.motion.fresh or track.motion.rests(track.unit):
        return found
    points = found.points
    kept = ~flying(view, points, track.unit)
    return found if kept.all() else _kept(found, kept, points[~kept])


def _kept(found: LabelledPoints, kept: Mask, neutral: I64) -> LabelledPoints:
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
    """The points of what is slow without flying pixels.

    Its rim takes in missed outline, and flying pixels if painted with them.
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
        found = replace(_kept(found, ~flies, own[:0]), rim=together(missed, own[flies]))
    else:
        found = replace(_kept(found, ~flies, own[flies]), rim=missed)
        taken[own[flies]] = False
    taken[missed] = True
    return found


def _adjoin(track: Track, view: View, fit: Registration, core: I64, rest: I64) -> I64:
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
    """Connected component of moving points around a claim, if it ends all round.

    ``points`` (M,) of it beside the claim, None where it is not one object; the others as of
    ``LabelledPoints``.
    """

    points: I64 | None
    isolated: bool = False
    end_on: bool = False
    neutral: I64 = field(default_factory=no_points)


def closed_component(
    track: Track, view: View, fit: Registration, core: I64, taken: Mask, free: Mask
) -> ClosedComponent:
    """Find the component of moving points around the claimed ones ``core`` (C,), if it is closed.

    ``taken`` (N,) some track has; ``free`` (N,) the run may take.
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
    before = was_there(track, view, new)
    # Painted in part, it has many times the points that are known.
    along = len(new) <= most or (
        was_there(track, view, new, step_of(track, fit)).mean() >= options.along_share
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
    """Test whether ``new`` surface (M,) is the length of an object of which an end was painted.

    It makes a moving object, not yet seen alone often enough, much longer, and ends all round.
    Beside tracked people it may be a part of one of them.  A hand has other colours, goes on behind
    something else than the object, or most of it was there in the last frame, unlabelled, as
    ``before`` (M,) of the new surface was.
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
    """Standard deviation (m) of ``points`` (M,) along the direction in which they are longest."""
    return float(np.sqrt(np.linalg.norm(np.cov(view.xyz[points].T), 2)))


def _searched(
    track: Track, view: View, fit: Registration, other: Mask, most: int
) -> tuple[I64, Limits]:
    """Points (M,) of ``other`` (N,) that may be connected with a track, and the limits of that.

    What is on the move before a camera may be longer than it is known to be, and have more than
    ``most`` new points.
    """
    options = track.options.growth
    slow = track.motion.slow(track.unit)
    around, (lo, hi) = fit.around, fit.box
    if view.lens is not None and not slow:
        longer = options.longer_radii * track.model.radius
        lo, hi = lo - longer, hi + longer
        around = view.box(lo, hi)
    near = around[other[around]]
    flies = view.lens is not None and not (track.motion.fresh or slow)
    reach = options.step_units * track.unit
    most = len(near) if flies else most
    known = track.frames_alone >= options.known_frames
    steps = options.max_steps if known else options.max_steps_unknown
    return near, Limits(reach, steps, most, lo + reach, hi - reach)


def _may_be_a_hand(
    track: Track, view: View, fit: Registration, core: I64, new: I64, before: Mask
) -> bool:
    """Whether new surface may be what throws or catches an object: that was there, unlabelled, in
    the last frame, as ``before`` (M,) of it was.  An arm goes on beyond where that was looked for;
    of what has no colours to be known by, only what lies there tells.

    A sensor that moves sees new sides all the time, and what it missed once it may see again.

    What goes on behind something nearer, and has not the colours that the object was painted with,
    may be a hand though its arm is hidden: it has gone along, or has just come.
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
        before = was_there(track, view, new, step_of(track, fit))
    return _share_there(track, view, new, before) >= options.was_there_share_cut


def _share_there(track: Track, view: View, new: I64, before: Mask) -> float:
    """Share of points ``new`` (M,) that were there ``before`` (M,); 0 where nothing is known."""
    asked = track.other_movers.asked(view.xyz[new]) | track.has_colour_key
    return float(before[asked].mean()) if asked.any() else 0.0
