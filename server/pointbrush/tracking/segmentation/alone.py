"""What hangs together with a thing alone in the air: it is the thing, new surface and all.

A hand that throws or catches it is kept out by asking what was there, unlabelled, in the last
frame, and whether what hangs together ends there, or goes on behind something nearer to the sensor.
"""

from __future__ import annotations

import numpy as np

from pointbrush.tracking.interface import I64, Mask
from pointbrush.tracking.objects.place import Place
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.segmentation.assign import cut_off
from pointbrush.tracking.segmentation.connectivity import Limits, blob
from pointbrush.tracking.segmentation.explained import step_of, was_there
from pointbrush.tracking.sensor.view import View

STEP = 2.5
"""Units from point to point of what hangs together in the air, or was uncovered."""
STEPS, STEPS_UNKNOWN, KNOWN = 20, 40, 4
"""Such steps from what is known of a thing to its end at most; twice as many before it was seen
alone in the air so many times: painted end on, most of its length is not known."""
NEW, NEW_ROAMING, NEW_LEAST, NEW_EVER = 0.5, 1.2, 10, 1.8
"""New surface at most: a share of the points that are known, a larger one before a lidar on the
move, which sees new sides in every frame, and a few more; and, with them, of the thing's size."""
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


def whole(thing: Thing, view: View, place: Place, core: I64, taken: Mask, free: Mask) -> I64 | None:
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
    steps = STEPS if thing.in_the_air.frames >= KNOWN else STEPS_UNKNOWN
    reach = STEP * thing.unit
    limits = Limits(reach, steps, len(near) if flies else most, lo + reach, hi - reach)
    new = blob(view, core, near, limits)
    if new is None or not len(new):
        return new
    step = step_of(thing, place)
    # What bends beyond doubt is held by somebody, who goes along with it.
    before = was_there(thing, view, new, step if thing.pliant else None)
    # Painted end on, it has many times the points that are known.
    along = len(new) <= most or was_there(thing, view, new, step).mean() >= ALONG
    others = taken[new].any()
    its = along and not (others or _may_be_a_hand(thing, view, place, core, new, before))
    if not (its or others):
        place.cut_short = _ends_all_round(thing, view, core, new, before)
        its = place.cut_short and thing.last.cut_short
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
    known = thing.in_the_air.frames >= KNOWN
    if known or view.lens is None or thing.motion.slow(thing.unit):
        return False
    if _share_there(thing, view, new, before) >= MISSED:
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
        before = was_there(thing, view, new, step_of(thing, place))
    return _share_there(thing, view, new, before) >= WAS_CUT


def _share_there(thing: Thing, view: View, new: I64, before: Mask) -> float:
    """Share of points ``new`` (M,) that were there ``before`` (M,); 0 where nothing is known."""
    asked = thing.rivals.asked(view.xyz[new]) | thing.dyed
    return float(before[asked].mean()) if asked.any() else 0.0
