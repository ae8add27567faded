"""Beginning of a track from painted points, and corrections by a person."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pointbrush.tracking.compute.grid import close_to
from pointbrush.tracking.compute.rigid import inverse, transform
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.registration import Place
from pointbrush.tracking.model.track import Rivals, Thing, begin
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import claim, painted_with_flying
from pointbrush.tracking.steps.context import set_rivals_around, tell_apart
from pointbrush.tracking.steps.pieces import painted_with_ground
from pointbrush.tracking.steps.predict import search_among
from pointbrush.tracking.steps.register import find


def begin_label(
    things: dict[int, Thing], view: View, label: int, points: I64, noise: float
) -> None:
    """Put what the ``points`` (M,) of a frame show among the things, its model in the world.

    ``noise`` metres of the depth there.
    """
    thing = begin(view, label, points, noise, Rivals.none())
    thing.painted = replace(
        thing.painted,
        grounded=painted_with_ground(view, points),
        with_flying=painted_with_flying(view, points, thing.unit),
    )
    things[label] = thing
    set_rivals_around(thing, view, thing.model.xyz)


def begin_anew(things: dict[int, Thing], view: View, label: int, points: I64, noise: float) -> F64:
    """Learn a thing from ``points`` (M,) alone; its pose (4, 4), which goes on where it was."""
    before = things[label]
    pose = before.motion.poses[-1]
    shift = np.eye(4)
    if len(points):
        old = transform(pose, before.model.centre[None])[0]
        shift[:3, 3] = view.xyz[points].mean(axis=0) - old
    pose = shift @ pose
    begin_label(things, view, label, points, noise)
    tell_apart(things, view, [label])
    thing = things[label]
    thing.model.xyz = transform(inverse(pose), thing.model.xyz)
    thing.motion.centre, thing.motion.poses = thing.model.centre, [pose]
    return pose


def taught(thing: Thing, view: View, points: I64) -> F64 | None:
    """Learn from ``points`` (M,) that a person painted; the pose (4, 4), None where none fits."""
    options = thing.options
    if (
        thing.bends
        or thing.large
        or thing.missing
        or len(points) < options.update.correction_min_points
    ):
        return None
    place = find(search_among(thing, view, points))
    model, reach = thing.model, options.update.new_surface_units * thing.unit
    found = claim(view, points, place.world, model.colour, thing.weight, 2 * thing.reach)
    if place.cost > options.update.correction_max_cost or len(
        found.indices
    ) < options.update.correction_explained_share * len(points):
        return None
    model.drop(_denied(thing, view, place, points) & (model.hits < options.surface.sure_hits))
    back = inverse(place.pose)
    eye = None if view.eye is None else transform(back, view.eye[None])[0]
    found = claim(view, points, transform(place.pose, model.xyz), model.colour, 0.0, reach)
    xyz = transform(back, view.xyz[found.indices].astype(np.float64))
    model.gather(xyz, view.colour(found.indices), found.gap, found.nearest, eye, sure=True)
    thing.motion.add(place.pose)
    thing.last = replace(thing.last, points=len(points))
    thing.size = max(thing.size, float(len(points)))
    thing.trust, thing.strayed = 1.0, False
    return place.pose


def _denied(thing: Thing, view: View, place: Place, points: I64) -> Mask:
    """Which of the model a person did not paint though the sensor saw it: a hand's, say."""
    options = thing.options.verdict
    painted = close_to(place.world, view.xyz[points], options.surface_units * thing.unit)
    denied = ~painted & thing.model.facing(place.pose[None], view.eye)[0]
    if view.lens is not None:
        denied &= ~view.hides(place.world, options.hidden_units * thing.unit)
    return np.asarray(denied)
