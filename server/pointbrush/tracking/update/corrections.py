"""What a person's points in the middle of a run teach: more of the same thing.

The model keeps the sides that were seen before, and the motion goes on; only what the person's
points contradict is given up.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pointbrush.tracking.fitting.fit import find
from pointbrush.tracking.fitting.search import search_among
from pointbrush.tracking.geometry.near import close_to
from pointbrush.tracking.geometry.registration import inverse, transform
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.objects.place import Place
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.segmentation.assign import claim
from pointbrush.tracking.sensor.view import View


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
