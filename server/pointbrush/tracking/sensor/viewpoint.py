"""From where a frame was seen that lies in a room's coordinates and does not say it.

From the place of the sensor each direction shows one surface; from anywhere else things stand in
the way of what the sensor saw beside them.  The place where the fewest points are hidden is looked
for all around, and then closer and closer.  That leaves it open by as much as half the distance
how far away the place is, where few things stand before others; how evenly the points fill the
image tells it (``sampling.py``).
"""

from __future__ import annotations

import numpy as np

from pointbrush.tracking.interface import F32, F64
from pointbrush.tracking.options import TrackerOptions, ViewpointOptions
from pointbrush.tracking.sensor.lens import axes_along
from pointbrush.tracking.sensor.sampling import evened


def find_camera(xyz: F32, options: TrackerOptions) -> F64 | None:
    """The place (3,) of a pinhole-like sensor from its points (N, 3); None where none can be.

    It has to be asked whether the points fill an image from there.
    """
    if len(xyz) < options.viewpoint.min_points:
        return None
    few, many, every = (
        _thinned(xyz, most)
        for most in (options.viewpoint.coarse_points, options.viewpoint.fine_points, len(xyz))
    )
    middle = np.median(few, axis=0)
    size = float(np.median(np.linalg.norm(few - middle, axis=1)))
    if size <= 0:
        return None
    places = middle + size * (
        np.array(options.viewpoint.distance_sizes)[:, None, None]
        * _all_round(options=options.viewpoint)
    ).reshape(-1, 3)
    gap = options.viewpoint.hidden_sizes * size
    costs = np.array([_hidden(few, place, gap, options=options) for place in places])
    if costs.min() > options.viewpoint.hidden_share_far:
        return None
    first, last, least = (step * size for step in options.viewpoint.place_steps)
    likely = places[np.argsort(costs, kind="stable")[: options.viewpoint.followed_places]]
    found = [_closer(many, place, gap, first, last, options=options) for place in likely]
    best = min(found, key=lambda place: _hidden(many, place, gap, options=options))
    if _hidden(many, best, gap, options=options) > 2 * options.viewpoint.hidden_share:
        return None
    place = _closer(every, best, gap, 2 * last, least, options=options)
    if _hidden(every, place, gap, options=options) >= options.viewpoint.hidden_share:
        return None
    closer = evened(many, place, size, options=options.viewpoint)
    return (
        closer
        if _hidden(every, closer, gap, options=options) < options.viewpoint.hidden_share
        else place
    )


def _thinned(xyz: F32, most: int) -> F64:
    return np.asarray(xyz[:: max(1, len(xyz) // most)], np.float64)


def _all_round(options: ViewpointOptions) -> F64:
    """(DIRECTIONS, 3) unit vectors, even: Fibonacci's lattice."""
    at = np.arange(options.directions) + 0.5
    down, round_ = np.arccos(1 - 2 * at / options.directions), np.pi * (1 + 5**0.5) * at
    across = np.sin(down)
    return np.stack([across * np.cos(round_), across * np.sin(round_), np.cos(down)], axis=1)


def _closer(
    xyz: F64, place: F64, gap: float, step: float, last: float, options: TrackerOptions
) -> F64:
    """Go where fewer points are hidden, by steps along the axes that halve where none helps."""
    least = _hidden(xyz, place, gap, options=options)
    while step > last:
        before = least
        for way in (*np.eye(3), *-np.eye(3)):
            there = place + step * way
            cost = _hidden(xyz, there, gap, options=options)
            if cost < least:
                place, least = there, cost
        if least == before:
            step /= 2
    return place


def _hidden(xyz: F64, place: F64, gap: float, options: TrackerOptions) -> float:
    """Share of the points (N, 3) that others hide from a place; 1 where no image is so wide."""
    local = xyz - place
    away = np.sqrt(np.einsum("ij,ij->i", local, local)) + 1e-9
    rays = local / away[:, None]
    forward = rays.mean(axis=0)
    straight = float(np.linalg.norm(forward))
    if straight < options.viewpoint.min_mean_ray:
        return 1.0
    forward /= straight
    ahead = rays @ forward
    if (ahead < options.viewpoint.min_ray_cos).mean() > options.viewpoint.stray_share:
        return 1.0
    to_right, to_bottom, _ = axes_along(forward)
    depth = np.maximum(ahead, options.viewpoint.min_ray_cos)
    across, down = rays @ to_right / depth, rays @ to_bottom / depth
    pitch = (
        options.lens.pixel_spacings * float(np.sqrt(np.ptp(across) * np.ptp(down) / len(xyz)))
        + 1e-9
    )
    column, row = ((t - t.min()) / pitch for t in (across, down))
    cell = row.astype(np.int64) * (int(column.max()) + 1) + column.astype(np.int64)
    nearest = np.full(int(cell.max()) + 1, np.inf)
    np.minimum.at(nearest, cell, away)
    return float(np.mean(away > nearest[cell] + gap))
