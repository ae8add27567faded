"""Which way is up before a depth camera: roughly as people stand, and truly as the floor lies.

How tall people are is compared across a room, where a degree is 5 cm.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from pointbrush.tracking.geometry.grid import cells_of
from pointbrush.tracking.interface import F64
from pointbrush.tracking.options import StatureOptions
from pointbrush.tracking.sensor.view import View


def across(view: View, people: Iterable[F64]) -> F64:
    """(3, 2) directions along the ground, to the right and ahead of the sensor.

    People (M, 3) each are longest upright; where they are not, the image's rows tell.
    """
    spread = np.zeros((3, 3))
    for xyz in people:
        away = xyz - xyz.mean(axis=0)
        spread += away.T @ away / len(xyz)
    right, down, ahead = view.T_picture_world[:3, :3]
    up = np.linalg.eigh(spread)[1][:, 2]
    up = up * np.sign(-up @ down)
    if -up @ down < view.options.stature.leaning_cos:
        up = -down
    flat = np.stack([way - (way @ up) * up for way in (right, ahead)], axis=1)
    return np.asarray(flat / np.linalg.norm(flat, axis=0))


def upright(view: View, flat: F64) -> F64:
    """(3,) the way up to a fraction of a degree: the normal of the floor, or of a table or ceiling,
    of all that is level the one that most lies on; where none is seen, off the ways along the
    ground ``flat`` (3, 2).

    Source: consensus as of Fischler and Bolles 1981, of planes through small patches.
    """
    options = view.options.stature
    up = np.cross(flat[:, 0], flat[:, 1])
    up = up / np.linalg.norm(up) * -np.sign(up @ view.T_picture_world[1, :3])
    rest = view.xyz[~view.labelled()][:: options.level_stride].astype(np.float64)
    if len(rest) < options.level_points:
        return up
    level = max(_patches(rest, up, options=options), key=len, default=rest[:0])
    for within in options.fit_m:
        if len(level) < options.level_points:
            return up
        normal, spread = _plane(level)
        level = rest[np.abs((rest - level.mean(axis=0)) @ normal) < within]
    return np.asarray(normal * np.sign(normal @ up)) if spread[1] > options.level_sigma_m**2 else up


def _patches(xyz: F64, up: F64, options: StatureOptions) -> Iterable[F64]:
    """The points (N, 3) about the plane of each patch that is level, roughly."""
    patch = cells_of(xyz, options.patch_m)
    count = np.bincount(patch)
    order = np.split(np.argsort(patch, kind="stable"), np.cumsum(count)[:-1])
    for n in np.flatnonzero(count >= max(options.patch_points, float(np.median(count)))).tolist():
        some = xyz[order[n]]
        normal, spread = _plane(some)
        if spread[0] < options.patch_flatness * spread[1] and abs(normal @ up) > options.patch_cos:
            yield xyz[np.abs((xyz - some.mean(axis=0)) @ normal) < options.fit_m[0]]


def _plane(xyz: F64) -> tuple[F64, F64]:
    """The normal (3,) of a plane through points (N, 3), and their variances (3,), least first."""
    spread, axes = np.linalg.eigh(np.cov(xyz.T))
    return axes[:, 0], spread
