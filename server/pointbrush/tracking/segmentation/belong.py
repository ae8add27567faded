"""Which points of a frame are a thing's: those near its model, and new surface beside it.

What a hand that holds a thing shows of itself moves as the thing does.  It is kept out by what
was unlabelled in the last frame (``Thing.rivals``).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pointbrush.tracking.geometry.near import close_to
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.objects.free_space import carved
from pointbrush.tracking.objects.model import SURE
from pointbrush.tracking.objects.place import Place
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.segmentation.alone import STEP, whole
from pointbrush.tracking.segmentation.assign import Claim, claim, together
from pointbrush.tracking.segmentation.connectivity import connected
from pointbrush.tracking.segmentation.explained import contested, unexplained
from pointbrush.tracking.segmentation.findings import Findings
from pointbrush.tracking.segmentation.flying_pixels import flying
from pointbrush.tracking.segmentation.outline import outline
from pointbrush.tracking.segmentation.regain import lost_pieces
from pointbrush.tracking.sensor.view import View

REACH, UNLIKE = 2.2, 3.5
"""A model claims points this many reaches away, in place; and in place and colour.  Of a small
thing all but the first are units: where its model is coarse, a hand beside it is not."""
SHADED = 1.2
"""Reaches from the model, in place, within which no colour is too unlike: it may be shaded."""
STILL = 1.5
"""Reaches, in place and colour, within which also what has not moved may be the thing's."""
FIRM = 0.9
"""Reaches from well confirmed surface within which a point is the thing's in any case."""
FOOT = 0.6
"""The same, within which what lies on the ground before a lidar on the move may be the thing's."""
SHARP = 0.2
"""Cost of a fit up to which its pose tells places beside the thing apart."""
WIDE = 5.0
"""New points within this many reaches of a model are not held against it later."""
STRIP = 20
"""Steps by which the surface that another object uncovers may go on in a frame."""
FEWEST = 5
"""Points of a claim beside which new surface is looked for."""
BY_COLOUR, BY_COLOUR_BENT = 2.0, 3.0
"""Units, in place and colour, from point to point of new surface beside something else."""
PALE, STEPS_BENT = 0.2, 8
"""Share of the usual weight of colour for what bends, which is shaded anew, and the steps that its
new surface may go on by in a frame: one, if it does not bend."""
LABELS = 2**16
"""Labels that there can be."""
SAMPLE, TOUCH = 2000, 3.0
"""Points of a thing of which its border is told, and units within which others touch them."""
MAINLY = 0.3
"""Share of what another object uncovers from which it may be a thing's."""


def own_points(thing: Thing, view: View, place: Place) -> Claim:
    """Points like the model at its place, and not more like something unlabelled."""
    # What is beside a large thing is told by what hangs together.
    wide = (REACH if thing.large else WIDE) * thing.reach
    near = claim(view, place.near, place.world, thing.model.colour, thing.weight, wide)
    not_its = contested(view, near, thing, place)
    place.neutral = near.indices[~not_its]
    not_its &= near.cost > thing.reach
    moving = np.zeros(len(view.xyz), np.bool_)
    moving[place.moving] = True
    if view.roams:
        moving |= view.low
    not_its |= ~moving[near.indices] & (near.cost > STILL * thing.reach)
    not_its |= _hardly(view, place)[near.indices] & (
        (near.cost > thing.reach) | (thing.model.hits[near.nearest] < SURE)
    )
    beyond = thing.reach if thing.large else thing.unit
    unlike = near.cost > thing.reach + (UNLIKE - 1) * beyond
    unlike &= near.gap > SHADED * thing.reach
    if not thing.painted.flat:  # The ground touches what stands on it, and goes on.
        not_its |= view.low[near.indices] & (near.gap > FOOT * thing.reach)
    found = near.pick(~not_its & ~unlike & (near.gap < thing.reach + (REACH - 1) * beyond))
    # A pose is never exact: what lies on well confirmed surface is not asked.
    firm = (thing.model.hits[found.nearest] >= SURE) & (found.gap < FIRM * thing.reach)
    return found.pick(firm | ~_carved(thing, view, place, found.indices))


def _hardly(view: View, place: Place) -> Mask:
    """(N,) points that hardly stand out against the background."""
    hardly = np.zeros(len(view.xyz), np.bool_)
    hardly[place.faint] = True
    return hardly


def grow(things: Mapping[int, Thing], findings: Findings) -> tuple[dict[int, I64], Mask]:
    """New surface: moving points that hang together with a thing, free and nobody's.

    Of all but large things; and which points (N,) somebody has then.  Claims lose their flying
    pixels, which are rivals of nothing.
    """
    view, background, free = findings.view, findings.background, findings.free
    places, claims = findings.places, findings.claims
    taken = ~findings.unclaimed()
    shown, hider = background.uncovered(view)
    grown: dict[int, I64] = {}
    for label, place in places.items():
        thing, core = things[label], claims[label].indices
        rest = place.moving[~taken[place.moving]]
        if len(core) < FEWEST or thing.large:
            continue
        new = whole(thing, view, place, core, taken, free) if len(rest) else None
        place.whole = new is not None
        if new is None:
            new = _adjoin(thing, view, place, core, rest)
            mine = (hider != label) & ~taken[shown]
            place.uncovered = together(
                _shown(thing, view, core, shown[mine], hider[mine]),
                lost_pieces(thing, view, place, core, taken, background),
            )
            new = together(new, place.uncovered)
        taken[new] = True
        claims[label], grown[label] = _solid(thing, view, place, claims[label], new)
    for label in grown:
        claims[label], grown[label] = _outlined(things[label], findings, grown[label], taken)
    for label, new in grown.items():
        if not things[label].dyed:
            own, rest = np.concatenate([claims[label].indices, new]), places[label].moving
            places[label].border = _border(view, own, rest[~taken[rest]], things[label].unit)
    return grown, taken


def _border(view: View, own: I64, rest: I64, unit: float) -> float:
    """Share of a thing's points ``own`` (M,) that touch some of the ``rest`` (N,)."""
    some = view.xyz[own[:: max(1, len(own) // SAMPLE)]]
    return float(close_to(some, view.xyz[rest], TOUCH * unit).mean()) if len(some) else 0.0


def _solid(thing: Thing, view: View, place: Place, found: Claim, new: I64) -> tuple[Claim, I64]:
    """A claim and new surface of what is on the move without flying pixels.

    Thin parts and rims of what stays in its place are known; of what has just been painted little
    is known but that it is there.
    """
    if thing.motion.fresh or thing.motion.rests(thing.unit):
        return found, new
    count = len(found.indices)
    points = np.concatenate([found.indices, new])
    kept = ~flying(view, points, thing.unit)
    if kept.all():
        return found, new
    place.neutral = np.concatenate([place.neutral, points[~kept]])
    return found.pick(kept[:count]), new[kept[count:]]


def _outlined(thing: Thing, findings: Findings, new: I64, taken: Mask) -> tuple[Claim, I64]:
    """The claim and new surface of what is slow without flying pixels.

    ``Place.rim`` takes in what was missed at its outline, and those if it was painted with them.
    """
    view, background = findings.view, findings.background
    place, found = findings.places[thing.label], findings.claims[thing.label]
    if view.lens is None or not thing.motion.slow(thing.unit):
        return found, new
    own = np.concatenate([found.indices, new])
    rest = place.around[~taken[place.around]]
    rest = rest[~background.static(view, rest)[0] | background.faint(view, rest)]
    flies, rim = outline(view, own, rest, thing.unit)
    count = len(found.indices)
    place.rim = rest[rim]
    if thing.painted.with_flying:
        place.rim = together(place.rim, own[flies])
    else:
        place.neutral = np.concatenate([place.neutral, own[flies]])
        taken[own[flies]] = False
    taken[rest[rim]] = True
    return found.pick(~flies[:count]), new[~flies[count:]]


def _carved(thing: Thing, view: View, place: Place, points: I64) -> Mask:
    if thing.bends or thing.soft or thing.large or place.cost > SHARP:
        return np.zeros(len(points), np.bool_)
    return carved(thing.glimpses, view, place.pose, points, thing.unit)


def _adjoin(thing: Thing, view: View, place: Place, core: I64, rest: I64) -> I64:
    """Points beside the core, of its colour, that nothing unlabelled explains."""
    colour = view.colour(rest)
    own = thing.distinct(colour)
    may = own | (unexplained(thing, view, place, rest) & ~thing.strange(colour))
    rest, own = rest[may], own[may]
    weight = thing.weight * (PALE if thing.bends else 1.0)
    joined = connected(
        _placed(view, core, weight),
        _placed(view, rest, weight),
        (BY_COLOUR_BENT if thing.bends else BY_COLOUR) * thing.unit,
        STEPS_BENT if thing.bends else 1,
    )
    if own.any():  # Nothing else has its colours: it goes on as far as they do.
        front = np.concatenate([core, rest[joined]])
        more = np.flatnonzero(own & ~joined)
        at, beside = (view.xyz[points].astype(np.float64) for points in (front, rest[more]))
        on = connected(at, beside, BY_COLOUR * thing.unit, STRIP)
        joined[more[on]] = True
    return rest[joined]


def _shown(thing: Thing, view: View, core: I64, shown: I64, hider: I64) -> I64:
    """What others uncovered of a thing at rest: it hangs together with it, alike in colour.

    It has to be a good part of all that the other, its ``hider``, uncovered: beside a thing in
    a hand that is mostly what holds it, and whom.
    """
    if thing.bends or not thing.motion.rests(thing.unit):
        return shown[:0]
    front, rest = (_placed(view, points, thing.weight) for points in (core, shown))
    joined = connected(front, rest, STEP * thing.unit, STRIP)
    own, every = (np.bincount(h, minlength=LABELS) for h in (hider[joined], hider))
    return np.asarray(shown[joined & (own > MAINLY * every)[hider]])


def _placed(view: View, indices: I64, weight: float) -> F64:
    """(M, 6) place and weighted colour."""
    return np.hstack([view.xyz[indices], view.colour(indices) * weight]).astype(np.float64)
