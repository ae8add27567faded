"""Who comes out of hiding: bodies that nothing explains, known again by what they wear."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.tracking.geometry.registration import transform
from pointbrush.tracking.interface import I64
from pointbrush.tracking.objects.thing import HARDLY, Thing
from pointbrush.tracking.people.bodies import CELL, FEWEST, FINE, UNSEEN
from pointbrush.tracking.people.foreground import SMALLEST, Foreground
from pointbrush.tracking.sensor.view import View

ALIKE = 0.7
"""Share of a figure's colours that show that it is the same."""
SAMPLE = 400
"""Points whose colours are compared."""
HARDLY_LESS = 0.1
"""How much less, in the mean logarithm, something may look like what one wears than like what
another does: who are dressed alike, or seen without colour, cannot be told apart by it."""
NEAR, WANDERS = 0.5, 0.25
"""Radii from where somebody was expected within which he may come out, and more for each frame
unseen."""
SCRAP = 0.25
"""Share of what hardly anything of a thing is that a body must have to be it."""
EDGE = 0.5
"""What a body at the end of the reach of a figure loses against one where it is expected."""


def reclaim(view: View, things: Mapping[int, Thing], moving: I64) -> dict[int, I64]:
    """The points of large ``things`` that come out from behind others; none where none are alike.

    ``moving`` are points before the background that nothing else explains.  Each body that hangs
    together there goes to the thing whose clothes it wears, the surest first: one within reach
    of where it should be, that shows its colours, or of whose colours the thing showed some.
    """
    if len(moving) < FEWEST or not things:
        return {}
    size = float(np.median([max(CELL * t.unit, FINE * t.span) for t in things.values()]))
    foreground = Foreground.of(view, moving, size)
    bodies = foreground.bodies(2 * SMALLEST)
    offers = []
    for label, thing in things.items():
        # Who left the picture may have turned there.
        either = (thing.motion.predictions()[0], thing.motion.poses[-1])
        guess = np.vstack([transform(T, thing.model.xyz) for T in either])
        away, _ = cKDTree(guess).query(foreground.middle)
        reach = thing.span * (NEAR + WANDERS * min(thing.missing, UNSEEN))
        for number, cells in enumerate(bodies):
            gap = float(np.asarray(away)[cells].min())
            if gap > reach:
                continue
            points = moving[np.isin(foreground.cell, cells)]
            if len(points) < HARDLY * SCRAP * thing.size:
                continue
            colour = view.colour(points[:: _step(len(points))])
            if thing.worn.share(colour) > ALIKE:
                like = thing.worn.likeness(colour) - EDGE * gap / reach
                offers.append((like, label, number, points))
    found: dict[int, I64] = {}
    gone: set[int] = set()
    for _, label, number, points in sorted(offers, key=lambda o: (-o[0], o[1], o[2])):
        if label not in found and number not in gone:
            found[label] = points
            gone.add(number)
    return found


def recognised(label: int, things: Mapping[int, Thing], view: View, points: I64) -> bool:
    """Whether ``points`` show the clothes of a thing, and not rather those of another."""
    colour = view.colour(points[:: _step(len(points))])
    worn = things[label].worn
    others = [t.worn.likeness(colour) for n, t in things.items() if n != label and t.large]
    alike = worn.share(colour) > ALIKE
    return alike and worn.likeness(colour) > max(others, default=-np.inf) - HARDLY_LESS


def _step(count: int) -> int:
    return max(1, count // SAMPLE)
