"""Update of a track from a frame: surface, and how much it bends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pointbrush.tracking.compute.columns import NONE, columns, nearest
from pointbrush.tracking.compute.grid import close_to
from pointbrush.tracking.compute.rigid import inverse, transform
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.registration import Place
from pointbrush.tracking.model.surface import Model
from pointbrush.tracking.model.track import Thing
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import Claim, claim
from pointbrush.tracking.steps.predict import target_of
from pointbrush.tracking.steps.register import bent
from pointbrush.tracking.steps.verdict import Verdict


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """A thing at its ``place`` in a ``view``.

    ``found`` points are on its model, ``grown`` (M,) are new surface beside them; ``verdict`` tells
    how well that explains what the sensor saw.
    """

    view: View
    place: Place
    found: Claim
    grown: I64
    verdict: Verdict

    @property
    def points(self) -> I64:
        """(N,) all that were found, those on the model first."""
        return np.concatenate([self.found.indices, self.grown])


def withheld(things: Mapping[int, Thing], places: Mapping[int, Place], view: View) -> F64:
    """(M, 3) where a thing is known to be, even if it claimed nothing there."""
    slow = {n: t for n, t in things.items() if t.motion.slow(t.unit)}
    there = [places[n].world for n in places if n in view.labels and n in slow]
    if view.lens is None:
        # What is hidden cannot be told from what is gone: it may be where it was.
        hidden = [t for n, t in slow.items() if n not in view.labels and not t.stopped]
        there += [transform(t.motion.poses[-1], t.model.xyz) for t in hidden]
    else:
        there += [_hidden_at_rest(t, view) for t in things.values()]
    return np.concatenate([np.empty((0, 3)), *there])


def _hidden_at_rest(thing: Thing, view: View) -> F64:
    """(M, 3) where a thing that rested may be behind what is seen: it is not seen past there."""
    if thing.motion.rested is None:
        return np.empty((0, 3))
    world = transform(thing.motion.rested, thing.model.xyz)
    return np.asarray(world[view.hides(world, -thing.options.verdict.hidden_units * thing.unit)])


def learn(thing: Thing, sighting: Sighting) -> None:
    """Take in the points found: a rigid model gathers them, one that bends is made anew."""
    found, grown = sighting.found, sighting.grown
    if sighting.verdict.confidence > thing.options.update.size_matched_share:
        thing.size = max(thing.size, float(len(found.indices) + len(grown)))
    was_rigid = not thing.bends
    note_looseness(thing, sighting)
    if thing.bends:
        _make_anew(thing, sighting)
    else:
        _gather(thing, sighting, was_rigid)


def _make_anew(thing: Thing, sighting: Sighting) -> None:
    """Replace a model that bends by what was found, and what of the old one was not in sight."""
    options = thing.options
    view, place, points = sighting.view, sighting.place, sighting.points
    back = inverse(place.pose)
    xyz = transform(back, view.xyz[points].astype(np.float64))
    unseen = sighting.verdict.hidden
    if thing.scanned:  # what hides it from a lidar is known too coarsely
        unseen = unseen | ~close_to(
            place.world, view.xyz[points], options.verdict.surface_units * thing.unit
        )
    old = np.flatnonzero(unseen & (thing.model.misses < options.update.forgotten_frames))
    before = thing.model
    new = Model.of(
        xyz,
        view.colour(points),
        _eye_of(back, view),
        before.spacing,
        thing.options,
        options.surface.max_points_bent,
    )
    new.xyz = np.vstack([new.xyz, transform(back, place.world[old])])
    new.colour = np.vstack([new.colour, before.colour[old]])
    new.seen = np.vstack([new.seen, before.seen[old]])
    new.hits = np.append(new.hits, before.hits[old]).astype(np.float32)
    new.misses = np.append(new.misses, before.misses[old] + 1).astype(np.float32)
    thing.model = new


def _gather(thing: Thing, sighting: Sighting, was_rigid: bool) -> None:
    """Let a rigid model take in what was found on it and beside it, and drop what was not there."""
    view, place = sighting.view, sighting.place
    back = inverse(place.pose)
    if thing.soft:
        thing.model.xyz = transform(back, _settled_on(place.world, view, sighting.found))
    number = thing.model.miss(sighting.verdict.through)
    if not was_rigid:  # the claim was made by the model as it was bent
        number[:] = -1
    again = _claimed_again(thing, sighting, number)
    if not place.whole:
        again = again.pick(again.cost < 2 * thing.reach)
    if not thing.painted.flat:  # Ground beside what is known is no new surface.
        again = again.pick(
            ~view.low[again.indices]
            | (again.gap < thing.options.surface.new_spacings * thing.model.spacing)
        )
    xyz = transform(back, view.xyz[again.indices].astype(np.float64))
    colour = view.colour(again.indices)
    # Nobody holds what a lidar on the move sees ever new sides of.
    sure = thing.distinct(colour) | (place.whole or view.roams)
    own_eye = _eye_of(back, view)
    thing.model.gather(xyz, colour, again.gap, again.nearest, own_eye, sure)
    _take_in_uncovered(thing, view, place.uncovered, back, own_eye)


def _claimed_again(thing: Thing, sighting: Sighting, number: I64) -> Claim:
    """What the model claims now of its points: as before, unless the model point has gone.

    ``number`` (M,) new number of each model point, -1 for those that have gone.
    """
    options = thing.options.update
    view, place, found = sighting.view, sighting.place, sighting.found
    reach = (
        options.teach_units_alone if place.whole or thing.scanned else options.teach_units
    ) * thing.unit
    now = number[found.nearest]
    kept = (now >= 0) & (found.gap < reach)
    rest = np.concatenate([found.indices[~kept], sighting.grown])
    world = transform(place.pose, thing.model.xyz)
    new = claim(view, rest, world, thing.model.colour, thing.weight, reach)
    return Claim(
        np.concatenate([found.indices[kept], new.indices]),
        np.concatenate([found.cost[kept], new.cost]),
        np.concatenate([found.gap[kept], new.gap]),
        np.concatenate([now[kept], new.nearest]),
    )


def _settled_on(world: F64, view: View, found: Claim) -> F64:
    """The model at ``world`` (M, 3), each point moved to the middle of the points nearest to it."""
    count = np.bincount(found.nearest, minlength=len(world))
    away = view.xyz[found.indices] - world[found.nearest]
    sums = [np.bincount(found.nearest, weights=away[:, a], minlength=len(world)) for a in range(3)]
    return np.asarray(
        world
        + view.options.update.soft_step * np.stack(sums, axis=1) / np.maximum(count, 1)[:, None]
    )


def _take_in_uncovered(thing: Thing, view: View, points: I64, back: F64, eye: F64 | None) -> None:
    """What another object hid until now of a thing at rest is as sure as what a person painted.

    Beside what is on the move it may be the hand.
    """
    if not len(points):
        return
    xyz = transform(back, view.xyz[points].astype(np.float64))
    gap, number = nearest(columns(thing.model.xyz, NONE, 0.0), xyz, NONE, np.inf)
    sure = thing.motion.slow(thing.unit)
    thing.model.gather(xyz, view.colour(points), gap, number, eye, sure=sure)


def _eye_of(back: F64, view: View) -> F64 | None:
    """(3,) the sensor in the model's coordinates, None where its place is not known."""
    return None if view.eye is None else transform(back, view.eye[None])[0]


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
