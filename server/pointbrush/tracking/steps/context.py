"""Unlabelled surface and people beside a track, which contest its points.

People are tracked jointly in the remaining points, and could lose the hand that holds an object.
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
    """Mark the claimed points that a known unlabelled mover explains better than the model."""
    return _explained(
        track,
        view,
        fit,
        found.indices,
        view.options.context.yield_ratio * found.cost.astype(np.float64),
    )


def unexplained(track: Track, view: View, fit: Registration, points: I64) -> Mask:
    """Mark the points not explained by unlabelled movers, at rest or moved with the object."""
    return ~_explained(
        track,
        view,
        fit,
        points,
        np.full(len(points), track.options.context.explained_units * track.unit),
    )


def _explained(track: Track, view: View, fit: Registration, points: I64, reach: F64) -> Mask:
    if view.roams:  # Static surface is known, and objects in traffic are not held.
        return np.zeros(len(points), np.bool_)
    xyz, colour = view.xyz[points].astype(np.float64), view.colour(points)
    return track.other_movers.explain(xyz, colour, reach, step_of(track, fit))


def explained_by_movers(track: Track, view: View, points: I64, step: F64 | None = None) -> Mask:
    """Mark the points at an unlabelled mover's last position, or at this moved by ``step``."""
    reach = np.full(len(points), track.options.context.stayed_units * track.unit)
    xyz = view.xyz[points].astype(np.float64)
    return track.other_movers.explain(xyz, view.colour(points), reach, step)


def step_of(track: Track, fit: Registration) -> F64 | None:
    """Return the motion (4, 4) of an object since it was last seen; None: it is at rest."""
    last = track.motion.poses[-1]
    ends = track.ends
    if (
        np.abs(transform(fit.pose, ends) - transform(last, ends)).max()
        < track.options.context.rest_units * track.unit
    ):
        return None
    return fit.pose @ inverse(last)


def set_other_movers_around(track: Track, view: View, world: F64) -> None:
    """Store the unlabelled points beside an object with its surface at ``world`` (M, 3)."""
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
    """Store the points (M,) as the unlabelled ones in a ``box`` around an object.

    Missed points of the object itself are excluded: points with colours that only it has, or that
    are far more common in it.
    """
    most = view.per_sensor(track.options.context.max_points)
    some = indices[:: max(1, -(-len(indices) // most))]
    colour = view.colour(some)
    if track.has_colour_key and len(some):
        others = ~(track.appearance.overrepresented(colour) | track.distinct(colour))
        some, colour = some[others], colour[others]
    track.other_movers = OtherMovers(view.xyz[some].astype(np.float64), colour, track.weight, box)


def store_other_movers(
    tracks: Mapping[int, Track],
    view: View,
    associations: Associations,
    labelled: Mapping[int, LabelledPoints],
) -> None:
    """Store the unassigned moving points beside each found object as its other movers."""
    taken = view.labelled(but=view.people)
    for label, found in labelled.items():
        fit = associations.found[label].registration
        before = taken[found.neutral]
        taken[found.neutral] = True
        beside = fit.moving if found.beside is None else found.beside
        set_other_movers(tracks[label], view, beside[~taken[beside]], fit.box)
        taken[found.neutral] = before


def update_distinct_colours(tracks: Mapping[int, Track], view: View, labels: Iterable[int]) -> None:
    """Update the distinctive colours of ``labels`` against all ``tracks`` and their surroundings.

    The surroundings include hands within reach, which may hold an object later and have few points.
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
