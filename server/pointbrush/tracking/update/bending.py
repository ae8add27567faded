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
    place, found, grown = sighting.place, sighting.found, sighting.grown
    verdict = sighting.verdict
    total = len(found.indices) + len(grown)
    unlike = 0 if place.whole else len(grown) - len(place.uncovered)
    loose = (
        unlike + np.count_nonzero(found.gap > thing.options.strain.unexplained_units * thing.unit)
    ) / max(total, 1)
    # What is mostly hidden says little about the rest of it.
    says = thing.options.strain.share_rate * (verdict.visible if thing.handy else 1.0)
    share = thing.bending.share
    share += says * (max(loose, 1 - verdict.inliers) - share)
    thing.bending = replace(thing.bending, share=share)


def note_strain(thing: Thing, sighting: Sighting) -> None:
    """Take note of how much of a small thing bending alone explains."""
    stiff = not (thing.bends or thing.soft or thing.large or thing.scanned)
    if stiff and _asked(thing, sighting):
        most = (
            np.inf
            if thing.size > thing.options.track.dense_points
            else thing.options.strain.max_frame_ratio * thing.options.track.soft_strain
        )
        now = min(strained(thing, sighting), most)
        strain = thing.bending.strain
        strain += thing.options.strain.strain_rate * (now - strain)
        thing.bending = replace(thing.bending, strain=strain)


def strained(thing: Thing, sighting: Sighting) -> float:
    """Share of the known surface that is not where one motion puts it, but where bending does."""
    model, view, place = thing.model, sighting.view, sighting.place
    facing = model.facing(place.pose[None], view.eye)[0]
    known = np.flatnonzero(
        facing & ~sighting.verdict.hidden & (model.hits >= thing.options.surface.sure_hits)
    )
    if len(known) < thing.options.strain.min_known_points:
        return 0.0
    some = known[:: -(-len(known) // thing.options.strain.bent_points)]
    world, colour = place.world[some], model.colour[some]
    target = target_of(view, place.near, thing.weight, thing.options.strain.target_points)
    far = thing.options.strain.far_units * thing.unit
    off = target.nearest(world, colour, far)[0] > thing.options.strain.off_units * thing.unit
    if thing.motion.slow(thing.unit):
        off[off] = ~_beside_another(view, world[off], sighting.points, far)
    if off.mean() < thing.options.strain.min_off_share:
        return 0.0
    moved = bent(thing, world, colour, target)[off]
    again = target.nearest(moved, colour[off], far)[0]
    return float(np.count_nonzero(again < thing.options.strain.on_units * thing.unit) / len(off))


def _asked(thing: Thing, sighting: Sighting) -> bool:
    """Whether it is looked in this frame if a thing bends: seldom while nothing speaks for it.

    What is seen by very many points fits well while it is stiff.
    """
    speaks = (
        thing.bending.strain > thing.options.strain.hint_share * thing.options.track.soft_strain
    )
    speaks = speaks or (
        sighting.place.cost > thing.options.strain.loose_cost
        and thing.size > thing.options.track.dense_points
    )
    return speaks or (sighting.view.number + thing.label) % thing.options.strain.stiff_frames == 0


def _beside_another(view: View, world: F64, own: I64, step: float) -> Mask:
    """Which of a thing's points (M, 3) lie beside the outline of what is ``step`` metres before it.

    The rim of what is behind an outline is hardly measured, and bending seems to draw it in.
    ``own`` (N,): the points of the frame that are the thing's, which do not hide it.
    """
    if view.lens is None:
        return np.zeros(len(world), np.bool_)
    cell, depth = view.project(world)
    steps = np.array(
        [
            row * view.lens.shape[1] + column
            for row in view.options.strain.outline_offsets_px
            for column in view.options.strain.outline_offsets_px
        ]
    )
    around = np.clip(cell[:, None] + steps, 0, len(view.depth) - 1)
    with np.errstate(invalid="ignore"):
        nearer = view.depth[around] < depth[:, None] - step
    return np.asarray((nearer & ~view.marked(own)[around]).any(axis=1))
