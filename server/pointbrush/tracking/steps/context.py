"""Unlabelled surface beside a track, which contests its points."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from pointbrush.tracking.compute.grid import bounds
from pointbrush.tracking.compute.rigid import inverse, transform
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.appearance import ColourHistogram
from pointbrush.tracking.model.registration import Place
from pointbrush.tracking.model.track import Rivals, Thing
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import Claim


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


def set_rivals_around(thing: Thing, view: View, world: F64) -> None:
    """Let what is unlabelled beside a thing, whose surface is at ``world`` (M, 3), be known."""
    box = _beside(thing, world)
    set_rivals(thing, view, _unlabelled(view, box), box)


def _beside(thing: Thing, world: F64) -> tuple[F64, F64]:
    options = thing.options.context
    return _box_around(
        world,
        options.beside_radii * thing.model.radius + options.beside_units * thing.unit,
    )


def _box_around(world: F64, margin: float) -> tuple[F64, F64]:
    lo, hi = bounds(world)
    return lo - margin, hi + margin


def _unlabelled(view: View, box: tuple[F64, F64]) -> I64:
    near = view.box(*box)
    return near[~view.labelled()[near]]


def set_rivals(thing: Thing, view: View, indices: I64, box: tuple[F64, F64]) -> None:
    """Let the points (M,) be known as all that is unlabelled in a ``box`` about a thing; what it
    missed of itself is not.

    What has colours that it alone has, or that are far commoner in it than among them, is that.
    """
    some = indices[:: max(1, -(-len(indices) // thing.options.context.max_points))]
    colour = view.colour(some)
    if thing.dyed and len(some):
        others = ~(thing.worn.rather(colour) | thing.distinct(colour))
        some, colour = some[others], colour[others]
    thing.rivals = Rivals(view.xyz[some].astype(np.float64), colour, thing.weight, box)


def note_beside(things: Mapping[int, Thing], view: View, places: Mapping[int, Place]) -> None:
    """Let what moves beside each thing that was found, and is nothing's, be its rivals."""
    taken = view.labelled()
    for label, place in places.items():
        before = taken[place.neutral]
        taken[place.neutral] = True
        beside = place.moving if place.beside is None else place.beside
        set_rivals(things[label], view, beside[~taken[beside]], place.box)
        taken[place.neutral] = before


def tell_apart(things: Mapping[int, Thing], view: View, labels: Iterable[int]) -> None:
    """Find the colours that some things alone have, of all ``things`` and what is about them.

    Hands that may hold a thing later are within their reach of it, and are few of the points there.
    """
    for label in labels:
        thing = things[label]
        beside = view.colour(_unlabelled(view, _beside(thing, thing.model.xyz)))
        others = [other.worn for other in things.values() if other is not thing]
        about = view.colour(
            _unlabelled(view, _box_around(thing.model.xyz, view.options.context.reach_m))
        )
        thing.worn = thing.worn.apart_from(
            [ColourHistogram.of(beside, options=view.options), *others]
        )
        thing.worn = thing.worn.commoner_than(about, thing.size)
