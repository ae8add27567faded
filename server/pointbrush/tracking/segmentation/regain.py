"""Surface of a thing that was missed for a while: pieces beside it that are nobody else's.

What is missed once lies unlabelled beside the thing ever after, and explains itself as unlabelled.
But a hand goes on to an arm, and out of the picture; a piece that ends all round, touches nothing
but the thing and what never moves, and has the colours that the thing was painted with, is its.  So
is one of other colours that has come to rest with it: a side that it had not shown.  Without
colours that holds of what bends beyond doubt, whose folds and rims are missed ever again.
"""

from __future__ import annotations

import numpy as np

from pointbrush.tracking.background.depth_background import Background
from pointbrush.tracking.geometry.components import pieces
from pointbrush.tracking.geometry.near import close_to, within
from pointbrush.tracking.geometry.registration import transform
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.objects.free_space import carved
from pointbrush.tracking.objects.place import Place
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.segmentation.assign import cut_off
from pointbrush.tracking.sensor.view import View


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
