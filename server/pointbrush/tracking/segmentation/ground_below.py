"""The ground under a thing that was painted with it, as the boxes of lidar data sets do.

A lidar on the move sees other points of it in every frame, and what drives is on other ground in
every frame: it is no part of a model.  It is what lies on the ground within the thing's outline.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from pointbrush.tracking.geometry.near import bounds
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.objects.place import Place
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.segmentation.assign import together
from pointbrush.tracking.sensor.view import View


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
