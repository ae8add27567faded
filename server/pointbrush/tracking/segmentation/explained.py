"""What something unlabelled explains: it was there in the last frame, or has gone along since."""

from __future__ import annotations

import numpy as np

from pointbrush.tracking.geometry.registration import inverse, transform
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.objects.place import Place
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.segmentation.assign import Claim
from pointbrush.tracking.sensor.view import View


def contested(view: View, found: Claim, thing: Thing, place: Place) -> Mask:
    """Which claimed points are more like something known to be unlabelled."""
    return _explained(
        thing,
        view,
        place,
        found.indices,
        view.options.context.yield_ratio * found.cost.astype(np.float64),
    )


def unexplained(thing: Thing, view: View, place: Place, points: I64) -> Mask:
    """Which points nothing unlabelled explains, where it was or gone along with the thing."""
    return ~_explained(
        thing,
        view,
        place,
        points,
        np.full(len(points), thing.options.context.explained_units * thing.unit),
    )


def _explained(thing: Thing, view: View, place: Place, points: I64, reach: F64) -> Mask:
    if view.roams:  # What stands still is known, and nobody holds what is seen from the road.
        return np.zeros(len(points), np.bool_)
    xyz, colour = view.xyz[points].astype(np.float64), view.colour(points)
    explained = thing.rivals.explain(xyz, colour, reach, step_of(thing, place))
    if thing.soft and len(thing.rivals.xyz):  # Each part of it has a motion of its own.
        before = transform(thing.motion.poses[-1], thing.model.xyz)
        bent = thing.rivals.along(
            before, place.world, thing.options.context.along_units * thing.unit
        )
        explained |= bent.explain(xyz, colour, reach)
    return explained


def was_there(thing: Thing, view: View, points: I64, step: F64 | None = None) -> Mask:
    """Which points lie where something unlabelled was in the last frame, or has gone by ``step``
    since."""
    reach, xyz = (
        np.full(len(points), thing.options.context.stayed_units * thing.unit),
        view.xyz[points].astype(np.float64),
    )
    return thing.rivals.explain(xyz, view.colour(points), reach, step)


def step_of(thing: Thing, place: Place) -> F64 | None:
    """How a thing has moved (4, 4) since it was seen; None where that is next to nothing."""
    last = thing.motion.poses[-1]
    ends = thing.ends
    if (
        np.abs(transform(place.pose, ends) - transform(last, ends)).max()
        < thing.options.context.rest_units * thing.unit
    ):
        return None
    return place.pose @ inverse(last)
