"""Parts of a track that registration leaves out: missed pieces, and ground below."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from pointbrush.tracking.compute.graph import pieces
from pointbrush.tracking.compute.grid import bounds, close_to, within
from pointbrush.tracking.compute.rigid import transform
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.registration import Place
from pointbrush.tracking.model.surface import carved
from pointbrush.tracking.model.track import Thing
from pointbrush.tracking.scene.depth import Background
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import cut_off, together


def lost_pieces(
    thing: Thing, view: View, place: Place, core: I64, taken: Mask, background: Background
) -> I64:
    """The points (M,), sorted, of the pieces of ``thing`` beside its points ``core``.

    ``taken`` (N,) points that somebody has.  None where there is no depth image, which tells
    what never moves, or no colour, and the thing is not ``pliant``.
    """
    options = thing.options
    asked = (view.number + thing.label) % options.pieces.slow_frames == 0 or not thing.motion.slow(
        thing.unit
    )
    tells = view.lens is not None and (thing.weight > 0.0 or thing.pliant)
    if not (tells and asked) or thing.bends:
        return _NONE
    rest, least = _apart(view, place.around[~taken[place.around]], background), _least(thing)
    if len(rest) < least:
        return _NONE
    xyz = view.xyz[rest].astype(np.float64)
    piece = pieces(xyz, thing.unit, options=options.link)
    size = np.bincount(piece)
    number = len(size)
    lo, hi = place.box
    edge = options.pieces.touching_units * thing.unit
    outside = np.bincount(piece[~within(xyz, lo + edge, hi - edge)], minlength=number)
    found, left = [_NONE], options.pieces.max_size_share * thing.size - len(core)
    for one in np.flatnonzero((size >= least) & (size <= left) & (outside == 0)).tolist():
        mine = piece == one
        points = rest[mine]
        if len(points) > left or not _looks_like(thing, view, core, points, background):
            continue
        if _is_its(thing, view, place, core, points, xyz[~mine]):
            found.append(points)
            left -= len(points)
    return np.sort(np.concatenate(found))


def _apart(view: View, points: I64, background: Background) -> I64:
    """Those of the points (M,) that lie before what never moves."""
    return points[~(background.static(view, points)[0] | background.drawn_on(view, points))]


def _least(thing: Thing) -> float:
    """How many points a piece has at least."""
    options = thing.options.pieces
    return max(options.min_points, options.min_size_share * thing.size)


def _looks_like(thing: Thing, view: View, core: I64, points: I64, background: Background) -> bool:
    """Whether a piece has the thing's colours, or is small and has come to rest with it."""
    options = thing.options.pieces
    colour = view.colour(points)
    if thing.worn.share(colour) >= options.alike_colours_share and not thing.worn.unlike(colour):
        return True
    if not thing.motion.rests(thing.unit) or len(points) > options.other_colour_share * len(core):
        return False
    return (
        float(background.stayed(view, points, options.rested_frames).mean())
        > options.same_depth_share
    )


def _is_its(thing: Thing, view: View, place: Place, core: I64, points: I64, others: F64) -> bool:
    """Whether a piece touches the thing and no ``others`` (M, 3), and may be a part of it."""
    options = thing.options
    xyz = view.xyz[points].astype(np.float64)
    if not close_to(view.xyz[core], xyz, options.pieces.touching_units * thing.unit).any():
        return False
    if np.count_nonzero(
        close_to(others, xyz, options.pieces.lonely_units * thing.unit)
    ) > options.pieces.few_share * len(points):
        return False
    if not thing.motion.rests(thing.unit):
        away = xyz - transform(place.pose, thing.model.centre[None])
        far = np.linalg.norm(away, axis=1).max() > options.pieces.end_radii * thing.model.radius
        if far and len(points) > options.pieces.end_share * len(core):
            return False
        # What goes on behind the thing itself is what holds it.
        if cut_off(view, points, thing.unit, by=view.marked(core)):
            return False
    if thing.soft or len(thing.glimpses) < options.surface.carve_min_views:
        return True
    return (
        place.cost < options.pieces.sharp_cost
        and float(carved(thing.glimpses, view, place.pose, points, thing.unit).mean())
        < options.pieces.few_share
    )


_NONE: I64 = np.empty(0, np.int64)


def painted_with_ground(view: View, indices: I64) -> bool:
    """Whether most of the ground within the outline of painted points (M,) is painted too."""
    options = view.options.ground_contact
    inside = _within(view, view.xyz[indices].astype(np.float64))
    return (
        len(inside) >= options.min_points
        and float(np.isin(inside, indices).mean()) > options.painted_share
    )


def with_ground(
    view: View, things: Mapping[int, Thing], places: Mapping[int, Place], free: Mask
) -> dict[int, I64]:
    """The labels of a frame, and the ground under what was painted so: label → points (M,).

    ``free`` (N,) are those that a run may take.
    """
    found = dict(view.labels)
    have = [n for n in found if n in places and things[n].painted.grounded]
    rest = free & ~view.labelled() if have else free
    for label in have:
        ground = _within(view, places[label].world)
        ground = ground[rest[ground]]
        rest[ground] = False
        found[label] = together(found[label], ground)
    return found


def _within(view: View, world: F64) -> I64:
    """Sorted indices of what lies on the ground within the outline of ``world`` (M, 3)."""
    options = view.options.ground_contact
    none = np.empty(0, np.int64)
    if not view.scans or len(world) < options.min_corners:
        return none
    flat = np.delete(np.arange(3), view.up)
    try:
        sides = ConvexHull(world[:, flat]).equations
    except QhullError:
        return none
    lo, hi = bounds(world)
    lo[view.up] -= options.below_m
    near = view.box(lo, hi)
    near = near[view.ground[near]]
    away = view.xyz[near][:, flat] @ sides[:, :2].T + sides[:, 2]
    return np.asarray(near[(away <= 0.0).all(axis=1)])
