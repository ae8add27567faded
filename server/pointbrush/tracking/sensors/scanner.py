"""Range image and ground of a lidar.

Imports of depth camera frames load this module, so it does not import SciPy at the top level.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.options.sensors import GroundOptions, RangeImageOptions


@dataclass(frozen=True, slots=True, eq=False)
class RangeImage:
    """Range image around ``eye`` (3,).

    ``farthest``: range of each cell (m), inf if unmeasured, 0 outside the field of view; ``up``:
    axis of the azimuth; ``step``: degrees of elevation of a cell.
    """

    options: TrackerOptions
    eye: F64
    farthest: F32
    up: int
    step: float

    def hides(self, xyz: F64, by: float, own: I64 | None = None, size: float = np.inf) -> Mask:
        """Mark the points (M, 3) at least ``by`` metres behind measurements or out of view.

        In and beside the directions ``own``, measurements less than ``size`` metres nearer do not
        occlude points.
        """
        options = self.options.range_image
        cell, distance = _cells(xyz - self.eye, self.up, self.step, options.azimuth_deg)
        far = self.farthest[cell]
        hidden = far < distance - np.maximum(by, options.hidden_share * distance)
        if own is not None:
            there = np.zeros(len(self.farthest), np.bool_)
            width = _width(options.azimuth_deg)
            beside = np.add.outer((-width, 0, width), (-1, 0, 1)).ravel()
            there[np.clip(own[:, None] + beside, 0, len(there) - 1)] = True
            hidden &= ~there[cell] | (far < distance - size)
        return np.asarray(hidden)

    def towards(self, xyz: F64) -> I64:
        """Return the distinct directions of points (M, 3)."""
        return np.unique(
            _cells(xyz - self.eye, self.up, self.step, self.options.range_image.azimuth_deg)[0]
        )


def range_image_of(
    xyz: F32, eye: F64, options: TrackerOptions, most: float | None = None
) -> RangeImage | None:
    """Return the range image of a frame (N, 3) around ``eye``.

    None: it has too few points, or was not seen from there, as more than a share ``most`` lies far
    behind other points.
    """
    if len(xyz) < options.range_image.min_points:
        return None
    if most is None:
        most = options.range_image.swept_share
    local = xyz - eye
    up = axis_up(local, options=options.range_image)
    if (
        _behind(local, up, options=options.range_image) > most
        and _confused(local, up, options=options.range_image) > options.range_image.behind_share
    ):
        return None
    for step in options.range_image.elevations_deg:
        cell, distance = _cells(local, up, step, options.range_image.azimuth_deg)
        farthest = np.zeros(
            int(180 / step + 1) * _width(options.range_image.azimuth_deg), np.float32
        )
        np.maximum.at(farthest, cell, distance.astype(np.float32))
        image = farthest.reshape(-1, _width(options.range_image.azimuth_deg))
        row = np.quantile(
            cell // _width(options.range_image.azimuth_deg),
            [options.range_image.rim_share, 1 - options.range_image.rim_share],
        ).astype(int)
        part = image[row[0] : row[1] + 1, image.any(axis=0)] > 0
        if part.mean() > options.range_image.filled_share:
            break
    farthest = np.where(farthest > 0, farthest, _open(image, options=options.range_image)).astype(
        np.float32
    )
    return RangeImage(options, np.asarray(eye, np.float64), farthest, up, step)


def _open(image: F32, options: RangeImageOptions) -> F32:
    """Return flat ranges for empty cells of an ``image`` (R, width): inf inside it, 0 beyond."""
    from scipy.ndimage import maximum_filter1d

    columns = maximum_filter1d(image.any(axis=0), 2 * options.blind_cells + 1, mode="wrap")
    rows = np.flatnonzero(image.any(axis=1))
    seen = np.zeros(image.shape, np.float32)
    seen[rows[0] : rows[-1] + 1, columns] = np.inf
    return seen.ravel()


def find_eye(xyz: F32, options: TrackerOptions) -> F64 | None:
    """Return the sensor position of a frame (N, 3) without a viewpoint; None: unknown.

    The position is near the frame's origin, and each direction from it has a single surface.
    """
    if len(xyz) < options.range_image.min_points:
        return None
    up = axis_up(xyz, options=options.range_image)
    above = np.eye(3)[up]
    height, most = 0.0, options.range_image.swept_share
    if _behind(xyz, up, options=options.range_image) > options.range_image.swept_share:
        height, most = (
            min(
                options.range_image.sensor_heights_m,
                key=lambda h: _confused(xyz - h * above, up, options=options.range_image),
            ),
            options.range_image.behind_share,
        )
    local = xyz - height * above
    there = range_image_of(xyz, height * above, options, most) is not None and _deep(
        local, options=options.range_image
    )
    # Frames thinned to cells are accepted at a lidar's range; a figure is smaller.
    there = there and (
        reach_of(xyz, options=options.range_image) > options.range_image.camera_reach_m
        or _spreads(local, options=options.range_image)
    )
    return np.asarray(height * above) if there else None


def _deep(local: F32 | F64, options: RangeImageOptions) -> bool:
    """Return whether the depth range suffices to detect occlusions.

    The back of a small object is barely farther than its front.
    """
    distance = np.linalg.norm(local, axis=1)
    near, far = np.quantile(distance, [options.stray_share, 1 - options.stray_share])
    return bool(far > options.lidar_depth_ratio * near)


def _spreads(local: F32 | F64, options: RangeImageOptions) -> bool:
    """Return whether the spacing of points (N, 3) increases with the distance, as for a sensor.

    A figure centred on the origin also has one surface in each direction, but a uniform spacing.
    """
    distance = np.linalg.norm(local, axis=1)
    some = np.arange(0, len(local), -(-len(local) // options.min_points))
    from scipy.spatial import cKDTree

    apart = np.asarray(cKDTree(local).query(local[some], k=[options.spread_neighbours + 1])[0])[
        :, 0
    ]
    near, far = (
        distance[some] <= np.quantile(distance, 1 / 3),
        distance[some] >= np.quantile(distance, 2 / 3),
    )
    farther = np.median(distance[some][far]) / np.median(distance[some][near])
    wider = np.median(apart[far]) / max(float(np.median(apart[near])), 1e-9)
    return bool(wider > farther**options.spread_power)


def reach_of(xyz: F32 | F64, options: RangeImageOptions) -> float:
    """Return the distance (m), along each axis, within which most points (N, 3) lie."""
    if not len(xyz):
        return 0.0
    distance = np.abs(xyz - np.median(xyz, axis=0).astype(np.float64)).max(axis=1)
    return float(np.quantile(distance, options.camera_share))


def axis_up(local: F32 | F64, options: RangeImageOptions) -> int:
    """Return the vertical axis of a spinning sensor: the axis of the smallest extent."""
    return int(np.argmin(np.abs(local[:: max(1, len(local) // options.up_points)]).mean(axis=0)))


def _behind(local: F32 | F64, up: int, options: RangeImageOptions) -> float:
    """Return the share of the points (N, 3) far behind another point in their direction."""
    cell, distance = _cells(local, up, options.elevations_deg[0], options.azimuth_deg)
    nearest = np.full(
        int(180 / options.elevations_deg[0] + 1) * _width(options.azimuth_deg), np.inf, np.float32
    )
    np.minimum.at(nearest, cell, distance.astype(np.float32))
    return float((distance > options.behind_ratio * nearest[cell]).mean())


def _confused(local: F32 | F64, up: int, options: RangeImageOptions) -> float:
    """Return the share far behind another point, of points (N, 3) with others in their direction.

    It is large for frames of several sensors, or of a sensor at another position.
    """
    cell, distance = _cells(local, up, options.same_direction_deg, options.same_direction_deg)
    order = np.argsort(cell, kind="stable")
    start = np.flatnonzero(np.diff(cell[order], prepend=-1))
    count = np.diff(start, append=len(cell))
    nearest = np.repeat(np.minimum.reduceat(distance[order], start), count)
    behind = np.count_nonzero(distance[order] > options.behind_ratio * nearest)
    shared = int(count[count > 1].sum())
    return float(behind / max(shared, options.min_same_direction * len(local)))


def _width(azimuth: float) -> int:
    """Return the number of cells around that are ``azimuth`` degrees wide."""
    return int(360 / azimuth) + 1


def _cells(local: F32 | F64, up: int, step: float, azimuth: float) -> tuple[I64, F64]:
    """Return the flat cell and range of points (M, 3) around the sensor."""
    across, along = (a for a in range(3) if a != up)
    distance = np.sqrt(np.einsum("ij,ij->i", local, local)) + 1e-9
    around = np.degrees(np.arctan2(local[:, along], local[:, across])) + 180.0
    elevation = np.degrees(np.arcsin(np.clip(local[:, up] / distance, -1.0, 1.0))) + 90.0
    width = _width(azimuth)
    cell = (elevation / step).astype(np.int64) * width + (around / azimuth).astype(np.int64)
    return cell, np.asarray(distance, np.float64)


def on_ground(xyz: F32, options: TrackerOptions) -> Mask:
    """Mark the points (N, 3) of a frame on the ground."""
    none = np.zeros(len(xyz), np.bool_)
    if len(xyz) < options.ground.min_points:
        return none
    up = axis_up(xyz, options=options.range_image)
    scale = options.ground.length_share * float(np.median(np.linalg.norm(xyz, axis=1)))
    flat = np.delete(xyz, up, axis=1)
    cell = np.floor((flat - flat.min(axis=0)) / max(options.ground.cell * scale, 1e-6)).astype(
        np.int64
    )
    shape = cell.max(axis=0) + 1
    if float(np.prod(shape, dtype=np.float64)) > options.ground.max_cells:
        return none
    number = cell[:, 0] * shape[1] + cell[:, 1]
    height = xyz[:, up] * (1.0 if _stands(xyz[:, up], options=options.ground) else -1.0)
    lowest = np.full(int(np.prod(shape)), np.inf, np.float32)
    np.minimum.at(lowest, number, height)
    from scipy.ndimage import minimum_filter

    around = minimum_filter(lowest.reshape(shape), 3, mode="nearest").ravel()
    ground = np.where(lowest < around + options.ground.kerb * scale, lowest, around)
    return np.asarray(height < ground[number] + options.ground.thickness * scale)


def _stands(height: F32, options: GroundOptions) -> bool:
    """Return whether the axis points up: the densest measurements are below."""
    low, middle, high = np.quantile(height, [options.stray_share, 0.5, 1 - options.stray_share])
    return bool(middle - low < high - middle)
