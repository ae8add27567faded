"""Smooth paths through positions found frame by frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.fitting.yaw import wrapped

Floats = NDArray[np.float64]
HUBER = 2.0
"""Standard deviations from the path beyond which a position has a lower weight."""
PASSES = 4


def bends(times: Floats) -> Floats:
    """Return the matrix (k - 2, k) of second derivatives at uneven times (k,) in seconds."""
    rows = np.zeros((max(len(times) - 2, 0), len(times)))
    for k in range(len(rows)):
        a, b = times[k + 1] - times[k], times[k + 2] - times[k + 1]
        rows[k, k : k + 3] = 2 / (a * (a + b)), -2 / (a * b), 2 / (b * (a + b))
    return rows


def _weighted_bends(times: Floats) -> Floats:
    """Return the matrix of ``bends`` with rows weighted by the duration of adjacent intervals."""
    return np.asarray(bends(times) * np.sqrt((times[2:] - times[:-2]) / 2)[:, None] * 2)


def smooth_path(
    places: Floats, noise: Floats, yaws: Floats, times: Floats, acceleration: float
) -> Floats:
    """Return smoothed positions (k, 2).

    ``noise`` (k, 2): metres along and across ``yaws`` (k,), in radians; ``acceleration``: standard
    deviation of the path's acceleration in metres per second squared.
    """
    k = len(places)
    if k < 3:
        return places
    D = np.kron(_weighted_bends(times), np.eye(2)) / acceleration
    c, s = np.cos(yaws), np.sin(yaws)
    axes = np.stack([np.stack([c, s], 1), np.stack([-s, c], 1)], 1)  # (k, along or across, 2)
    weight = np.ones((k, 2))
    path: Floats = places
    for _ in range(PASSES):
        A, b = D.T @ D, np.zeros(2 * k)
        for i in range(k):
            W = axes[i].T @ np.diag(weight[i] / noise[i] ** 2) @ axes[i]
            A[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] += W
            b[2 * i : 2 * i + 2] += W @ places[i]
        path = np.asarray(np.linalg.solve(A, b).reshape(k, 2), np.float64)
        off = np.abs(np.einsum("kij,kj->ki", axes, path - places)) / noise
        weight = np.minimum(1, HUBER / np.maximum(off, 1e-9))
    return np.asarray(path)


def smooth_angles(angles: Floats, noise: Floats, times: Floats, swerve: float) -> Floats:
    """Return smoothed angles (k,) in radians, with standard deviations ``noise`` (k,).

    ``swerve``: standard deviation of the change of the yaw rate in radians per second squared.
    """
    unwrapped = np.unwrap(angles)
    if len(angles) < 3:
        return unwrapped
    D = _weighted_bends(times) / swerve
    weight = np.ones(len(angles))
    smooth: Floats = unwrapped
    for _ in range(PASSES):
        w = weight / noise**2
        smooth = np.asarray(np.linalg.solve(D.T @ D + np.diag(w), w * unwrapped))
        weight = np.minimum(1, HUBER / np.maximum(np.abs(smooth - unwrapped) / noise, 1e-9))
    return np.asarray(wrapped(smooth))


def speeds(path: Floats, times: Floats) -> Floats:
    """Return velocities (k, 2), in metres per second, along a path (k, 2)."""
    if len(path) < 2:
        return np.zeros_like(path)
    return np.asarray(np.gradient(path, times, axis=0))
