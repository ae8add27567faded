"""Who comes out of hiding: bodies that nothing explains, known again by what they wear."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.tracking.geometry.registration import transform
from pointbrush.tracking.interface import I64
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.options import ArrivalOptions
from pointbrush.tracking.people.foreground import Foreground
from pointbrush.tracking.sensor.view import View


def reclaim(view: View, things: Mapping[int, Thing], moving: I64) -> dict[int, I64]:
    """The points of large ``things`` that come out from behind others; none where none are alike.

    ``moving`` are points before the background that nothing else explains.  Each body that hangs
    together there goes to the thing whose clothes it wears, the surest first: one within reach
    of where it should be, that shows its colours, or of whose colours the thing showed some.
    """
    options = view.options
    if len(moving) < options.body.min_claim_points or not things:
        return {}
    size = float(
        np.median(
            [
                max(
                    options.body.cell_units * t.unit,
                    options.body.cell_radius_share * t.span,
                )
                for t in things.values()
            ]
        )
    )
    foreground = Foreground.of(view, moving, size)
    bodies = foreground.bodies(2 * options.body.min_part_cells)
    offers = []
    for label, thing in things.items():
        # Who left the picture may have turned there.
        either = (thing.motion.predictions()[0], thing.motion.poses[-1])
        guess = np.vstack([transform(T, thing.model.xyz) for T in either])
        away, _ = cKDTree(guess).query(foreground.middle)
        reach = thing.span * (
            options.arrivals.return_radii
            + options.arrivals.return_radii_per_frame
            * min(thing.missing, options.body.clothes_max_frames)
        )
        for number, cells in enumerate(bodies):
            gap = float(np.asarray(away)[cells].min())
            if gap > reach:
                continue
            points = moving[np.isin(foreground.cell, cells)]
            if (
                len(points)
                < options.track.hardly_share * options.arrivals.return_scrap_share * thing.size
            ):
                continue
            colour = view.colour(points[:: _step(len(points), options=options.arrivals)])
            if thing.worn.share(colour) > options.arrivals.return_alike_share:
                like = thing.worn.likeness(colour) - options.arrivals.return_edge_cost * gap / reach
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
    options = view.options.arrivals
    colour = view.colour(points[:: _step(len(points), options=options)])
    worn = things[label].worn
    others = [t.worn.likeness(colour) for n, t in things.items() if n != label and t.large]
    alike = worn.share(colour) > options.return_alike_share
    return alike and worn.likeness(colour) > max(others, default=-np.inf) - options.return_log


def _step(count: int, options: ArrivalOptions) -> int:
    return max(1, count // options.return_points)
