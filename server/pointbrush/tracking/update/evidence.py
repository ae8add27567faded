"""What the fit of a thing in a frame says about itself."""

from __future__ import annotations

import numpy as np

from pointbrush.tracking.geometry.near import bounds, within
from pointbrush.tracking.interface import I64
from pointbrush.tracking.objects.confidence import Evidence
from pointbrush.tracking.objects.place import Place
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.sensor.view import View
from pointbrush.tracking.update.sighting import Sighting


def evidence(thing: Thing, sighting: Sighting, points: I64) -> Evidence:
    """What a fit says about itself, for the confidence of a thing; ``points`` (M,) are assigned."""
    view, place, found = sighting.view, sighting.place, sighting.found
    verdict = sighting.verdict
    m = max(len(found.indices), 1)
    count = max(len(points), 1)
    some = points[:: max(1, len(points) // thing.options.update.colour_points)]
    left, others = _beside(thing, view, place, points)
    return Evidence(
        inliers=verdict.inliers,
        sure=float((thing.model.hits[found.nearest] >= thing.options.surface.sure_hits).mean()),
        gap=float(found.gap.mean() / thing.reach),
        cost=float(found.cost.mean() / thing.reach),
        fit=place.cost,
        size=len(points) / max(thing.size, 1.0),
        change=len(points) / max(thing.last.points, 1),
        grown=1.0 - m / count,
        whole=place.whole,
        share=m / max(len(place.moving), 1),
        worn=thing.worn.likeness(view.colour(some)) - thing.worn.usual if thing.body else 0.0,
        usual=thing.in_the_air.cost,
        points=count,
        pixels=view.lens is not None,
        scans=thing.scanned,
        soft=thing.soft,
        left=(left + 1) / (len(points) + 1),
        others=(others + 1) / (len(points) + 1),
        tall=_height(thing, view, place, points),
        bend=thing.bending.share,
        coarse=thing.unit / max(thing.model.radius, thing.unit),
        border=place.border,
    )


def _beside(thing: Thing, view: View, place: Place, points: I64) -> tuple[int, int]:
    """How many moving points around a thing's ``points`` (M,) nobody has, and others have.

    Asked of lidars alone.
    """
    if not (thing.scanned and len(points)):
        return 0, 0
    lo, hi = bounds(view.xyz[points])
    margin = thing.options.update.left_over_units * thing.unit
    had = np.zeros(len(view.xyz), np.bool_)
    had[points] = True
    rest = place.moving[~had[place.moving]]
    rest = rest[within(view.xyz[rest], lo - margin, hi + margin)]
    had[place.had] = True
    others = int(had[rest].sum())
    return len(rest) - others, others


def _height(thing: Thing, view: View, place: Place, points: I64) -> float:
    """Height of a thing's ``points`` (M,) over its model's; asked of lidars alone."""
    if not (thing.scanned and len(points)):
        return 1.0
    whole = float(np.ptp(place.world[:, view.up]))
    return float(np.ptp(view.xyz[points, view.up])) / max(whole, thing.unit)
