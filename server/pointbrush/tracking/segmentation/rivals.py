"""What is beside a thing and is not its: where that is, and in which colours."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from pointbrush.tracking.geometry.near import bounds
from pointbrush.tracking.interface import F64, I64
from pointbrush.tracking.objects.colours import ColourHistogram
from pointbrush.tracking.objects.place import Place
from pointbrush.tracking.objects.thing import Rivals, Thing
from pointbrush.tracking.sensor.view import View


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
