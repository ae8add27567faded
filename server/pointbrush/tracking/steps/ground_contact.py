"""Ground painted with a track, and its tyres and feet on the ground."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from pointbrush.tracking.compute.grid import bounds
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import together

_NONE: I64 = np.empty(0, np.int64)


def painted_with_ground(view: View, indices: I64) -> bool:
    """Return whether most of the ground within the outline of painted points (M,) is painted."""
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
    """Return the points (M,) by label with tyres and feet, and with ground if painted with it.

    ``free`` (N,): mask of points that a run may take.
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
    """Return sorted indices of the ground around ``world`` (M, 3), ``beside`` metres to its sides.

    It includes ground far below, in either direction of the vertical axis.
    """
    margin = np.full(3, beside)
    margin[view.up] = view.options.ground_contact.below_m
    lo, hi = bounds(world)
    around = view.box(lo - margin, hi + margin)
    return np.asarray(around[view.ground[around]])


def _feet(view: View, world: F64) -> I64:
    """Return sorted indices of points above the ground below the lowest part of ``world`` (M, 3).

    Tyres touch the ground and are taken for it; their former places are background.
    """
    options = view.options.ground_contact
    ground = _ground_about(view, world, options.beside_m)
    if len(ground) < options.min_points:
        return _NONE
    flat, up = np.delete(np.arange(3), view.up), view.up

    def level(xyz: NDArray[np.floating]) -> F64:
        return np.column_stack([xyz[:, flat], np.ones(len(xyz))])

    off: F64 = np.zeros(len(ground))
    plane: F64 = np.zeros(3)
    for _ in range(2):  # The second fit excludes tyres, which are outliers of the ground.
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
    """Return the ``points`` (N,) within the outline of ``world`` (M, 3) from above."""
    if not view.scans or len(world) < view.options.ground_contact.min_corners:
        return _NONE
    flat = np.delete(np.arange(3), view.up)
    try:
        sides = ConvexHull(world[:, flat]).equations
    except QhullError:
        return _NONE
    distance = view.xyz[points][:, flat] @ sides[:, :2].T + sides[:, 2]
    return np.asarray(points[(distance <= 0.0).all(axis=1)])
