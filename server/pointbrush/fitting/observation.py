"""Observations of an object, one per frame, and their views in level coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from pointbrush.errors import BadInputError
from pointbrush.fitting.options import FitOptions
from pointbrush.fitting.rays import ground_height
from pointbrush.geometry.rotations import upright_axes

Floats = NDArray[np.float64]
NO_POINTS: Floats = np.zeros((0, 3))


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """An object in one frame, in source coordinates and metres.

    ``xyz`` (n, 3): its points; ``up`` (3,): the vertical; ``time``: seconds; ``sensor`` (3,): its
    position, if known; ``T_world_frame`` (4, 4): pose of the sensor, if known; ``others`` (m, 3):
    other points, on the ground nearby, and behind and in front of the object.
    """

    frame: int
    xyz: Floats
    up: Floats
    time: float
    sensor: Floats | None = None
    T_world_frame: Floats | None = None
    others: Floats = field(default_factory=lambda: NO_POINTS)

    def __post_init__(self) -> None:
        """Check the shapes.  Raises BadInputError."""
        if self.xyz.ndim != 2 or self.xyz.shape[1] != 3 or not np.isfinite(self.xyz).all():
            raise BadInputError(f"xyz: expected (n, 3) finite, got {self.xyz.shape}")


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """An observation in level coordinates (z up), common to all frames with poses.

    ``T_level_frame`` (4, 4); ``xyz`` (n, 3): points without outliers; ``eye`` (3,) or None;
    ``ends`` (m, 3): ends of the eye's rays, the object's own first; ``others`` (k, 3); ``ground``:
    its height below the object, or None.
    """

    frame: int
    time: float
    T_level_frame: Floats
    xyz: Floats
    eye: Floats | None
    ends: Floats
    others: Floats
    ground: float | None


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """The visible surface of an object in one or more frames, in level coordinates.

    ``xyz`` (n, 3): its points; ``eyes`` and ``ends`` (m, 3): rays, if the sensor is known;
    ``ground``: height of the ground below it, in metres, or None.
    """

    xyz: Floats
    eyes: Floats
    ends: Floats
    ground: float | None


def surface_of(views: Sequence[View], options: FitOptions) -> Surface:
    """Return the common surface of views."""
    eyes = [np.broadcast_to(v.eye, v.ends.shape) for v in views if v.eye is not None]
    ends = [v.ends for v in views if v.eye is not None]
    xyz, ground = views[0].xyz, views[0].ground
    if len(views) > 1:
        xyz = np.concatenate([view.xyz for view in views])
        ground = ground_height(xyz, np.concatenate([view.others for view in views]), options)
    rays = (np.concatenate(eyes), np.concatenate(ends)) if ends else (NO_POINTS, NO_POINTS)
    return Surface(xyz, *rays, ground)


def near_rays(
    xyz: Floats, others: NDArray[np.floating], sensor: Floats | None, up: Floats, reach: float
) -> Floats:
    """Return the ``others`` (m, 3) that constrain an object.

    They are around it, or their rays pass within ``reach`` metres in plan or end in front of it.
    """
    R = upright_axes(up)
    plan = np.asarray(others, np.float64) @ R[:2].T
    middle = np.median(xyz, axis=0) @ R[:2].T
    if sensor is None:
        return np.asarray(others[np.linalg.norm(plan - middle, axis=1) < reach], np.float64)
    eye = sensor @ R[:2].T
    along = plan - eye
    length = np.maximum((along**2).sum(axis=1), 1e-12)
    part = np.clip(along @ (middle - eye) / length, 0, 1)
    square = ((along * part[:, None] + eye - middle) ** 2).sum(axis=1)
    return np.asarray(others[square < reach * reach], np.float64)


def views_of(observations: Sequence[Observation], options: FitOptions) -> tuple[list[View], bool]:
    """Return views in common level coordinates, and whether all frames have poses.

    Unless all frames have poses, each frame has separate level coordinates.
    """
    posed = all(each.T_world_frame is not None for each in observations)
    ups = [each.up / np.linalg.norm(each.up) for each in observations]
    if posed:
        turned = [
            each.T_world_frame[:3, :3] @ up
            for each, up in zip(observations, ups, strict=True)
            if each.T_world_frame is not None
        ]
        common = upright_axes(np.mean(turned, axis=0))
    views = []
    for each, up in zip(observations, ups, strict=True):
        T = np.eye(4)
        if posed and each.T_world_frame is not None:
            T[:3, :3] = common
            T = T @ each.T_world_frame
        else:
            T[:3, :3] = upright_axes(up)
        view = _view(each, T, options)
        if len(view.xyz) >= options.least_points:
            views.append(view)
    return views, posed


def _view(each: Observation, T: Floats, options: FitOptions) -> View:
    def placed(points: Floats) -> Floats:
        return np.asarray(points @ T[:3, :3].T + T[:3, 3])

    eye = None if each.sensor is None else placed(each.sensor[None])[0]
    others = placed(each.others)
    xyz = without_strays(placed(each.xyz), eye, options)
    ground = ground_height(xyz, others, options)
    if eye is not None and ground is not None and eye[2] < ground + options.lowest_sensor:
        eye[2] = ground + options.roof  # the origin of a vehicle, on the ground
    ends = np.concatenate([xyz, others])
    step = -(-len(ends) // options.most_rays) if len(ends) else 1
    return View(each.frame, each.time, T, xyz, eye, ends[::step], others, ground)


def without_strays(xyz: Floats, eye: Floats | None, options: FitOptions) -> Floats:
    """Return the points without small separate components, painted beside the object."""
    if len(xyz) < 2 * options.least_points:
        return xyz
    distance = 0.0 if eye is None else float(np.linalg.norm(np.median(xyz, axis=0) - eye))
    gap = options.stray_gap + options.stray_gap_angle * distance
    cells, cell = np.unique(np.floor(xyz / (gap / 2)), axis=0, return_inverse=True)
    pairs = cKDTree(cells).query_pairs(2.0, output_type="ndarray")
    ones = np.ones(len(pairs))
    graph = coo_matrix((ones, (pairs[:, 0], pairs[:, 1])), shape=(len(cells), len(cells)))
    piece = connected_components(graph, directed=False)[1][cell.ravel()]
    counts = np.bincount(piece)
    return xyz[counts[piece] > options.stray_share * len(xyz)]
