"""How much a thing bends, as its fits tell: what one rigid motion does not explain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pointbrush.tracking.fitting.fit import bent
from pointbrush.tracking.fitting.search import target_of
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.sensor.view import View
from pointbrush.tracking.update.sighting import Sighting


def note_looseness(thing: Thing, sighting: Sighting) -> None:
    """Take note of how much of what was found a rigid model does not explain."""
    options = thing.options.strain
    place, found, grown = sighting.place, sighting.found, sighting.grown
    verdict = sighting.verdict
    total = len(found.indices) + len(grown)
    unlike = 0 if place.whole else len(grown) - len(place.uncovered)
    loose = (unlike + np.count_nonzero(found.gap > options.unexplained_units * thing.unit)) / max(
        total, 1
    )
    # What is mostly hidden says little about the rest of it.
    says = options.share_rate * (verdict.visible if thing.handy else 1.0)
    share = thing.bending.share
    share += says * (max(loose, 1 - verdict.inliers) - share)
    thing.bending = replace(thing.bending, share=share)


def note_strain(thing: Thing, sighting: Sighting) -> None:
    """Take note of how much of a small thing bending alone explains."""
    options = thing.options
    stiff = not (thing.bends or thing.soft or thing.large or thing.scanned)
    if stiff and _asked(thing, sighting):
        most = (
            np.inf
            if thing.size > options.track.dense_points
            else options.strain.max_frame_ratio * options.track.soft_strain
        )
        now = min(strained(thing, sighting), most)
        strain = thing.bending.strain
        strain += options.strain.strain_rate * (now - strain)
        thing.bending = replace(thing.bending, strain=strain)


def strained(thing: Thing, sighting: Sighting) -> float:
    """Share of the known surface that is not where one motion puts it, but where bending does."""
    options = thing.options
    model, view, place = thing.model, sighting.view, sighting.place
    facing = model.facing(place.pose[None], view.eye)[0]
    known = np.flatnonzero(
        facing & ~sighting.verdict.hidden & (model.hits >= options.surface.sure_hits)
    )
    if len(known) < options.strain.min_known_points:
        return 0.0
    some = known[:: -(-len(known) // options.strain.bent_points)]
    world, colour = place.world[some], model.colour[some]
    target = target_of(view, place.near, thing.weight, options.strain.target_points)
    far = options.strain.far_units * thing.unit
    off = target.nearest(world, colour, far)[0] > options.strain.off_units * thing.unit
    if thing.motion.slow(thing.unit):
        off[off] = ~_beside_another(view, world[off], sighting.points, far)
    if off.mean() < options.strain.min_off_share:
        return 0.0
    moved = bent(thing, world, colour, target)[off]
    again = target.nearest(moved, colour[off], far)[0]
    return float(np.count_nonzero(again < options.strain.on_units * thing.unit) / len(off))


def _asked(thing: Thing, sighting: Sighting) -> bool:
    """Whether it is looked in this frame if a thing bends: seldom while nothing speaks for it.

    What is seen by very many points fits well while it is stiff.
    """
    options = thing.options
    speaks = thing.bending.strain > options.strain.hint_share * options.track.soft_strain
    speaks = speaks or (
        sighting.place.cost > options.strain.loose_cost and thing.size > options.track.dense_points
    )
    return speaks or (sighting.view.number + thing.label) % options.strain.stiff_frames == 0


def _beside_another(view: View, world: F64, own: I64, step: float) -> Mask:
    """Which of a thing's points (M, 3) lie beside the outline of what is ``step`` metres before it.

    The rim of what is behind an outline is hardly measured, and bending seems to draw it in.
    ``own`` (N,): the points of the frame that are the thing's, which do not hide it.
    """
    options = view.options.strain
    if view.lens is None:
        return np.zeros(len(world), np.bool_)
    cell, depth = view.project(world)
    steps = np.array(
        [
            row * view.lens.shape[1] + column
            for row in options.outline_offsets_px
            for column in options.outline_offsets_px
        ]
    )
    around = np.clip(cell[:, None] + steps, 0, len(view.depth) - 1)
    with np.errstate(invalid="ignore"):
        nearer = view.depth[around] < depth[:, None] - step
    return np.asarray((nearer & ~view.marked(own)[around]).any(axis=1))
