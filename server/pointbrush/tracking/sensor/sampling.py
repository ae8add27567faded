"""How evenly the directions of points fill an image, by which its sensor's place is found closely.

A pinhole camera samples its image evenly: from its place every small part of it holds as many
points.  From beside it what is near and what is far lie more or less densely than each other.
"""

from __future__ import annotations

import numpy as np

from pointbrush.tracking.interface import F64
from pointbrush.tracking.options import ViewpointOptions
from pointbrush.tracking.sensor.lens import axes_along


def evened(xyz: F64, place: F64, size: float, options: ViewpointOptions) -> F64:
    """The place (3,) near ``place`` from which points (N, 3) fill an image the most evenly.

    ``size`` metres of the scene.
    """
    middle = np.median(xyz, axis=0)
    starts = [middle + share * (place - middle) for share in options.distance_shares]
    costs = [unevenness(xyz, start, options=options) for start in starts]
    place, least = starts[int(np.argmin(costs))], min(costs)
    ways = _ways(middle - place)
    step, last = (s * size for s in options.direction_steps)
    while step > last:
        before = least
        for way in ways:
            there = place + step * way
            cost = unevenness(xyz, there, options=options)
            if cost < least:
                place, least = there, cost
        if least == before:
            step /= 2
    return place


def unevenness(xyz: F64, place: F64, options: ViewpointOptions) -> float:
    """How far, in logarithms, parts of the image hold more or fewer points than it is usual there.

    What is usual changes slowly over the image where that does not look along its axis.  inf
    where no image is so wide.
    """
    local = xyz - place
    rays = local / (np.sqrt(np.einsum("ij,ij->i", local, local))[:, None] + 1e-9)
    forward = rays.mean(axis=0)
    straight = float(np.linalg.norm(forward))
    if straight < options.min_mean_ray:
        return np.inf
    to_right, to_bottom, ahead = axes_along(forward / straight)
    depth = np.maximum(rays @ ahead, options.min_ray_cos)
    across, down = rays @ to_right / depth, rays @ to_bottom / depth
    pitch = options.part_spacings * float(np.sqrt(np.ptp(across) * np.ptp(down) / len(xyz))) + 1e-9
    column, row = (((t - t.min()) / pitch).astype(np.int64) for t in (across, down))
    width = int(column.max()) + 1
    count = np.bincount(row * width + column)
    part = np.flatnonzero(count >= options.part_spacings)
    x, y = part % width * pitch, part // width * pitch
    slow = np.stack([np.ones(len(part)), x, y, x * x, x * y, y * y], axis=1)
    many = np.log(count[part])
    usual = slow @ np.linalg.lstsq(slow, many, rcond=None)[0]
    return float(np.abs(many - usual).mean()) if len(part) else np.inf


def _ways(forward: F64) -> F64:
    """(14, 3) along the axes of an image that looks along ``forward``, and askew in depth."""
    right, down, ahead = axes_along(forward / max(float(np.linalg.norm(forward)), 1e-9))
    askew = [a + b for a in (right, down, -right, -down) for b in (ahead, -ahead)]
    return np.array([right, down, ahead, -right, -down, -ahead, *askew])
