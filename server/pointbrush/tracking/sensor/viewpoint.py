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
from pointbrush.tracking.sensor.lens import SPREAD, axes_along
from pointbrush.tracking.sensor.sampling import AHEAD, NARROW, evened

FEWEST = 2000
"""Points from which a place can be told."""
AWAY, DIRECTIONS = (0.7, 1.0, 1.4, 2.0, 2.8), 160
"""Distances from the middle at which it is looked for, in sizes of the scene, and directions."""
COARSE, FINE = 4_000, 30_000
"""Points that places are compared by, far apart and close together."""
BEST = 4
"""Places from which it is looked for closer."""
STEPS = (0.3, 0.005, 0.002)
"""First and last step there, and the last one by all points, in sizes of the scene."""
HIDDEN = 0.05
"""Sizes of the scene behind another point from which a point would be hidden."""
AT_MOST = 0.06
"""Share of the points that may be hidden, outlines that they are: of what several sensors saw
more than twice as many are, from wherever."""
PERHAPS = 0.4
"""The same, far from the place, beyond which it is not looked for closer."""
STRAY = 0.002
"""Share of the points that may be farther aside than an image is wide."""


def find_camera(xyz: F32) -> F64 | None:
    """The place (3,) of a pinhole-like sensor from its points (N, 3); None where none can be.

    It has to be asked whether the points fill an image from there.
    """
    if len(xyz) < FEWEST:
        return None
    few, many, every = (_thinned(xyz, most) for most in (COARSE, FINE, len(xyz)))
    middle = np.median(few, axis=0)
    size = float(np.median(np.linalg.norm(few - middle, axis=1)))
    if size <= 0:
        return None
    places = middle + size * (np.array(AWAY)[:, None, None] * _all_round()).reshape(-1, 3)
    gap = HIDDEN * size
    costs = np.array([_hidden(few, place, gap) for place in places])
    if costs.min() > PERHAPS:
        return None
    first, last, least = (step * size for step in STEPS)
    likely = places[np.argsort(costs, kind="stable")[:BEST]]
    found = [_closer(many, place, gap, first, last) for place in likely]
    best = min(found, key=lambda place: _hidden(many, place, gap))
    if _hidden(many, best, gap) > 2 * AT_MOST:
        return None
    place = _closer(every, best, gap, 2 * last, least)
    if _hidden(every, place, gap) >= AT_MOST:
        return None
    closer = evened(many, place, size)
    return closer if _hidden(every, closer, gap) < AT_MOST else place


def _thinned(xyz: F32, most: int) -> F64:
    return np.asarray(xyz[:: max(1, len(xyz) // most)], np.float64)


def _all_round() -> F64:
    """(DIRECTIONS, 3) unit vectors, even: Fibonacci's lattice."""
    at = np.arange(DIRECTIONS) + 0.5
    down, round_ = np.arccos(1 - 2 * at / DIRECTIONS), np.pi * (1 + 5**0.5) * at
    across = np.sin(down)
    return np.stack([across * np.cos(round_), across * np.sin(round_), np.cos(down)], axis=1)


def _closer(xyz: F64, place: F64, gap: float, step: float, last: float) -> F64:
    """Go where fewer points are hidden, by steps along the axes that halve where none helps."""
    least = _hidden(xyz, place, gap)
    while step > last:
        before = least
        for way in (*np.eye(3), *-np.eye(3)):
            there = place + step * way
            cost = _hidden(xyz, there, gap)
            if cost < least:
                place, least = there, cost
        if least == before:
            step /= 2
    return place


def _hidden(xyz: F64, place: F64, gap: float) -> float:
    """Share of the points (N, 3) that others hide from a place; 1 where no image is so wide."""
    local = xyz - place
    away = np.sqrt(np.einsum("ij,ij->i", local, local)) + 1e-9
    rays = local / away[:, None]
    forward = rays.mean(axis=0)
    straight = float(np.linalg.norm(forward))
    if straight < AHEAD:
        return 1.0
    forward /= straight
    ahead = rays @ forward
    if (ahead < NARROW).mean() > STRAY:
        return 1.0
    to_right, to_bottom, _ = axes_along(forward)
    depth = np.maximum(ahead, NARROW)
    across, down = rays @ to_right / depth, rays @ to_bottom / depth
    pitch = SPREAD * float(np.sqrt(np.ptp(across) * np.ptp(down) / len(xyz))) + 1e-9
    column, row = ((t - t.min()) / pitch for t in (across, down))
    cell = row.astype(np.int64) * (int(column.max()) + 1) + column.astype(np.int64)
    nearest = np.full(int(cell.max()) + 1, np.inf)
    np.minimum.at(nearest, cell, away)
    return float(np.mean(away > nearest[cell] + gap))
