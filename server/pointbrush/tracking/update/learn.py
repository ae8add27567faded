"""What the model of a thing keeps from a frame: its surface and its size."""

from __future__ import annotations

import numpy as np

from pointbrush.tracking.geometry.columns import NONE, columns, nearest
from pointbrush.tracking.geometry.near import close_to
from pointbrush.tracking.geometry.registration import inverse, transform
from pointbrush.tracking.interface import F64, I64
from pointbrush.tracking.objects.model import Model
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.segmentation.assign import Claim, claim
from pointbrush.tracking.sensor.view import View
from pointbrush.tracking.update.bending import note_looseness
from pointbrush.tracking.update.sighting import Sighting


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
