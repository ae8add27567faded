"""Connected surface of an object alone in the air: all of it is the object's, new surface too.

A hand that throws or catches it is kept out by asking what was there, unlabelled, in the last
frame, and whether what hangs together ends there, or goes on behind something nearer to the sensor.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pointbrush.tracking.interface import I64, Mask
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import cut_off
from pointbrush.tracking.steps.connectivity import Limits, blob
from pointbrush.tracking.steps.context import step_of, was_there


def whole(
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
    around, (lo, hi) = fit.around, fit.box
    if view.lens is not None and not track.motion.slow(track.unit):
        lo, hi = (
            lo - options.longer_radii * track.model.radius,
            hi + options.longer_radii * track.model.radius,
        )
        around = view.box(lo, hi)
    near = around[other[around]]
    flies = view.lens is not None and not (track.motion.fresh or track.motion.slow(track.unit))
    steps = (
        options.max_steps
        if track.seen_alone.frames >= options.known_frames
        else options.max_steps_unknown
    )
    reach = options.step_units * track.unit
    limits = Limits(reach, steps, len(near) if flies else most, lo + reach, hi - reach)
    new = blob(view, core, near, limits)
    if new is None or not len(new):
        return new, replace(fit, whole=new is not None)
    step = step_of(track, fit)
    # What bends beyond doubt is held by a person, who goes along with it.
    before = was_there(track, view, new, step if track.surely_soft else None)
    # Painted end on, it has many times the points that are known.
    along = len(new) <= most or was_there(track, view, new, step).mean() >= options.along_share
    others = taken[new].any()
    its = along and not (others or _may_be_a_hand(track, view, fit, core, new, before))
    if not (its or others):
        fit = replace(fit, cut_short=_ends_all_round(track, view, core, new, before))
        its = fit.cut_short and track.last.cut_short
    if its:
        return new, replace(fit, whole=True)
    if along:
        fit = replace(fit, neutral=np.concatenate([fit.neutral, new[~before]]))
    return None, fit


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
    asked = track.other_movers.asked(view.xyz[new]) | track.dyed
    return float(before[asked].mean()) if asked.any() else 0.0
