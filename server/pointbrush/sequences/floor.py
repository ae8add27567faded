"""Estimate of the floor: a sparse sample of points → a plane, and with it up.

Files follow several conventions: depth cameras look along +z with y down (or, in the Kinect SDK's
space, y up), lidar and surveys have z up, modelling tools y up.  Each convention is a hypothesis
with a prior; the one is taken that finds the best floor: a plane with many points on it, hardly
any below, and the sensor above.  Nothing here is random, so an import can be repeated.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Kind = Literal["camera", "survey", "unknown"]
"""Points of a depth image (y down, z forward), in map coordinates (z up), or of unknown axes."""

_MOST = 6000
_NEIGHBOURS = 12
_PLANES = 250
_MIN_SHARE = 0.04
_FEW = 100
STATED_TILT = 20.0
"""Greatest angle in degrees between a floor's normal and the up axis that a user gave."""


@dataclass(frozen=True, slots=True, eq=False)
class Floor:
    """The plane ``up · p = height`` in the sample's coordinates; ``up`` (3,) has length 1.

    ``forward`` (3,) is where a person should look first, at right angles to ``up``.
    """

    up: Vector
    height: float
    forward: Vector
    found: bool


@dataclass(frozen=True, slots=True)
class _Convention:
    up: tuple[float, float, float]
    forward: tuple[float, float, float]
    prior: float
    tilt: float
    """Greatest angle between ``up`` and the floor's normal, degrees."""


def thin(points: Vector, cells: int = 96) -> Vector:
    """One point (their mean) for each occupied cell of a grid over points (N, 3).

    A surface near the sensor then counts by its area and not by its density.
    """
    # Around the middle half: a lidar's few far returns must not make the cells coarse.
    low, high = np.quantile(points, [0.25, 0.75], axis=0)
    reach = float((high - low).max())
    size = max(2 * reach / cells, 1e-9)
    lo, hi = (low + high) / 2 - reach - 2 * size, (low + high) / 2 + reach + 2 * size
    inside = ((points >= lo) & (points <= hi)).all(axis=1)
    if 2 * int(inside.sum()) > len(points):
        points = points[inside]
    else:  # hardly any middle: keep all, in cells to suit
        lo, hi = points.min(axis=0), points.max(axis=0)
        size = max(float((hi - lo).max()) / cells, 1e-9)
    cell = np.floor((points - lo) / size).astype(np.int64) + 4
    keys = (cell[:, 0] * 2**20 + cell[:, 1]) * 2**20 + cell[:, 2]
    _, group, counts = np.unique(keys, return_inverse=True, return_counts=True)
    sums = np.stack([np.bincount(group, points[:, axis]) for axis in range(3)], axis=1)
    means: Vector = sums / counts[:, None]
    return means[:: -(-len(means) // _MOST)] if len(means) > _MOST else means


def frustum_depth(points: Vector) -> float:
    """+1 when the points lie in front of a camera at the origin along +z, -1 along -z, else 0."""
    if len(points) < _FEW:
        return 0.0
    for sign in (1.0, -1.0):
        depth = sign * points[:, 2]
        wide = np.abs(points[:, :2]) < 1.5 * np.maximum(depth, 0)[:, None]
        low, high = np.quantile(points[:, :2], [0.02, 0.98], axis=0)
        if float(wide.all(axis=1).mean()) > 0.99 and (low < 0).all() and (high > 0).all():
            return sign
    return 0.0


def _conventions(points: Vector, kind: Kind, depth: float) -> list[_Convention]:
    ahead = (0.0, 0.0, 1.0)
    z_up = _Convention((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), 1.0, 20.0)
    y_up = _Convention((0.0, 1.0, 0.0), (0.0, 0.0, -1.0), 0.9, 60.0 if depth else 20.0)
    y_down = _Convention((0.0, -1.0, 0.0), ahead, 0.7, 20.0)
    if kind == "camera":
        return [_Convention((0.0, -1.0, 0.0), ahead, 1.0, 60.0)]
    if kind == "survey":
        return [z_up]
    if depth > 0:
        below = _nearer_below(points)
        return [
            _Convention((0.0, -1.0, 0.0), ahead, 1.0 + below, 60.0),
            _Convention((0.0, 1.0, 0.0), ahead, 0.9 * (1.0 - below), 60.0),
            _Convention((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), 0.3, 20.0),
        ]
    # A bare object of less than a metre is more often a model, and models have y up.
    small = float(np.ptp(points, axis=0).max()) < 1.0
    if small or depth < 0:
        return [y_up, z_up]
    return [_wide(choice, points) for choice in (z_up, y_up, y_down)]


def _wide(choice: _Convention, points: Vector) -> _Convention:
    """The convention, a little likelier when the recording is wider than high under it."""
    low, high = np.quantile(points, [0.02, 0.98], axis=0)
    upright = np.abs(np.array(choice.up)) > 0.5
    height, width = float((high - low)[upright][0]), float((high - low)[~upright].mean())
    factor = np.clip(width / height, 0.75, 1.33) if height > 0 else 1.33
    return replace(choice, prior=choice.prior * float(factor))


def _nearer_below(points: Vector) -> float:
    """Return -1..1: 1 if points at greater y / z are nearer, as a floor below a y-down camera."""
    slope, inverse = points[:, 1] / points[:, 2], 1.0 / points[:, 2]
    if len(points) < 3 or np.ptp(slope) == 0 or np.ptp(inverse) == 0:
        return 0.0
    return float(np.corrcoef(slope, inverse)[0, 1])


def _normals(points: Vector) -> tuple[Vector, Vector]:
    """Return normals (N, 3) from the neighbours of each point, and their deviation from a plane."""
    from scipy.spatial import cKDTree

    _, near = cKDTree(points).query(points, k=min(_NEIGHBOURS, len(points)))
    local = points[near] - points[near].mean(axis=1, keepdims=True)
    values, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", local, local))
    return vectors[:, :, 0], values[:, 0] / np.maximum(values.sum(axis=1), 1e-30)


def _stated_up(up: Vector) -> _Convention:
    """Return the convention of an up axis (3,) that a user gave."""
    forward = (0.0, 0.0, -float(np.sign(up[1]))) if up[1] else (0.0, 1.0, 0.0)
    return _Convention((float(up[0]), float(up[1]), float(up[2])), forward, 1.0, STATED_TILT)


def find_floor(
    points: Vector, viewpoints: Vector, kind: Kind = "unknown", up: Vector | None = None
) -> Floor:
    """The floor under points (N, 3) seen from ``viewpoints`` (V, 3), V may be 0.

    ``up`` (3,), where it is known, is the axis of the coordinates that points up.
    """
    if len(points) == 0:
        return Floor(np.array([0.0, 1, 0]), 0.0, np.array([0.0, 0, -1]), found=False)
    depth = frustum_depth(points) if kind == "unknown" else 0.0
    if depth and len(viewpoints) == 0:
        viewpoints = np.zeros((1, 3))
    choices = _conventions(points, kind, depth) if up is None else [_stated_up(up)]
    points = thin(points)
    best: tuple[float, _Convention, Vector, float] | None = None
    if len(points) >= 3 * _NEIGHBOURS:
        normals, bend = _normals(points)
        for choice in choices:
            plane = _best_plane(points, normals, bend, viewpoints, choice)
            if plane is not None and (best is None or plane[0] > best[0]):
                best = (plane[0], choice, plane[1], plane[2])
    if best is None:
        axis = np.array(choices[0].up)
        height = float(np.quantile(points @ axis, 0.01))
        return Floor(axis, height, _level(np.array(choices[0].forward), axis), found=False)
    _, choice, axis, height = best
    return Floor(axis, height, _level(np.array(choice.forward), axis), found=True)


def _best_plane(
    points: Vector, normals: Vector, bend: Vector, viewpoints: Vector, choice: _Convention
) -> tuple[float, Vector, float] | None:
    """Score, normal and height of the best floor under one convention, or None."""
    axis = np.array(choice.up)
    cosine = normals @ axis
    facing = normals * np.where(cosine < 0, -1.0, 1.0)[:, None]
    seeds = np.flatnonzero((np.abs(cosine) > np.cos(np.radians(choice.tilt))) & (bend < 0.02))
    if len(seeds) == 0:
        return None
    seeds = seeds[:: -(-len(seeds) // _PLANES)]
    tolerance = float(np.ptp(points, axis=0).max()) / 96
    heights = np.einsum("ij,ij->i", points[seeds], facing[seeds])
    above = points @ facing[seeds].T - heights
    scores = _score(above, tolerance) * _sensor_above(viewpoints, facing[seeds], heights, tolerance)
    winner = int(scores.argmax())
    up, height = facing[seeds[winner]], float(heights[winner])
    for finer in (1.0, 0.5, 0.25, 0.25):
        up, height = _refine(points, up, height, tolerance * finer)
    if float(up @ axis) < np.cos(np.radians(choice.tilt)):
        return None
    above = (points @ up - height)[:, None]
    share = float(_score(above, tolerance)[0])
    if share < _MIN_SHARE:
        return None
    # A small term for the angle to the axis decides between equal planes.
    return share * choice.prior * (0.5 + 0.5 * float(up @ axis)), up, height


def _score(above: Vector, tolerance: float) -> Vector:
    """Return the share of points on each plane minus twice that below; ``above`` (N, planes)."""
    on = (np.abs(above) < tolerance).mean(axis=0)
    below = (above < -2 * tolerance).mean(axis=0)
    score: Vector = on - 2.0 * below
    return score


def _sensor_above(
    viewpoints: Vector, ups: Vector, heights: Vector, tolerance: float
) -> NDArray[np.float64]:
    """1 for planes (P, 3), (P,) that lie below every known viewpoint, else a small factor."""
    if len(viewpoints) == 0:
        return np.ones(len(ups))
    clear = (viewpoints @ ups.T - heights > tolerance).all(axis=0)
    return np.where(clear, 1.0, 0.1)


def _refine(points: Vector, up: Vector, height: float, tolerance: float) -> tuple[Vector, float]:
    """The least-squares plane through the points on a plane."""
    on = points[np.abs(points @ up - height) < tolerance]
    if len(on) < 3:
        return up, height
    centre = on.mean(axis=0)
    normal = np.linalg.eigh((on - centre).T @ (on - centre))[1][:, 0]
    normal = normal if normal @ up > 0 else -normal
    return normal, float(normal @ centre)


def _level(forward: Vector, up: Vector) -> Vector:
    """``forward`` without its part along ``up``, length 1; any level direction if none is left."""
    level = forward - (forward @ up) * up
    if float(np.linalg.norm(level)) < 1e-6:
        level = np.eye(3)[int(np.abs(up).argmin())]
        level = level - (level @ up) * up
    unit: Vector = level / np.linalg.norm(level)
    return unit
