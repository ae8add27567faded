"""New surface beside claimed points."""

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
from pointbrush.tracking.steps.alone import whole
from pointbrush.tracking.steps.claim import Claim, Findings, claim, flying, outline, together
from pointbrush.tracking.steps.connectivity import connected
from pointbrush.tracking.steps.context import contested, unexplained
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


def grow(tracks: Mapping[int, Track], findings: Findings) -> tuple[dict[int, I64], Mask]:
    """New surface: moving points that hang together with an object, free and no track's.

    Of all but large objects; and which points (N,) a person has then.  Claims lose their flying
    pixels, which are other movers of nothing.
    """
    view, background, free = findings.view, findings.background, findings.free
    fits, claims = findings.fits, findings.claims
    taken = ~findings.unclaimed()
    shown, hider = background.uncovered(view)
    grown: dict[int, I64] = {}
    for label, fit in list(fits.items()):
        track, core = tracks[label], claims[label].indices
        rest = fit.moving[~taken[fit.moving]]
        if len(core) < findings.view.options.claim.min_claim_points or track.large:
            continue
        new = None
        if len(rest):
            new, fit = whole(track, view, fit, core, taken, free)
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
        claims[label], grown[label] = _outlined(tracks[label], findings, grown[label], taken)
    for label, new in grown.items():
        if not tracks[label].dyed:
            own, rest = np.concatenate([claims[label].indices, new]), fits[label].moving
            border = _border(view, own, rest[~taken[rest]], tracks[label].unit)
            findings.note(label, border=border)
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


def _outlined(track: Track, findings: Findings, new: I64, taken: Mask) -> tuple[Claim, I64]:
    """The claim and new surface of what is slow without flying pixels.

    The rim of its registration takes in missed outline, and flying pixels if painted with them.
    """
    view, background = findings.view, findings.background
    fit, found = findings.fits[track.label], findings.claims[track.label]
    if view.lens is None or not track.motion.slow(track.unit):
        return found, new
    own = np.concatenate([found.indices, new])
    rest = fit.around[~taken[fit.around]]
    rest = rest[~background.static(view, rest)[0] | background.faint(view, rest)]
    flies, rim = outline(view, own, rest, track.unit)
    count = len(found.indices)
    missed = rest[rim]
    if track.painted.with_flying:
        findings.note(track.label, rim=together(missed, own[flies]))
    else:
        neutral = np.concatenate([fit.neutral, own[flies]])
        findings.note(track.label, rim=missed, neutral=neutral)
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
        _placed(view, core, weight),
        _placed(view, rest, weight),
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
    """Return what others uncovered of an object at rest: it hangs together with it, alike in
    colour.

    It has to be a good part of all that the other, its ``hider``, uncovered: beside an object in
    a hand that is mostly what holds it, and whom.
    """
    options = track.options
    if track.bends or not track.motion.rests(track.unit):
        return shown[:0]
    front, rest = (_placed(view, points, track.weight) for points in (core, shown))
    joined = connected(
        front,
        rest,
        options.growth.step_units * track.unit,
        options.claim.uncovered_steps,
    )
    own, every = (np.bincount(h, minlength=LABELS) for h in (hider[joined], hider))
    return np.asarray(shown[joined & (own > options.claim.uncovered_share * every)[hider]])


def _placed(view: View, indices: I64, weight: float) -> F64:
    """(M, 6) place and weighted colour."""
    return np.hstack([view.xyz[indices], view.colour(indices) * weight]).astype(np.float64)
