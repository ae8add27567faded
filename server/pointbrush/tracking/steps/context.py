"""Unlabelled surface beside a track, which contests its points, and people beside it: they are
followed together in what it leaves, and would lose to it what they hold it with.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from pointbrush.tracking.compute.grid import bounds
from pointbrush.tracking.compute.rigid import inverse, transform
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.appearance import ColourHistogram
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import OtherMovers, Track
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.association import Associations, LabelledPoints
from pointbrush.tracking.steps.claim import Claim


def contested(view: View, found: Claim, track: Track, fit: Registration) -> Mask:
    """Mark the claimed points more like a known unlabelled mover than like the model."""
    return _explained(
        track,
        view,
        fit,
        found.indices,
        view.options.context.yield_ratio * found.cost.astype(np.float64),
    )


def unexplained(track: Track, view: View, fit: Registration, points: I64) -> Mask:
    """Mark the points that no unlabelled mover explains, where it was or gone along with the
    object."""
    return ~_explained(
        track,
        view,
        fit,
        points,
        np.full(len(points), track.options.context.explained_units * track.unit),
    )


def _explained(track: Track, view: View, fit: Registration, points: I64, reach: F64) -> Mask:
    if view.roams:  # What stands still is known, and no one holds what is seen from the road.
        return np.zeros(len(points), np.bool_)
    xyz, colour = view.xyz[points].astype(np.float64), view.colour(points)
    return track.other_movers.explain(xyz, colour, reach, step_of(track, fit))


def was_there(track: Track, view: View, points: I64, step: F64 | None = None) -> Mask:
    """Mark the points where an unlabelled mover was in the last frame, or would be by ``step``."""
    reach = np.full(len(points), track.options.context.stayed_units * track.unit)
    xyz = view.xyz[points].astype(np.float64)
    return track.other_movers.explain(xyz, view.colour(points), reach, step)


def step_of(track: Track, fit: Registration) -> F64 | None:
    """Motion (4, 4) of an object since it was last seen; None where that is next to nothing."""
    last = track.motion.poses[-1]
    ends = track.ends
    if (
        np.abs(transform(fit.pose, ends) - transform(last, ends)).max()
        < track.options.context.rest_units * track.unit
    ):
        return None
    return fit.pose @ inverse(last)


def set_other_movers_around(track: Track, view: View, world: F64) -> None:
    """Let what is unlabelled beside an object, whose surface is at ``world`` (M, 3), be known."""
    box = _beside(track, world)
    set_other_movers(track, view, _unlabelled(view, box), box)


def _beside(track: Track, world: F64) -> tuple[F64, F64]:
    options = track.options.context
    return _box_around(
        world, options.beside_radii * track.model.radius + options.beside_units * track.unit
    )


def _box_around(world: F64, margin: float) -> tuple[F64, F64]:
    lo, hi = bounds(world)
    return lo - margin, hi + margin


def _unlabelled(view: View, box: tuple[F64, F64]) -> I64:
    near = view.box(*box)
    return near[~view.labelled(but=view.people)[near]]


def set_other_movers(track: Track, view: View, indices: I64, box: tuple[F64, F64]) -> None:
    """Let the points (M,) be known as all that is unlabelled in a ``box`` about an object; what it
    missed of itself is not.

    What has colours that it alone has, or that are far commoner in it than among them, is that.
    """
    some = indices[:: max(1, -(-len(indices) // track.options.context.max_points))]
    colour = view.colour(some)
    if track.has_colour_key and len(some):
        others = ~(track.appearance.rather(colour) | track.distinct(colour))
        some, colour = some[others], colour[others]
    track.other_movers = OtherMovers(view.xyz[some].astype(np.float64), colour, track.weight, box)


def note_beside(
    tracks: Mapping[int, Track],
    view: View,
    associations: Associations,
    labelled: Mapping[int, LabelledPoints],
) -> None:
    """Let what moves beside each object that was found, and is nothing's, be its other movers."""
    taken = view.labelled(but=view.people)
    for label, found in labelled.items():
        fit = associations.found[label].registration
        before = taken[found.neutral]
        taken[found.neutral] = True
        beside = fit.moving if found.beside is None else found.beside
        set_other_movers(tracks[label], view, beside[~taken[beside]], fit.box)
        taken[found.neutral] = before


def tell_apart(tracks: Mapping[int, Track], view: View, labels: Iterable[int]) -> None:
    """Find the colours that some objects alone have, of all ``tracks`` and what is about them.

    Hands that may hold an object later are within their reach of it, and are few of the points
    there.
    """
    for label in labels:
        track = tracks[label]
        beside = view.colour(_unlabelled(view, _beside(track, track.model.xyz)))
        others = [other.appearance for other in tracks.values() if other is not track]
        about = view.colour(
            _unlabelled(view, _box_around(track.model.xyz, view.options.context.reach_m))
        )
        track.appearance = track.appearance.apart_from(
            [ColourHistogram.of(beside, view.options.appearance), *others]
        )
        track.appearance = track.appearance.commoner_than(about, track.size)
