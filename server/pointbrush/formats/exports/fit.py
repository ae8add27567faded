"""Boxes round points: along the principal axes, and the smallest upright one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]
# More edges than this gain less than a thousandth of the area.
MAX_EDGES = 360


@dataclass(frozen=True, slots=True)
class Box:
    """``center`` (3,), ``size`` (3,) along the box's axes, ``R`` (3, 3) ``R_source_box``.

    ``yaw`` of an upright box turns its first axis about the vertical, -pi/2 to pi/2; else 0.
    """

    center: Matrix
    size: Matrix
    R: Matrix
    yaw: float = 0.0


def pca_box(xyz: NDArray[Any]) -> Box:
    """The box along the principal axes of (N, 3) points, N at least 1, longest spread first."""
    points = np.asarray(xyz, np.float64)
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(np.cov((points - middle).T, bias=True) + np.zeros((3, 3)))
    axes[2] = np.cross(axes[0], axes[1])
    turned = (points - middle) @ axes.T
    low, high = turned.min(axis=0), turned.max(axis=0)
    return Box(middle + (low + high) / 2 @ axes, high - low, axes.T.copy())


def upright_axes(up: NDArray[Any]) -> Matrix:
    """``R_upright_source`` (3, 3): rows forward, left, up; the identity for z up."""
    vertical = np.asarray(up, np.float64) / np.linalg.norm(up)
    aside = np.eye(3)[np.argmin(np.abs(vertical[:2]))] if abs(vertical[2]) < 0.9 else np.eye(3)[0]
    forward = aside - vertical * (aside @ vertical)
    forward /= np.linalg.norm(forward)
    return np.stack([forward, np.cross(vertical, forward), vertical])


def upright_box(xyz: NDArray[Any], up: NDArray[Any]) -> Box:
    """The smallest box round (N, 3) points, N at least 1, with its third axis along ``up``.

    One side of the smallest rectangle round points lies on an edge of their convex hull
    (Freeman and Shapira 1975).  The longer side is the first axis.
    """
    axes = upright_axes(up)
    points = np.asarray(xyz, np.float64)
    middle = points.mean(axis=0)
    turned = (points - middle) @ axes.T
    yaw, low, high = _smallest_rectangle(turned[:, :2])
    center = np.append(_turn(yaw) @ (low + high) / 2, (turned[:, 2].min() + turned[:, 2].max()) / 2)
    R_upright_box = np.eye(3)
    R_upright_box[:2, :2] = _turn(yaw)
    size = np.append(high - low, np.ptp(turned[:, 2]))
    return Box(middle + center @ axes, size, axes.T @ R_upright_box, yaw)


def _turn(yaw: float) -> Matrix:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s], [s, c]])


def _smallest_rectangle(flat: Matrix) -> tuple[float, Matrix, Matrix]:
    """Yaw of the long side, and the extent along the turned axes."""
    corners = _hull(flat)
    edges = np.roll(corners, -1, axis=0) - corners
    edges = edges[np.any(edges != 0, axis=1)]
    edges = edges[:: len(edges) // MAX_EDGES + 1] if len(edges) else np.array([[1.0, 0.0]])
    angles = np.arctan2(edges[:, 1], edges[:, 0])
    extents = [(corners @ _turn(angle)) for angle in angles]
    # Points on a line have no area at any angle along it: the sum of the sides decides then.
    sides = [np.ptp(turned, axis=0) for turned in extents]
    best = int(np.argmin([side[0] * side[1] + 1e-9 * side.sum() for side in sides]))
    yaw = float(angles[best]) + (np.pi / 2 if sides[best][1] > sides[best][0] else 0.0)
    yaw = (yaw + np.pi / 2) % np.pi - np.pi / 2
    turned = corners @ _turn(yaw)
    return yaw, turned.min(axis=0), turned.max(axis=0)


def _hull(flat: Matrix) -> Matrix:
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(flat[ConvexHull(flat).vertices] if len(flat) > 2 else flat)
    except QhullError:
        # On one line: the two ends are the hull.
        along = flat[:, 0] + 1e-3 * flat[:, 1]
        return flat[[int(np.argmin(along)), int(np.argmax(along))]]
