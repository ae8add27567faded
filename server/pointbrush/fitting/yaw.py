"""Yaw of an object by its outline in plan: one, two or three sides of a rectangle.

A search over yaw finds the rectangle with sides closest to the points (the closeness criterion of
Zhang, Xu, Dong and Dolan, "Efficient L-shape fitting for vehicle detection", IV 2017).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.fitting.options import FitOptions

Floats = NDArray[np.float64]
TRIM = 0.01
"""Share of the points outside a rectangle on each side."""


def turn(yaw: float) -> Floats:
    """Return the rotation (2, 2) by ``yaw`` radians."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s], [s, c]])


def upright(yaw: float) -> Floats:
    """Return the rotation (3, 3) by ``yaw`` radians about the vertical."""
    R = np.eye(3)
    R[:2, :2] = turn(yaw)
    return R


def wrapped(angle: float | Floats, period: float = 2 * np.pi) -> Floats:
    """Return angles wrapped to half a period around 0."""
    return np.asarray((np.asarray(angle) + period / 2) % period - period / 2)


def thinned(plan: Floats, cell: float) -> Floats:
    """Return the mean of the points (n, 2) in each cell, for a uniform density."""
    _, group, counts = np.unique(
        np.floor(plan / cell), axis=0, return_inverse=True, return_counts=True
    )
    sums = np.stack([np.bincount(group.ravel(), plan[:, a]) for a in range(2)], axis=1)
    return np.asarray(sums / counts[:, None])


def closeness(plan: Floats, yaws: Floats, floor: float) -> Floats:
    """Return scores (k,) of yaws by the closeness of points (n, 2) to a rectangle's sides."""
    c, s = np.cos(yaws), np.sin(yaws)
    scores = np.full((2, len(plan), len(yaws)), np.inf)
    for axis, (x, y) in enumerate(((c, s), (-s, c))):
        along = plan[:, :1] * x + plan[:, 1:] * y
        low, high = np.quantile(along, [TRIM, 1 - TRIM], axis=0)
        scores[axis] = np.minimum(np.abs(along - low), np.abs(high - along))
    near = np.maximum(scores.min(axis=0), floor)
    return np.asarray((floor / near).mean(axis=0))


def outline_yaws(xyz: Floats, options: FitOptions) -> list[tuple[float, float]]:
    """Return the most likely yaws of the sides of points (n, 3), modulo a right angle.

    Yaws are in radians, 0 to half pi, each with the closeness of points to the sides, 0 to 1.
    """
    plan = thinned(xyz[:, :2] - xyz[:, :2].mean(axis=0), options.yaw_cell)
    step = np.radians(options.yaw_step)
    yaws = np.arange(0, np.pi / 2, step)
    scores = closeness(plan, yaws, options.yaw_floor)
    apart = round(np.radians(options.yaw_apart) / step)
    found = []
    left = scores.copy()
    for _ in range(options.yaw_choices):
        k = int(left.argmax())
        if not np.isfinite(left[k]):
            break
        fine = yaws[k] + np.arange(-step, step + 1e-9, np.radians(options.yaw_fine))
        finer = closeness(plan, fine, options.yaw_floor)
        found.append((float(fine[int(finer.argmax())]), float(finer.max())))
        left[np.arange(k - apart, k + apart + 1) % len(yaws)] = -np.inf
    return found


def outline_yaw(xyz: Floats, around: float, within: float, options: FitOptions) -> float:
    """Return the yaw of the sides of points (n, 3), in radians, ``within`` of ``around``."""
    plan = thinned(xyz[:, :2] - xyz[:, :2].mean(axis=0), options.yaw_cell)
    step = np.radians(options.yaw_step)
    yaws = around + np.arange(-within, within + step / 2, step)
    best = yaws[int(closeness(plan, yaws, options.yaw_floor).argmax())]
    fine = best + np.arange(-step, step + 1e-9, np.radians(options.yaw_fine))
    return float(fine[int(closeness(plan, fine, options.yaw_floor).argmax())])


def shoulder_yaw(xyz: Floats, ground: float | None, options: FitOptions) -> float | None:
    """Return the yaw of a standing person, across the shoulders, in radians.

    None: points (n, 3) do not show the shoulders.
    """
    low = float(xyz[:, 2].min()) if ground is None else ground
    share = (xyz[:, 2] - low) / max(float(np.quantile(xyz[:, 2], 0.99)) - low, 0.1)
    part = xyz[(share > options.shoulders[0]) & (share < options.shoulders[1]), :2]
    if len(part) < options.shoulder_points:
        return None
    (narrow, wide), axes = np.linalg.eigh(np.cov(part.T))
    if wide < options.shoulder_ratio**2 * narrow:
        return None
    return float(np.arctan2(axes[1, 0], axes[0, 0]))
