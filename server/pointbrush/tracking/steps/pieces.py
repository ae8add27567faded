"""Parts of a track that registration leaves out: missed pieces, and ground below."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from pointbrush.tracking.compute.graph import pieces
from pointbrush.tracking.compute.grid import bounds, close_to, within
from pointbrush.tracking.compute.rigid import transform
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.surface import carved
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.scene.depth import Background
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import cut_off, together


def lost_pieces(
    track: Track, view: View, fit: Registration, core: I64, taken: Mask, background: Background
) -> I64:
    """The points (M,), sorted, of the pieces of ``track`` beside its points ``core``.

    ``taken`` (N,) points that a person has.  None where there is no depth image, which tells
    what never moves, or no colour, and the object is not ``pliant``.
    """
    options = track.options
    asked = (view.number + track.label) % options.pieces.slow_frames == 0 or not track.motion.slow(
        track.unit
    )
    tells = view.lens is not None and (track.weight > 0.0 or track.surely_soft)
    if not (tells and asked) or track.bends:
        return _NONE
    rest, least = _apart(view, fit.around[~taken[fit.around]], background), _least(track)
    if len(rest) < least:
        return _NONE
    xyz = view.xyz[rest].astype(np.float64)
    piece = pieces(xyz, track.unit, options=options.link)
    size = np.bincount(piece)
    number = len(size)
    lo, hi = fit.box
    edge = options.growth.step_units * track.unit
    outside = np.bincount(piece[~within(xyz, lo + edge, hi - edge)], minlength=number)
    found, left = [_NONE], options.pieces.max_size_share * track.size - len(core)
    for one in np.flatnonzero((size >= least) & (size <= left) & (outside == 0)).tolist():
        mine = piece == one
        points = rest[mine]
        if len(points) > left or not _looks_like(track, view, core, points, background):
            continue
        if _is_its(track, view, fit, core, points, xyz[~mine]):
            found.append(points)
            left -= len(points)
    return np.sort(np.concatenate(found))


def _apart(view: View, points: I64, background: Background) -> I64:
    """Return those of the points (M,) that lie before what never moves."""
    return points[~(background.static(view, points)[0] | background.drawn_on(view, points))]


def _least(track: Track) -> float:
    """Number of points that a piece has at least."""
    options = track.options.pieces
    return max(options.min_points, options.min_size_share * track.size)


def _looks_like(track: Track, view: View, core: I64, points: I64, background: Background) -> bool:
    """Whether a piece has the object's colours, or is small and has come to rest with it."""
    options = track.options.pieces
    colour = view.colour(points)
    if track.appearance.share(
        colour
    ) >= track.options.appearance.alike_share and not track.appearance.unlike(colour):
        return True
    if not track.motion.rests(track.unit) or len(points) > options.other_colour_share * len(core):
        return False
    return (
        float(background.stayed(view, points, options.rested_frames).mean())
        > options.same_depth_share
    )


def _is_its(
    track: Track, view: View, fit: Registration, core: I64, points: I64, others: F64
) -> bool:
    """Whether a piece touches the object and no ``others`` (M, 3), and may be a part of it."""
    options = track.options
    xyz = view.xyz[points].astype(np.float64)
    if not close_to(view.xyz[core], xyz, options.growth.step_units * track.unit).any():
        return False
    if np.count_nonzero(
        close_to(others, xyz, options.pieces.lonely_units * track.unit)
    ) > options.pieces.few_share * len(points):
        return False
    if not track.motion.rests(track.unit):
        away = xyz - transform(fit.pose, track.model.centre[None])
        far = np.linalg.norm(away, axis=1).max() > options.pieces.end_radii * track.model.radius
        if far and len(points) > options.pieces.end_share * len(core):
            return False
        # What goes on behind the object itself is what holds it.
        if cut_off(view, points, track.unit, by=view.marked(core)):
            return False
    if track.soft or len(track.carving_views) < options.surface.carve_min_views:
        return True
    return (
        fit.cost < options.claim.sharp_cost
        and float(carved(track.carving_views, view, fit.pose, points, track.unit).mean())
        < options.pieces.few_share
    )


_NONE: I64 = np.empty(0, np.int64)


def painted_with_ground(view: View, indices: I64) -> bool:
    """Whether most of the ground within the outline of painted points (M,) is painted too."""
    options = view.options.ground_contact
    xyz = view.xyz[indices].astype(np.float64)
    inside = _within(view, _ground_about(view, xyz, 0.0), xyz)
    return (
        len(inside) >= options.min_points
        and float(np.isin(inside, indices).mean()) > options.painted_share
    )


def with_ground(
    view: View, tracks: Mapping[int, Track], fits: Mapping[int, Registration], free: Mask
) -> dict[int, I64]:
    """The labels of a frame, with tyres and feet, and the ground under what was painted so: label
    → points (M,).

    ``free`` (N,) are those that a run may take.
    """
    found = dict(view.labels)
    have = [n for n in found if n in fits and view.scans and not tracks[n].painted.flat]
    rest = free & ~view.labelled() if have else free
    for label in have:
        world = fits[label].world
        if tracks[label].painted.grounded:
            more = _within(view, _ground_about(view, world, 0.0), world)
        else:
            more = _feet(view, world)
        more = more[rest[more]]
        rest[more] = False
        found[label] = together(found[label], more)
    return found


def _ground_about(view: View, world: F64, beside: float) -> I64:
    """Sorted indices of the ground about ``world`` (M, 3), also well below it, whichever way that
    is, and ``beside`` metres to its sides."""
    margin = np.full(3, beside)
    margin[view.up] = view.options.ground_contact.below_m
    lo, hi = bounds(world)
    around = view.box(lo - margin, hi + margin)
    return np.asarray(around[view.ground[around]])


def _feet(view: View, world: F64) -> I64:
    """Sorted indices of what stands out of the ground within the outline of the lowest part of
    ``world`` (M, 3): tyres touch the ground, and where that was is background."""
    options = view.options.ground_contact
    ground = _ground_about(view, world, options.beside_m)
    if len(ground) < options.min_points:
        return _NONE
    flat, up = np.delete(np.arange(3), view.up), view.up

    def level(xyz: NDArray[np.floating]) -> F64:
        return np.column_stack([xyz[:, flat], np.ones(len(xyz))])

    off: F64 = np.zeros(len(ground))
    plane: F64 = np.zeros(3)
    for _ in range(2):  # Tyres are among what is taken for the ground.
        level_ones = ground[off <= np.median(off)]
        xyz = view.xyz[level_ones].astype(np.float64)
        plane = np.asarray(np.linalg.lstsq(level(xyz), xyz[:, up], rcond=None)[0], np.float64)
        off = np.asarray(np.abs(view.xyz[ground, up] - level(view.xyz[ground]) @ plane))
    above = world[:, up] - level(world) @ plane
    way = np.sign(np.median(above))
    lowest = world[above * way < options.feet_m]
    lo, hi = bounds(lowest) if len(lowest) else bounds(world)
    lo[up], hi[up] = lo[up] - options.below_m, hi[up] + options.below_m
    some = _within(view, view.box(lo, hi), lowest)
    above = way * (view.xyz[some, up] - level(view.xyz[some]) @ plane)
    least = options.ground_medians * float(np.median(off))
    return np.asarray(some[(above > least) & (above < options.feet_m)])


def _within(view: View, points: I64, world: F64) -> I64:
    """Keep the ``points`` (N,) that lie within the outline of ``world`` (M, 3), seen from
    above."""
    if not view.scans or len(world) < view.options.ground_contact.min_corners:
        return _NONE
    flat = np.delete(np.arange(3), view.up)
    try:
        sides = ConvexHull(world[:, flat]).equations
    except QhullError:
        return _NONE
    away = view.xyz[points][:, flat] @ sides[:, :2].T + sides[:, 2]
    return np.asarray(points[(away <= 0.0).all(axis=1)])
