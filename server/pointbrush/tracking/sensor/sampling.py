"""How evenly the directions of points fill an image, by which its sensor's place is found closely.

A pinhole camera samples its image evenly: from its place every small part of it holds as many
points.  From beside it what is near and what is far lie more or less densely than each other.
"""

from __future__ import annotations

import numpy as np

from pointbrush.tracking.interface import F64
from pointbrush.tracking.sensor.lens import axes_along

PART = 4.0
"""Spacings of the points across a part of the image."""
AHEAD, NARROW = 0.6, 0.45
"""Length of the mean ray of an image at least, and cosine from it below which it is far aside."""
ALONG = (0.4, 0.5, 0.6, 0.7, 0.85, 1.0, 1.2, 1.5)
"""Shares of the distance at which it is begun: how far away the sensor is shows least in what it
hides."""
STEPS = (0.2, 0.003)
"""First and last step, in sizes of the scene."""


def evened(xyz: F64, place: F64, size: float) -> F64:
    """The place (3,) near ``place`` from which points (N, 3) fill an image the most evenly.

    ``size`` metres of the scene.
    """
    middle = np.median(xyz, axis=0)
    starts = [middle + share * (place - middle) for share in ALONG]
    costs = [unevenness(xyz, start) for start in starts]
    place, least = starts[int(np.argmin(costs))], min(costs)
    ways = _ways(middle - place)
    step, last = (s * size for s in STEPS)
    while step > last:
        before = least
        for way in ways:
            there = place + step * way
            cost = unevenness(xyz, there)
            if cost < least:
                place, least = there, cost
        if least == before:
            step /= 2
    return place


def unevenness(xyz: F64, place: F64) -> float:
    """How far, in logarithms, parts of the image hold more or fewer points than it is usual there.

    What is usual changes slowly over the image where that does not look along its axis.  inf
    where no image is so wide.
    """
    local = xyz - place
    rays = local / (np.sqrt(np.einsum("ij,ij->i", local, local))[:, None] + 1e-9)
    forward = rays.mean(axis=0)
    straight = float(np.linalg.norm(forward))
    if straight < AHEAD:
        return np.inf
    to_right, to_bottom, ahead = axes_along(forward / straight)
    depth = np.maximum(rays @ ahead, NARROW)
    across, down = rays @ to_right / depth, rays @ to_bottom / depth
    pitch = PART * float(np.sqrt(np.ptp(across) * np.ptp(down) / len(xyz))) + 1e-9
    column, row = (((t - t.min()) / pitch).astype(np.int64) for t in (across, down))
    width = int(column.max()) + 1
    count = np.bincount(row * width + column)
    part = np.flatnonzero(count >= PART)
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
