"""New surface beside claimed points, and the whole of an object alone in the air."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pointbrush.tracking.compute.grid import close_to
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.surface import carved
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import (
    Associations,
    Claim,
    claim,
    cut_off,
    flying,
    outline,
    together,
)
from pointbrush.tracking.steps.connectivity import Limits, blob, connected
from pointbrush.tracking.steps.context import contested, step_of, unexplained, was_there
from pointbrush.tracking.steps.pieces import lost_pieces

LABELS = 2**16
"""Labels that there can be."""


def own_points(track: Track, view: View, fit: Registration) -> tuple[Registration, Claim]:
    """Claim points like the model at its place, and not more like something unlabelled."""
    # What is beside a large object is told by what hangs together.
    options = track.options
    wide = (options.claim.reaches if track.large else options.claim.new_reaches) * track.reach
    near = claim(view, fit.near, fit.world, track.model.colour, track.weight, wide)
    not_its = contested(view, near, track, fit)
    fit = replace(fit, neutral=near.indices[~not_its])
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
    return fit, found.pick(firm | ~_carved(track, view, fit, found.indices))


def _hardly(view: View, fit: Registration) -> Mask:
    """(N,) points that hardly stand out against the background."""
    hardly = np.zeros(len(view.xyz), np.bool_)
    hardly[fit.faint] = True
    return hardly


def grow(tracks: Mapping[int, Track], associations: Associations) -> tuple[dict[int, I64], Mask]:
    """New surface: moving points that hang together with an object, free and no track's.

    Of all but large objects; and which points (N,) a person has then.  Claims lose their flying
    pixels, which are other movers of nothing.
    """
    view, background, free = associations.view, associations.background, associations.free
    fits, claims = associations.fits, associations.claims
    taken = ~associations.unclaimed()
    shown, hider = background.uncovered(view)
    grown: dict[int, I64] = {}
    for label, fit in list(fits.items()):
        track, core = tracks[label], claims[label].indices
        rest = fit.moving[~taken[fit.moving]]
        if len(core) < associations.view.options.claim.min_claim_points or track.large:
            continue
        new = None
        if len(rest):
            new, fit = closed_component(track, view, fit, core, taken, free)
        if new is None:
            new = _adjoin(track, view, fit, core, rest)
            mine = (hider != label) & ~taken[shown]
            uncovered = together(
                _shown(track, view, core, shown[mine], hider[mine]),
                lost_pieces(track, view, fit, core, taken, background),
            )
            fit = replace(fit, uncovered=uncovered)
            new = together(new, uncovered)
        taken[new] = True
        fits[label], claims[label], grown[label] = _solid(track, view, fit, claims[label], new)
    for label in grown:
        claims[label], grown[label] = _outlined(tracks[label], associations, grown[label], taken)
    for label, new in grown.items():
        if not tracks[label].has_colour_key:
            own, rest = np.concatenate([claims[label].indices, new]), fits[label].moving
            border = _border(view, own, rest[~taken[rest]], tracks[label].unit)
            associations.note(label, border=border)
    return grown, taken


def _border(view: View, own: I64, rest: I64, unit: float) -> float:
    """Share of an object's points ``own`` (M,) that touch some of the ``rest`` (N,)."""
    options = view.options.claim
    some = view.xyz[own[:: max(1, len(own) // options.border_points)]]
    return (
        float(close_to(some, view.xyz[rest], options.touching_units * unit).mean())
        if len(some)
        else 0.0
    )


def _solid(
    track: Track, view: View, fit: Registration, found: Claim, new: I64
) -> tuple[Registration, Claim, I64]:
    """A claim and new surface of what is on the move without flying pixels.

    Thin parts and rims of what stays in its place are known; of what has just been painted little
    is known but that it is there.
    """
    if track.motion.fresh or track.motion.rests(track.unit):
        return fit, found, new
    count = len(found.indices)
    points = np.concatenate([found.indices, new])
    kept = ~flying(view, points, track.unit)
    if kept.all():
        return fit, found, new
    fit = replace(fit, neutral=np.concatenate([fit.neutral, points[~kept]]))
    return fit, found.pick(kept[:count]), new[kept[count:]]


def _outlined(track: Track, associations: Associations, new: I64, taken: Mask) -> tuple[Claim, I64]:
    """The claim and new surface of what is slow without flying pixels.

    The rim of its registration takes in missed outline, and flying pixels if painted with them.
    """
    view, background = associations.view, associations.background
    fit, found = associations.fits[track.label], associations.claims[track.label]
    if view.lens is None or not track.motion.slow(track.unit):
        return found, new
    own = np.concatenate([found.indices, new])
    rest = fit.around[~taken[fit.around]]
    rest = rest[~background.static(view, rest)[0] | background.faint(view, rest)]
    flies, rim = outline(view, own, rest, track.unit)
    count = len(found.indices)
    missed = rest[rim]
    if track.painted.with_flying:
        associations.note(track.label, rim=together(missed, own[flies]))
    else:
        neutral = np.concatenate([fit.neutral, own[flies]])
        associations.note(track.label, rim=missed, neutral=neutral)
        taken[own[flies]] = False
    taken[rest[rim]] = True
    return found.pick(~flies[:count]), new[~flies[count:]]


def _carved(track: Track, view: View, fit: Registration, points: I64) -> Mask:
    if track.bends or track.soft or track.large or fit.cost > track.options.claim.sharp_cost:
        return np.zeros(len(points), np.bool_)
    return carved(track.carving_views, view, fit.pose, points, track.unit)


def _adjoin(track: Track, view: View, fit: Registration, core: I64, rest: I64) -> I64:
    """Points beside the core, of its colour, that nothing unlabelled explains."""
    options = track.options.claim
    colour = view.colour(rest)
    own = track.distinct(colour)
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
        on = connected(
            at,
            beside,
            options.coloured_units * track.unit,
            options.uncovered_steps,
        )
        joined[more[on]] = True
    return rest[joined]


def _shown(track: Track, view: View, core: I64, shown: I64, hider: I64) -> I64:
    """Collect the points of an object at rest that others have uncovered: connected with it, alike
    in colour.

    It has to be a good part of all that the other, its ``hider``, uncovered: beside an object in
    a hand that is mostly what holds it, and whom.
    """
    options = track.options
    if track.bends or not track.motion.rests(track.unit):
        return shown[:0]
    front, rest = (_place_and_colour(view, points, track.weight) for points in (core, shown))
    joined = connected(
        front,
        rest,
        options.growth.step_units * track.unit,
        options.claim.uncovered_steps,
    )
    own, every = (np.bincount(h, minlength=LABELS) for h in (hider[joined], hider))
    return np.asarray(shown[joined & (own > options.claim.uncovered_share * every)[hider]])


def _place_and_colour(view: View, indices: I64, weight: float) -> F64:
    """(M, 6) place and weighted colour."""
    return np.hstack([view.xyz[indices], view.colour(indices) * weight]).astype(np.float64)


def closed_component(
    track: Track, view: View, fit: Registration, core: I64, taken: Mask, free: Mask
) -> tuple[I64 | None, Registration]:
    """Return the rest of a closed blob around the core, None where it is not one object.

    And the registration with what that tells.
    """
    options = track.options.growth
    if track.bends:
        return None, fit
    other = free.copy()
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
        return new, replace(fit, isolated=new is not None)
    step = step_of(track, fit)
    # What bends beyond doubt is held by a person, who goes along with it.
    before = was_there(track, view, new, step if track.surely_soft else None)
    # Painted end on, it has many times the points that are known.
    along = len(new) <= most or was_there(track, view, new, step).mean() >= options.along_share
    others = taken[new].any()
    its = along and not (others or _may_be_a_hand(track, view, fit, core, new, before))
    if not (its or others):
        fit = replace(fit, growth_refused=_ends_all_round(track, view, core, new, before))
        its = fit.growth_refused and track.last.growth_refused
    if its:
        return new, replace(fit, isolated=True)
    if along:
        fit = replace(fit, neutral=np.concatenate([fit.neutral, new[~before]]))
    return None, fit


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
    known = track.seen_alone.frames >= options.known_frames
    steps = options.max_steps if known else options.max_steps_unknown
    reach = options.step_units * track.unit
    return near, Limits(reach, steps, len(near) if flies else most, lo + reach, hi - reach)


def _ends_all_round(track: Track, view: View, core: I64, new: I64, before: Mask) -> bool:
    """Whether new surface that makes an object on the move much longer ends all round, while the
    object was not yet seen alone: then it may have been painted end on.

    A part that was missed was there, unlabelled, in the last frame (``before`` (M,)), and would
    be taken for a hand from then on.  A hand was there for the most part, or goes on behind
    something else than the object.
    """
    options = track.options.growth
    known = track.seen_alone.frames >= options.known_frames
    if known or view.lens is None or track.motion.slow(track.unit):
        return False
    if _share_there(track, view, new, before) >= options.was_there_share_missed:
        return False
    own = np.concatenate([core, new])
    if _length(view, own) <= options.end_on_ratio * _length(view, core):
        return False
    return not cut_off(view, new, track.unit, ~view.marked(own))


def _length(view: View, points: I64) -> float:
    """Standard deviation (m) of ``points`` (M,) along the way in which they are longest."""
    return float(np.sqrt(np.linalg.norm(np.cov(view.xyz[points].T), 2)))


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
    if track.appearance.share(colour) < options.painted_colours_share or track.appearance.unlike(
        colour
    ):
        before = was_there(track, view, new, step_of(track, fit))
    return _share_there(track, view, new, before) >= options.was_there_share_cut


def _share_there(track: Track, view: View, new: I64, before: Mask) -> float:
    """Share of points ``new`` (M,) that were there ``before`` (M,); 0 where nothing is known."""
    asked = track.other_movers.asked(view.xyz[new]) | track.has_colour_key
    return float(before[asked].mean()) if asked.any() else 0.0
