"""Places that the background must not learn: something tracked is there, shown or not."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pointbrush.tracking.geometry.registration import transform
from pointbrush.tracking.interface import F64
from pointbrush.tracking.objects.place import Place
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.sensor.view import View


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
