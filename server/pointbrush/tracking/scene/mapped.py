"""Scene of a carried camera: a map of surface elements, rendered into each frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label as components_of

from pointbrush.compiled import compiled
from pointbrush.tracking.compute.grid import close_to, least_around, widened
from pointbrush.tracking.compute.rigid import transform
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.scene.images import DepthNoise, drawn_on
from pointbrush.tracking.scene.pixels import least
from pointbrush.tracking.scene.scans import PointBackground
from pointbrush.tracking.sensors.camera import Pixels
from pointbrush.tracking.sensors.view import View


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceMap:
    """Surface elements ``at`` (M, 3) in the world, with ``normal`` (M, 3) of any length."""

    at: F64
    normal: F64

    @staticmethod
    def of(view: View, depth: F32) -> SurfaceMap:
        """Return the surface elements of a depth image (cells + 1,) of a frame's sensor."""
        at, normal = _pieces(
            depth,
            np.flatnonzero(np.isfinite(depth)),
            view.camera.pixels,
            view.options.mapping.outline_share,
        )
        T = view.T_picture_world
        return SurfaceMap(transform(np.linalg.inv(T), at), normal @ T[:3, :3])

    def drawn(self, view: View) -> F32:
        """Return (cells + 1,) the scene's depth from a frame's sensor, NaN where unknown."""
        options = view.options.mapping
        image = _drawn(
            view.T_picture_world,
            self.at,
            self.normal,
            view.camera.pixels,
            options.closest_m,
            options.steep_share,
        )
        height, width = view.camera.shape
        _fill(image, height, width, options.filled_beside)
        return image

    def pick(self, keep: Mask) -> SurfaceMap:
        """Return the elements in ``keep``."""
        return SurfaceMap(self.at[keep], self.normal[keep])

    def __add__(self, other: SurfaceMap) -> SurfaceMap:
        """Return the elements of both maps."""
        return SurfaceMap(np.vstack([self.at, other.at]), np.vstack([self.normal, other.normal]))


@compiled
def _pieces(depth: F32, cells: I64, lens: Pixels, outline_share: float) -> tuple[F64, F64]:
    """Return positions and normals (right, down, forward) of the surface in some cells."""
    at, normal = np.empty((len(cells), 3)), np.empty((len(cells), 3))
    steps = (1, lens.width)
    for i in range(len(cells)):
        cell = cells[i]
        row, column = cell // lens.width, cell % lens.width
        z = float(depth[cell])
        x = lens.least[0] + lens.pitch[0] * column
        y = lens.least[1] + lens.pitch[1] * row
        slope = [0.0, 0.0]
        for axis in range(2):
            ends = (column, lens.width) if axis == 0 else (row, lens.height)
            if ends[0] == 0 or ends[0] == ends[1] - 1:
                continue
            before, after = float(depth[cell - steps[axis]]), float(depth[cell + steps[axis]])
            if abs(before - z) < outline_share * z and abs(after - z) < outline_share * z:
                slope[axis] = (1 / after - 1 / before) / (2 * lens.pitch[axis])
        at[i, 0], at[i, 1], at[i, 2] = x * z, y * z, z
        normal[i, 0], normal[i, 1] = slope[0], slope[1]
        normal[i, 2] = 1 / z - slope[0] * x - slope[1] * y
    return at, normal


@compiled
def _drawn(T: F64, at: F64, normal: F64, lens: Pixels, closest_m: float, steep_share: float) -> F32:
    """Return (cells + 1,) the depth of the nearest element at the middle of each cell."""
    image = np.full(lens.width * lens.height + 1, np.nan, np.float32)
    for i in range(len(at)):
        a, n = at[i], normal[i]
        z = T[2, 0] * a[0] + T[2, 1] * a[1] + T[2, 2] * a[2] + T[2, 3]
        if not z > closest_m:
            continue
        x = T[0, 0] * a[0] + T[0, 1] * a[1] + T[0, 2] * a[2] + T[0, 3]
        y = T[1, 0] * a[0] + T[1, 1] * a[1] + T[1, 2] * a[2] + T[1, 3]
        u = (x / z - lens.least[0]) / lens.pitch[0] + 0.5
        v = (y / z - lens.least[1]) / lens.pitch[1] + 0.5
        if not (u >= 0 and u < lens.width and v >= 0 and v < lens.height):
            continue
        p = T[0, 0] * n[0] + T[0, 1] * n[1] + T[0, 2] * n[2]
        q = T[1, 0] * n[0] + T[1, 1] * n[1] + T[1, 2] * n[2]
        r = T[2, 0] * n[0] + T[2, 1] * n[1] + T[2, 2] * n[2]
        across = p * (lens.least[0] + lens.pitch[0] * int(u))
        down = q * (lens.least[1] + lens.pitch[1] * int(v))
        middle = (p * x + q * y + r * z) / (across + down + r)
        if abs(middle - z) < steep_share * z:
            z = middle
        cell = int(v) * lens.width + int(u)
        if not image[cell] <= z:
            image[cell] = z
    return image


@compiled
def _fill(image: F32, height: int, width: int, filled_beside: int) -> None:
    """Close holes between elements with gaps larger than a pixel."""
    before = image.copy()
    for row in range(1, height - 1):
        for column in range(1, width - 1):
            cell = row * width + column
            if not np.isnan(before[cell]):
                continue
            count, total = 0, 0.0
            for down in (-width, 0, width):
                for along in (-1, 0, 1):
                    depth = before[cell + down + along]
                    if not np.isnan(depth):
                        count += 1
                        total += 1 / depth
            if count >= filled_beside:
                image[cell] = count / total


def chart_of(views: Sequence[View], noise: DepthNoise, options: TrackerOptions) -> SurfaceMap:
    """Return the map of the scene in some frames with depth images; the first has labels."""
    chart = SurfaceMap(np.empty((0, 3)), np.empty((0, 3)))
    around = [_around(view) for view in views]
    for view in views:
        depth = view.depth.copy()
        for points in view.labels.values():
            depth[view.cells.cell[points]] = np.nan
        depth[np.abs(depth - chart.drawn(view)) < options.background.near_sigmas * noise(depth)] = (
            np.nan
        )
        new = SurfaceMap.of(view, depth)
        flags = [_visibility_flags(v, a, new.at, noise) for v, a in zip(views, around, strict=True)]
        inside, shown, through = np.sum(flags, axis=0)
        enough = np.maximum(
            min(options.mapping.min_views, len(views)), options.mapping.shown_share * inside
        )
        keep = (shown >= enough) & (through <= options.mapping.seen_through_share * shown)
        keep &= ~_about(new.at, views[0], noise)
        chart += new.pick(keep)
    return chart


class _Around(NamedTuple):
    """The ``least`` and ``most`` depth (cells + 1,) around each cell, NaN if there is none."""

    least: F32
    most: F32


def _around(view: View) -> _Around:
    least, most = _least(view, view.depth), -_least(view, -view.depth)
    return _Around(np.where(np.isinf(least), np.nan, least), np.where(np.isinf(most), np.nan, most))


def _least(view: View, image: F32) -> F32:
    """Return the minimum of each cell and its neighbours, inf if there is none."""
    result = np.full_like(image, np.inf)
    filled = np.where(np.isnan(image[:-1]), np.float32(np.inf), image[:-1])
    result[:-1] = least_around(filled.reshape(view.camera.shape)).ravel()
    return result


def _visibility_flags(view: View, seen: _Around, at: F64, noise: DepthNoise) -> NDArray[np.int64]:
    """Return (3, M) flags of places (M, 3): inside the picture, on a surface, seen through."""
    cell, depth = view.project(at)[0]
    limit = view.options.background.near_sigmas * noise(depth)
    through = seen.least[cell] > depth + limit
    shown = ~through & (seen.most[cell] > depth - limit)
    return np.stack([cell >= 0, shown, through]).astype(np.int64)


def _about(at: F64, first: View, noise: DepthNoise) -> Mask:
    """Mark the positions (M, 3) that may be of the objects labelled in the first frame.

    A position may lie at an object or close behind it, hidden behind it within a limit, or beside
    it, unless that frame shows another surface there.
    """
    options = first.options
    if not first.labels:
        return np.zeros(len(at), np.bool_)
    cell, depth = first.project(at)[0]
    lengths = {n: float(np.ptp(first.xyz[own], axis=0).max()) for n, own in first.labels.items()}
    labelled, there = np.zeros(len(first.depth), np.bool_), np.zeros(len(at), np.bool_)
    for label, own in first.labels.items():
        inside, back = _extent(first, own)
        labelled |= inside
        there |= inside[cell] & (
            depth < back[cell] + options.background.side_share * lengths[label]
        )
    longest = max(lengths.values())
    some = np.flatnonzero(first.labelled())
    some = some[:: max(1, len(some) // options.mapping.sampled_points)]
    objects = first.xyz[some].astype(np.float64)
    hidden = (
        labelled[cell]
        & (depth > first.depth[cell])
        & close_to(at, objects, options.mapping.body_share * longest)
    )
    others = ~labelled[cell] & (
        np.abs(first.depth[cell] - depth) < options.background.near_sigmas * noise(depth)
    )
    return np.asarray(
        there | hidden | (close_to(at, objects, options.background.side_share * longest) & ~others)
    )


def _extent(view: View, points: I64) -> tuple[Mask, F32]:
    """Return a mask (cells + 1,) of points with a rim, and the maximum depth around each cell."""
    front = np.full(len(view.depth), np.nan, np.float32)
    front[view.cells.cell[points]] = view.cells.depth[points]
    rim = widened(np.isfinite(front[:-1]).reshape(view.camera.shape), view.options.mapping.rim_px)
    return np.append(rim, False), -_least(view, -front)


class MapBackground(PointBackground):
    """Background from the map of the whole run; elsewhere from earlier frames."""

    def __init__(
        self,
        options: TrackerOptions,
        reach: Callable[[F32], F32],
        waver: DepthNoise,
        chart: SurfaceMap,
    ) -> None:
        """``reach``: see ``PointBackground``."""
        super().__init__(options, reach)
        self.noise, self._chart = waver, chart
        self._drawn: tuple[int, F32, F32] | None = None

    def _scene(self, view: View) -> tuple[F32, F32]:
        """Return the scene's depth, and the depth below which a point is certainly in front of it.

        Behind a person who never leaves, the scene is continued from its surroundings.
        """
        options = self.options.background
        if self._drawn is None or self._drawn[0] != view.number:
            depth, shape = self._chart.drawn(view), view.camera.shape
            limit = least(depth, shape, self.noise)
            limit -= options.near_sigmas * self.noise(limit)
            hole = _holes(np.isnan(depth[:-1]).reshape(shape)).ravel()
            if hole.any():
                beyond = drawn_on(depth[:-1], shape, np.zeros_like(hole), options=options)
                limit[:-1][hole] = options.same_depth_share * beyond[hole]
            self._drawn = view.number, depth, limit
        return self._drawn[1], self._drawn[2]

    def static(self, view: View, indices: I64) -> tuple[Mask, Mask]:
        """See ``Background``."""
        cell, depth = view.cells.pick(indices)
        scene = self._scene(view)[0][cell]
        far = depth - scene > -self.options.background.near_sigmas * self.noise(depth)
        rest = np.flatnonzero(~far & ~self.certain(view, indices))
        there = np.zeros(len(indices), np.bool_)
        there[rest] = super().static(view, indices[rest])[0]
        known = np.isfinite(scene)
        return far | (there & ~known), there & known

    def scenery(self, view: View, indices: I64, _frames: int) -> Mask:
        """See ``Background``; surface that was static for some ``frames`` is in the map."""
        known = np.isfinite(self._scene(view)[0][view.cells.cell[indices]])
        return known & ~self.certain(view, indices)

    def furniture(self, view: View, indices: I64) -> Mask:
        """See ``PictureBackground``.

        New surface outside the map is included, except beside labelled points.
        """
        stands = self.static(view, indices)[0]
        new = np.flatnonzero(~stands & ~self.certain(view, indices))
        before, labelled = self.past[-1]
        stands[new] = ~close_to(
            view.xyz[indices[new]], before.xyz[labelled], self.options.mapping.beside_m
        )
        return stands

    def left_behind(self, label: int, frames: int, way: float) -> None:
        """See ``PictureBackground``; surface that was static in most frames is in the map."""

    def certain(self, view: View, indices: I64) -> Mask:
        """See ``Background``."""
        cell, depth = view.cells.pick(indices)
        return np.asarray(depth < self._scene(view)[1][cell])


def _holes(unknown: Mask) -> Mask:
    """Return a mask (H, W) of unknown regions enclosed by the known scene."""
    part, _ = components_of(unknown)
    rim = np.concatenate([part[0], part[-1], part[:, 0], part[:, -1]])
    return np.asarray(unknown & ~np.isin(part, rim))
