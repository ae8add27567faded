"""What the points that a person painted look like: how dense, how long, how flat they are."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.tracking.interface import F32, F64, I64
from pointbrush.tracking.sensor.view import View

RINGS, ASIDE, BETWEEN = 24, 0.5, 0.3
"""Neighbours among which the next ring of a lidar is looked for, the cosine of a way aside, and the
share of the way between rings that is a unit."""
RIM, EDGE = 2, 0.15
"""Pixels from the edge of the picture, and the share of what is painted that lies there."""
SAMPLE = 400
"""Points whose neighbours are looked at."""
LONE, FINEST = 0.02, 1e-4
"""Metres between points where there are too few to tell, and at least, where all are one point."""
BLACK = 0.1
"""Share of exactly black points from which many were seen by no camera."""
LEAST_NOISE = 0.03
"""Colour noise is at least this, in the units of ``View.colour``."""


def cut_off_by_edge(view: View, indices: I64) -> bool:
    """Whether much of what is painted lies at the edge of the picture: there is more of it.

    Where nothing unlabelled reaches as far, what is painted ends, and not the picture.
    """
    if view.lens is None:
        return False
    others, away = ~view.labelled(), np.inf
    for at in np.divmod(view.cells.cell, view.lens.shape[1]):
        for side in (at, -at):
            if others.any() and side[others].min() < side.min() + RIM:
                away = np.minimum(away, side[indices] - side.min())
    return float(np.mean(away < RIM)) > EDGE


def away_from(view: View, xyz: F64) -> float:
    """Metres of points (M, 3) from the sensor, 0 where its place is unknown."""
    return 0.0 if view.eye is None else float(np.linalg.norm(xyz.mean(axis=0) - view.eye))


def across_way(xyz: F64) -> float:
    """Metres of deviation of points (M, 3) across the way in which they are longest."""
    if len(xyz) < 3:
        return 0.0
    return float(np.sqrt(max(np.linalg.eigvalsh(np.cov(xyz.T))[1], 0.0)))


def texture(xyz: F64, colour: F32) -> tuple[float, float]:
    """Median distance and colour difference between neighbours."""
    if len(xyz) < 3:
        return LONE, LEAST_NOISE
    sample = np.arange(0, len(xyz), max(1, len(xyz) // SAMPLE))
    distance, near = cKDTree(xyz).query(xyz[sample], k=2)
    gaps = np.asarray(distance)[:, 1]
    unlike = np.linalg.norm(colour[sample] - colour[np.asarray(near)[:, 1]], axis=1)
    return max(float(np.median(gaps)), FINEST), float(np.median(unlike))


def across_rings(xyz: F64) -> float:
    """Median distance to the nearest point aside of the way to the nearest of all.

    Lidars measure densely along a ring, and the next ring is far.
    """
    if len(xyz) < RINGS:
        return 0.0
    sample = xyz[:: max(1, len(xyz) // SAMPLE)]
    distance, near = cKDTree(xyz).query(sample, k=RINGS)
    way = xyz[np.asarray(near)[:, 1:]] - sample[:, None]
    length = np.asarray(distance)[:, 1:] + 1e-9
    along = np.abs((way * way[:, :1]).sum(axis=2)) / (length * length[:, :1])
    length = np.where(along < ASIDE, length, length[:, -1:])
    return float(np.median(length.min(axis=1)))


def uneven(xyz: F64) -> float:
    """Median distance of points (M, 3) from the plane through them."""
    if len(xyz) < RINGS:
        return np.inf
    away = xyz - xyz.mean(axis=0)
    normal = np.linalg.eigh(away.T @ away)[1][:, 0]
    return float(np.median(np.abs(away @ normal)))


def colourless(view: View, indices: I64) -> bool:
    """Whether many of the points were seen by no camera: exactly black."""
    rgb = view.frame.rgb
    return rgb is None or float((~np.asarray(rgb)[indices].any(axis=1)).mean()) > BLACK
