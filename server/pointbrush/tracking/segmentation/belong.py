"""Which points of a frame are a thing's: those near its model, and new surface beside it.

What a hand that holds a thing shows of itself moves as the thing does.  It is kept out by what
was unlabelled in the last frame (``Thing.rivals``), and by asking whether what hangs together
ends there, or goes on behind something nearer to the sensor.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pointbrush.tracking.geometry.near import close_to
from pointbrush.tracking.geometry.registration import inverse, transform
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.objects.free_space import carved
from pointbrush.tracking.objects.model import SURE
from pointbrush.tracking.objects.place import Place
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.segmentation.assign import Claim, claim, cut_off, together
from pointbrush.tracking.segmentation.connectivity import Limits, blob, connected
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
STEP = 2.5
"""Units from point to point of what hangs together in the air, or was uncovered."""
STEPS, STEPS_UNKNOWN, KNOWN = 20, 40, 4
"""Such steps from what is known of a thing to its end at most; twice as many before it was seen
alone in the air so many times: painted end on, most of its length is not known."""
BY_COLOUR, BY_COLOUR_BENT = 2.0, 3.0
"""Units, in place and colour, from point to point of new surface beside something else."""
PALE, STEPS_BENT = 0.2, 8
"""Share of the usual weight of colour for what bends, which is shaded anew, and the steps that its
new surface may go on by in a frame: one, if it does not bend."""
NEW, NEW_ROAMING, NEW_LEAST, NEW_EVER = 0.5, 1.2, 10, 1.8
"""New surface at most: a share of the points that are known, a larger one before a lidar on the
move, which sees new sides in every frame, and a few more; and, with them, of the thing's size."""
EXPLAINED = 4.0
"""Units from something unlabelled within which it explains a point beside a thing."""
LABELS = 2**16
"""Labels that there can be."""
SAMPLE, TOUCH = 2000, 3.0
"""Points of a thing of which its border is told, and units within which others touch them."""
MAINLY = 0.3
"""Share of what another object uncovers from which it may be a thing's."""
YIELD = 0.7
"""Share of its cost at which something unlabelled takes a point from a claim."""
AGAIN = 7.0
"""Units within which something unlabelled is taken to be where it was."""
BESIDE = 12.0
"""Units from a soft thing within which what is beside it goes along with it."""
STAYED = 0.25
"""Units by which a thing moves that stays where it is."""
LONGER = 2.0
"""Radii beyond where a thing on the move was looked for in which it may end: painted end on, it is
longer than its model."""
ALONG = 0.75
"""Share of new surface, many times what is known, that was beside a thing and has gone along."""
WAS_CUT, WAS_OPEN = 0.2, 0.7
"""Share of new surface that may have been there, unlabelled, in the last frame: where something
nearer cuts it off, and where it stands free."""
MISSED = 0.6
"""The same, of a part that was missed: it turns, and a hand that holds it hardly does."""
END_ON = 2.0
"""Times its known length that a thing has at least which was painted end on."""
WORN = 0.7
"""Share of its colours from which new surface has those that the thing was painted with."""
STRANGE, MUCH = 0.5, 0.05
"""Share of its colours that the thing did not show where it was painted, and its size as a share of
the thing's, from which new surface may be a hand: an end or a stripe of it is smaller."""


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
        new = _whole(thing, view, place, core, taken, free) if len(rest) else None
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


def contested(view: View, found: Claim, thing: Thing, place: Place) -> Mask:
    """Which claimed points are more like something known to be unlabelled."""
    return _explained(thing, view, place, found.indices, YIELD * found.cost.astype(np.float64))


def unexplained(thing: Thing, view: View, place: Place, points: I64) -> Mask:
    """Which points nothing unlabelled explains, where it was or gone along with the thing."""
    return ~_explained(thing, view, place, points, np.full(len(points), EXPLAINED * thing.unit))


def _explained(thing: Thing, view: View, place: Place, points: I64, reach: F64) -> Mask:
    if view.roams:  # What stands still is known, and nobody holds what is seen from the road.
        return np.zeros(len(points), np.bool_)
    xyz, colour = view.xyz[points].astype(np.float64), view.colour(points)
    explained = thing.rivals.explain(xyz, colour, reach, step_of(thing, place))
    if thing.soft and len(thing.rivals.xyz):  # Each part of it has a motion of its own.
        before = transform(thing.motion.poses[-1], thing.model.xyz)
        bent = thing.rivals.along(before, place.world, BESIDE * thing.unit)
        explained |= bent.explain(xyz, colour, reach)
    return explained


def step_of(thing: Thing, place: Place) -> F64 | None:
    """How a thing has moved (4, 4) since it was seen; None where that is next to nothing."""
    last = thing.motion.poses[-1]
    ends = thing.ends
    if np.abs(transform(place.pose, ends) - transform(last, ends)).max() < STAYED * thing.unit:
        return None
    return place.pose @ inverse(last)


def _carved(thing: Thing, view: View, place: Place, points: I64) -> Mask:
    if thing.bends or thing.soft or thing.large or place.cost > SHARP:
        return np.zeros(len(points), np.bool_)
    return carved(thing.glimpses, view, place.pose, points, thing.unit)


def _whole(
    thing: Thing, view: View, place: Place, core: I64, taken: Mask, free: Mask
) -> I64 | None:
    """The rest of a closed blob around the core, None where it is not one object."""
    if thing.bends:
        return None
    other = free.copy()
    other[core] = False
    more = NEW_ROAMING if view.roams else NEW
    most = int(max(more * len(core) + NEW_LEAST, NEW_EVER * thing.size - len(core)))
    around, (lo, hi) = place.around, place.box
    if view.lens is not None and not thing.motion.slow(thing.unit):
        lo, hi = lo - LONGER * thing.model.radius, hi + LONGER * thing.model.radius
        around = view.box(lo, hi)
    near = around[other[around]]
    flies = view.lens is not None and not (thing.motion.fresh or thing.motion.slow(thing.unit))
    steps = STEPS if thing.alone >= KNOWN else STEPS_UNKNOWN
    reach = STEP * thing.unit
    limits = Limits(reach, steps, len(near) if flies else most, lo + reach, hi - reach)
    new = blob(view, core, near, limits)
    if new is None or not len(new):
        return new
    step = step_of(thing, place)
    # What bends beyond doubt is held by somebody, who goes along with it.
    before = _was_there(thing, view, new, step if thing.pliant else None)
    # Painted end on, it has many times the points that are known.
    along = len(new) <= most or _was_there(thing, view, new, step).mean() >= ALONG
    others = taken[new].any()
    its = along and not (others or _may_be_a_hand(thing, view, place, core, new, before))
    if not (its or others):
        place.cut_short = _ends_all_round(thing, view, core, new, before)
        its = place.cut_short and thing.cut_short
    if its:
        return new
    if along:
        place.neutral = np.concatenate([place.neutral, new[~before]])
    return None


def _ends_all_round(thing: Thing, view: View, core: I64, new: I64, before: Mask) -> bool:
    """Whether new surface that makes a thing on the move much longer ends all round, while the
    thing was not yet seen alone: then it may have been painted end on.

    A part that was missed was there, unlabelled, in the last frame (``before`` (M,)), and would
    be taken for a hand from then on.  A hand was there for the most part, or goes on behind
    something else than the thing.
    """
    may = thing.alone < KNOWN and view.lens is not None and not thing.motion.slow(thing.unit)
    if not may or _share_there(thing, view, new, before) >= MISSED:
        return False
    own = np.concatenate([core, new])
    if _length(view, own) <= END_ON * _length(view, core):
        return False
    return not cut_off(view, new, thing.unit, ~view.marked(own))


def _length(view: View, points: I64) -> float:
    """Standard deviation (m) of ``points`` (M,) along the way in which they are longest."""
    return float(np.sqrt(np.linalg.norm(np.cov(view.xyz[points].T), 2)))


def _may_be_a_hand(
    thing: Thing, view: View, place: Place, core: I64, new: I64, before: Mask
) -> bool:
    """Whether new surface may be what throws or catches a thing: that was there, unlabelled, in the
    last frame, as ``before`` (M,) of it was.  An arm goes on beyond where that was looked for; of
    what has no colours to be known by, only what lies there tells.

    A sensor that moves sees new sides all the time, and what it missed once it may see again.

    What goes on behind something nearer, and has not the colours that the thing was painted with,
    may be a hand though its arm is hidden: it has gone along, or has just come.
    """
    if view.roams:
        return False
    if not cut_off(view, new, thing.unit):
        return _share_there(thing, view, new, before) >= WAS_OPEN
    colour = view.colour(new)
    if len(new) > MUCH * len(core) and thing.strange(colour).mean() > STRANGE:
        return True
    if thing.worn.share(colour) < WORN or thing.worn.unlike(colour):
        before = _was_there(thing, view, new, step_of(thing, place))
    return _share_there(thing, view, new, before) >= WAS_CUT


def _share_there(thing: Thing, view: View, new: I64, before: Mask) -> float:
    """Share of points ``new`` (M,) that were there ``before`` (M,); 0 where nothing is known."""
    asked = thing.rivals.asked(view.xyz[new]) | thing.dyed
    return float(before[asked].mean()) if asked.any() else 0.0


def _was_there(thing: Thing, view: View, points: I64, step: F64 | None = None) -> Mask:
    """Which points lie where something unlabelled was in the last frame, or has gone by ``step``
    since."""
    reach, xyz = np.full(len(points), AGAIN * thing.unit), view.xyz[points].astype(np.float64)
    return thing.rivals.explain(xyz, view.colour(points), reach, step)


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
