"""What a thing keeps from a frame: its surface, its size, how much it bends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pointbrush.tracking.fitting.fit import bent
from pointbrush.tracking.fitting.judge import ON_SURFACE, Verdict
from pointbrush.tracking.fitting.search import target_of
from pointbrush.tracking.geometry.columns import NONE, columns, nearest
from pointbrush.tracking.geometry.near import bounds, close_to, within
from pointbrush.tracking.geometry.registration import inverse, transform
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.objects.confidence import Evidence
from pointbrush.tracking.objects.model import MOST_BENT, NEW_SURFACE, SURE, Model
from pointbrush.tracking.objects.place import Place
from pointbrush.tracking.objects.thing import DENSE, SOFT, Thing
from pointbrush.tracking.segmentation.assign import Claim, claim
from pointbrush.tracking.sensor.view import View

KNOWN, FEW = 100, 0.005
"""Known points that have to be in sight, and share of them off their place, to ask for it."""
SELDOM, HINT = 4, 0.25
"""Frames in one of which it is asked of a stiff thing, and the share of what makes a thing soft
from which it is asked in all."""
LOOSE = 0.15
"""Cost of a fit from which that is asked in all of a thing that is seen by very many points."""
AGAIN = 1.5
"""Times what makes a thing soft that one frame can say: a wrong pose bends anything, but once. What
very many points show is seldom posed wrongly, and is taken at its word."""
STRETCHED, ONTO = 600, 6000
"""Points at most that are bent to find out, and onto which."""
OFF, ON = 1.5, 1.0
"""Units from the model at which a point is off its place, and on it."""
RIM = (-2, 0, 2)
"""Pixels, up, down and sideways, from which an outline is beside a point."""
SNAP = 0.7
"""Share of its way to the points measured there that a soft thing's surface goes."""
BESIDE = 8.0
"""Units around a thing within which what is left over may be its."""
NEW, NEW_ALONE = 3.0, 8.0
"""Units from the model within which its points and new surface teach it; more where nothing else
is beside it, or where a lidar sees it."""
CERTAIN = 0.8
"""Share of the model found, weighed by what shows, from which its size is learnt."""
PACE, PACE_OF_STRAIN = 0.15, 0.2
"""Weight of a frame in the running means of how much bends, and of how much bending explains."""
FORGOTTEN = 15
"""Frames out of sight after which the surface of what bends is given up."""
SAMPLE = 1000
"""Points whose colours are compared with those worn."""


def evidence(
    thing: Thing, view: View, place: Place, found: Claim, points: I64, verdict: Verdict
) -> Evidence:
    """What the fit says about itself, for its confidence; ``points`` (M,) are assigned."""
    m = max(len(found.indices), 1)
    count = max(len(points), 1)
    some = points[:: max(1, len(points) // SAMPLE)]
    left, others = _beside(thing, view, place, points)
    return Evidence(
        inliers=verdict.inliers,
        sure=float((thing.model.hits[found.nearest] >= SURE).mean()),
        gap=float(found.gap.mean() / thing.reach),
        cost=float(found.cost.mean() / thing.reach),
        fit=place.cost,
        size=len(points) / max(thing.size, 1.0),
        change=len(points) / max(thing.last, 1),
        grown=1.0 - m / count,
        whole=place.whole,
        share=m / max(len(place.moving), 1),
        worn=thing.worn.likeness(view.colour(some)) - thing.worn.usual if thing.body else 0.0,
        usual=thing.usual,
        points=count,
        pixels=view.lens is not None,
        scans=thing.scanned,
        soft=thing.soft,
        left=(left + 1) / (len(points) + 1),
        others=(others + 1) / (len(points) + 1),
        tall=_height(thing, view, place, points),
        bend=thing.bending.share,
        coarse=thing.unit / max(thing.model.radius, thing.unit),
        border=place.border,
    )


def _beside(thing: Thing, view: View, place: Place, points: I64) -> tuple[int, int]:
    """How many moving points around a thing's ``points`` (M,) nobody has, and others have.

    Asked of lidars alone.
    """
    if not (thing.scanned and len(points)):
        return 0, 0
    lo, hi = bounds(view.xyz[points])
    margin = BESIDE * thing.unit
    had = np.zeros(len(view.xyz), np.bool_)
    had[points] = True
    rest = place.moving[~had[place.moving]]
    rest = rest[within(view.xyz[rest], lo - margin, hi + margin)]
    had[place.had] = True
    others = int(had[rest].sum())
    return len(rest) - others, others


def _height(thing: Thing, view: View, place: Place, points: I64) -> float:
    """Height of a thing's ``points`` (M,) over its model's; asked of lidars alone."""
    if not (thing.scanned and len(points)):
        return 1.0
    whole = float(np.ptp(place.world[:, view.up]))
    return float(np.ptp(view.xyz[points, view.up])) / max(whole, thing.unit)


def learn(
    thing: Thing, view: View, place: Place, found: Claim, grown: I64, verdict: Verdict
) -> None:
    """Take in the points found: a rigid model gathers them, one that bends is made anew.

    ``grown`` (M,) points of new surface, beside those ``found``.
    """
    if verdict.confidence > CERTAIN:
        thing.size = max(thing.size, float(len(found.indices) + len(grown)))
    was_rigid = not thing.bends
    _ask_whether_it_bends(thing, place, found, grown, verdict)
    if thing.bends:
        _make_anew(thing, view, place, np.concatenate([found.indices, grown]), verdict)
    else:
        _gather(thing, view, place, found, grown, verdict, was_rigid)


def _ask_whether_it_bends(
    thing: Thing, place: Place, found: Claim, grown: I64, verdict: Verdict
) -> None:
    """Take note of how much of what was found a rigid model does not explain."""
    total = len(found.indices) + len(grown)
    unlike = 0 if place.whole else len(grown) - len(place.uncovered)
    loose = (unlike + np.count_nonzero(found.gap > 2 * thing.unit)) / max(total, 1)
    # What is mostly hidden says little about the rest of it.
    says = PACE * (verdict.visible if thing.handy else 1.0)
    share = thing.bending.share
    share += says * (max(loose, 1 - verdict.inliers) - share)
    thing.bending = replace(thing.bending, share=share)


def _eye_of(back: F64, view: View) -> F64 | None:
    """(3,) the sensor in the model's coordinates, None where its place is not known."""
    return None if view.eye is None else transform(back, view.eye[None])[0]


def _make_anew(thing: Thing, view: View, place: Place, points: I64, verdict: Verdict) -> None:
    """Replace a model that bends by ``points`` (M,), and what of the old one was not in sight."""
    back = inverse(place.pose)
    xyz = transform(back, view.xyz[points].astype(np.float64))
    unseen = verdict.hidden
    if thing.scanned:  # what hides it from a lidar is known too coarsely
        unseen = unseen | ~close_to(place.world, view.xyz[points], ON_SURFACE * thing.unit)
    old = np.flatnonzero(unseen & (thing.model.misses < FORGOTTEN))
    before = thing.model
    new = Model.of(xyz, view.colour(points), _eye_of(back, view), before.spacing, MOST_BENT)
    new.xyz = np.vstack([new.xyz, transform(back, place.world[old])])
    new.colour = np.vstack([new.colour, before.colour[old]])
    new.seen = np.vstack([new.seen, before.seen[old]])
    new.hits = np.append(new.hits, before.hits[old]).astype(np.float32)
    new.misses = np.append(new.misses, before.misses[old] + 1).astype(np.float32)
    thing.model = new


def _gather(
    thing: Thing,
    view: View,
    place: Place,
    found: Claim,
    grown: I64,
    verdict: Verdict,
    was_rigid: bool,
) -> None:
    """Let a rigid model take in what was found on it and beside it, and drop what was not there."""
    back = inverse(place.pose)
    if thing.soft:
        thing.model.xyz = transform(back, _settled_on(place.world, view, found))
    number = thing.model.miss(verdict.through)
    if not was_rigid:  # the claim was made by the model as it was bent
        number[:] = -1
    again = _claimed_again(thing, view, place, found, grown, number)
    if not place.whole:
        again = again.pick(again.cost < 2 * thing.reach)
    if not thing.painted.flat:  # Ground beside what is known is no new surface.
        again = again.pick(
            ~view.low[again.indices] | (again.gap < NEW_SURFACE * thing.model.spacing)
        )
    xyz = transform(back, view.xyz[again.indices].astype(np.float64))
    colour = view.colour(again.indices)
    # Nobody holds what a lidar on the move sees ever new sides of.
    sure = thing.distinct(colour) | (place.whole or view.roams)
    own_eye = _eye_of(back, view)
    thing.model.gather(xyz, colour, again.gap, again.nearest, own_eye, sure)
    _take_in_uncovered(thing, view, place.uncovered, back, own_eye)


def stretch(thing: Thing, view: View, place: Place, verdict: Verdict, points: I64) -> None:
    """Take note of how much of a small thing bending alone explains; ``points`` (M,) are its."""
    stiff = not (thing.bends or thing.soft or thing.large or thing.scanned)
    if stiff and _asked(thing, view, place):
        most = np.inf if thing.size > DENSE else AGAIN * SOFT
        now = min(strained(thing, view, place, verdict, points), most)
        strain = thing.bending.strain
        strain += PACE_OF_STRAIN * (now - strain)
        thing.bending = replace(thing.bending, strain=strain)


def _settled_on(world: F64, view: View, found: Claim) -> F64:
    """The model at ``world`` (M, 3), each point moved to the middle of the points nearest to it."""
    count = np.bincount(found.nearest, minlength=len(world))
    away = view.xyz[found.indices] - world[found.nearest]
    sums = [np.bincount(found.nearest, weights=away[:, a], minlength=len(world)) for a in range(3)]
    return np.asarray(world + SNAP * np.stack(sums, axis=1) / np.maximum(count, 1)[:, None])


def strained(thing: Thing, view: View, place: Place, verdict: Verdict, points: I64) -> float:
    """Share of the known surface that is not where one motion puts it, but where bending does."""
    model = thing.model
    facing = model.facing(place.pose[None], view.eye)[0]
    known = np.flatnonzero(facing & ~verdict.hidden & (model.hits >= SURE))
    if len(known) < KNOWN:
        return 0.0
    some = known[:: -(-len(known) // STRETCHED)]
    world, colour = place.world[some], model.colour[some]
    target = target_of(view, place.near, thing.weight, ONTO)
    far = 3 * thing.unit
    off = target.nearest(world, colour, far)[0] > OFF * thing.unit
    if thing.motion.slow(thing.unit):
        off[off] = ~_beside_another(view, world[off], points, far)
    if off.mean() < FEW:
        return 0.0
    moved = bent(thing, world, colour, target)[off]
    again = target.nearest(moved, colour[off], far)[0]
    return float(np.count_nonzero(again < ON * thing.unit) / len(off))


def _beside_another(view: View, world: F64, own: I64, step: float) -> Mask:
    """Which of a thing's points (M, 3) lie beside the outline of what is ``step`` metres before it.

    The rim of what is behind an outline is hardly measured, and bending seems to draw it in.
    ``own`` (N,): the points of the frame that are the thing's, which do not hide it.
    """
    if view.lens is None:
        return np.zeros(len(world), np.bool_)
    cell, depth = view.project(world)
    steps = np.array([row * view.lens.shape[1] + column for row in RIM for column in RIM])
    around = np.clip(cell[:, None] + steps, 0, len(view.depth) - 1)
    with np.errstate(invalid="ignore"):
        nearer = view.depth[around] < depth[:, None] - step
    return np.asarray((nearer & ~view.marked(own)[around]).any(axis=1))


def _asked(thing: Thing, view: View, place: Place) -> bool:
    """Whether it is looked in this frame if a thing bends: seldom while nothing speaks for it.

    What is seen by very many points fits well while it is stiff.
    """
    speaks = thing.bending.strain > HINT * SOFT or (place.cost > LOOSE and thing.size > DENSE)
    return speaks or (view.number + thing.label) % SELDOM == 0


def _claimed_again(
    thing: Thing, view: View, place: Place, found: Claim, grown: I64, number: I64
) -> Claim:
    """What the model claims now of its points: as before, unless the model point has gone.

    ``number`` (M,) new number of each model point, -1 for those that have gone.
    """
    reach = (NEW_ALONE if place.whole or thing.scanned else NEW) * thing.unit
    now = number[found.nearest]
    kept = (now >= 0) & (found.gap < reach)
    rest = np.concatenate([found.indices[~kept], grown])
    world = transform(place.pose, thing.model.xyz)
    new = claim(view, rest, world, thing.model.colour, thing.weight, reach)
    return Claim(
        np.concatenate([found.indices[kept], new.indices]),
        np.concatenate([found.cost[kept], new.cost]),
        np.concatenate([found.gap[kept], new.gap]),
        np.concatenate([now[kept], new.nearest]),
    )


def _take_in_uncovered(thing: Thing, view: View, points: I64, back: F64, eye: F64 | None) -> None:
    """What another object hid until now of a thing at rest is as sure as what a person painted.

    Beside what is on the move it may be the hand.
    """
    if not len(points):
        return
    xyz = transform(back, view.xyz[points].astype(np.float64))
    gap, number = nearest(columns(thing.model.xyz, NONE, 0.0), xyz, NONE, 0.0, np.inf)
    sure = thing.motion.slow(thing.unit)
    thing.model.gather(xyz, view.colour(points), gap, number, eye, sure=sure)
