"""How much a thing bends, as its fits tell: what one rigid motion does not explain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pointbrush.tracking.fitting.fit import bent
from pointbrush.tracking.fitting.search import target_of
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.objects.model import SURE
from pointbrush.tracking.objects.thing import DENSE, SOFT, Thing
from pointbrush.tracking.sensor.view import View
from pointbrush.tracking.update.sighting import Sighting

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
OFF, ON, FAR = 1.5, 1.0, 3.0
"""Units from what is measured at which a model point is off its place, and on it, and within which
that is looked for."""
UNEXPLAINED = 2.0
"""Units from the model from which it does not explain a point."""
RIM = (-2, 0, 2)
"""Pixels, up, down and sideways, from which an outline is beside a point."""
PACE, PACE_OF_STRAIN = 0.15, 0.2
"""Weight of a frame in the running means of how much bends, and of how much bending explains."""


def note_looseness(thing: Thing, sighting: Sighting) -> None:
    """Take note of how much of what was found a rigid model does not explain."""
    place, found, grown = sighting.place, sighting.found, sighting.grown
    verdict = sighting.verdict
    total = len(found.indices) + len(grown)
    unlike = 0 if place.whole else len(grown) - len(place.uncovered)
    loose = (unlike + np.count_nonzero(found.gap > UNEXPLAINED * thing.unit)) / max(total, 1)
    # What is mostly hidden says little about the rest of it.
    says = PACE * (verdict.visible if thing.handy else 1.0)
    share = thing.bending.share
    share += says * (max(loose, 1 - verdict.inliers) - share)
    thing.bending = replace(thing.bending, share=share)


def note_strain(thing: Thing, sighting: Sighting) -> None:
    """Take note of how much of a small thing bending alone explains."""
    stiff = not (thing.bends or thing.soft or thing.large or thing.scanned)
    if stiff and _asked(thing, sighting):
        most = np.inf if thing.size > DENSE else AGAIN * SOFT
        now = min(strained(thing, sighting), most)
        strain = thing.bending.strain
        strain += PACE_OF_STRAIN * (now - strain)
        thing.bending = replace(thing.bending, strain=strain)


def strained(thing: Thing, sighting: Sighting) -> float:
    """Share of the known surface that is not where one motion puts it, but where bending does."""
    model, view, place = thing.model, sighting.view, sighting.place
    facing = model.facing(place.pose[None], view.eye)[0]
    known = np.flatnonzero(facing & ~sighting.verdict.hidden & (model.hits >= SURE))
    if len(known) < KNOWN:
        return 0.0
    some = known[:: -(-len(known) // STRETCHED)]
    world, colour = place.world[some], model.colour[some]
    target = target_of(view, place.near, thing.weight, ONTO)
    far = FAR * thing.unit
    off = target.nearest(world, colour, far)[0] > OFF * thing.unit
    if thing.motion.slow(thing.unit):
        off[off] = ~_beside_another(view, world[off], sighting.points, far)
    if off.mean() < FEW:
        return 0.0
    moved = bent(thing, world, colour, target)[off]
    again = target.nearest(moved, colour[off], far)[0]
    return float(np.count_nonzero(again < ON * thing.unit) / len(off))


def _asked(thing: Thing, sighting: Sighting) -> bool:
    """Whether it is looked in this frame if a thing bends: seldom while nothing speaks for it.

    What is seen by very many points fits well while it is stiff.
    """
    speaks = thing.bending.strain > HINT * SOFT
    speaks = speaks or (sighting.place.cost > LOOSE and thing.size > DENSE)
    return speaks or (sighting.view.number + thing.label) % SELDOM == 0


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
