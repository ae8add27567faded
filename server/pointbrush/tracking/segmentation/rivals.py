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

REACH = 1.0
"""Metres about a thing within which whoever may hold it is."""
BESIDE, SPARE = 0.5, 4.0
"""Radii, and units, about a thing within which what is unlabelled is beside it."""
MOST = 1000
"""Rivals kept of those beside a thing."""


def around(thing: Thing, view: View, world: F64) -> I64:
    """The unlabelled points beside a thing whose surface is at ``world`` (M, 3)."""
    return _unlabelled(view, world, BESIDE * thing.model.radius + SPARE * thing.unit)


def _unlabelled(view: View, world: F64, margin: float) -> I64:
    """The unlabelled points in a box around ``world`` (M, 3) and ``margin`` metres beside."""
    lo, hi = bounds(world)
    near = view.box(lo - margin, hi + margin)
    return near[~view.labelled()[near]]


def set_rivals(thing: Thing, view: View, indices: I64) -> None:
    """Let the points (M,) be known as unlabelled beside a thing; what it missed of itself is not.

    What has colours that it alone has, or that are far commoner in it than among them, is that.
    """
    some = indices[:: max(1, -(-len(indices) // MOST))]
    colour = view.colour(some)
    if thing.dyed and len(some):
        others = ~(thing.worn.rather(colour) | thing.distinct(colour))
        some, colour = some[others], colour[others]
    thing.rivals = Rivals(view.xyz[some].astype(np.float64), colour, thing.weight)


def note_beside(things: Mapping[int, Thing], view: View, places: Mapping[int, Place]) -> None:
    """Let what moves beside each thing that was found, and is nothing's, be its rivals."""
    taken = view.labelled()
    for label, place in places.items():
        before = taken[place.neutral]
        taken[place.neutral] = True
        beside = place.moving if place.beside is None else place.beside
        set_rivals(things[label], view, beside[~taken[beside]])
        taken[place.neutral] = before


def tell_apart(things: Mapping[int, Thing], view: View, labels: Iterable[int]) -> None:
    """Find the colours that some things alone have, of all ``things`` and what is about them.

    Hands that may hold a thing later are within their reach of it, and are few of the points there.
    """
    for label in labels:
        thing = things[label]
        beside = view.colour(around(thing, view, thing.model.xyz))
        others = [other.worn for other in things.values() if other is not thing]
        about = view.colour(_unlabelled(view, thing.model.xyz, REACH))
        thing.worn = thing.worn.apart_from([ColourHistogram.of(beside), *others])
        thing.worn = thing.worn.commoner_than(about, thing.size)
