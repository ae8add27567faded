"""Surface model of a track, and views of it for space carving."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter

from pointbrush.compiled import compiled
from pointbrush.tracking.compute.grid import bounds, middle, numbered
from pointbrush.tracking.compute.rigid import carried, inverse, transform
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.options.sensors import LensOptions
from pointbrush.tracking.options.tracks import SurfaceOptions
from pointbrush.tracking.sensors.camera import Lens, Pixels, pixel
from pointbrush.tracking.sensors.sights import any_of
from pointbrush.tracking.sensors.view import View


@dataclass(eq=False)
class Model:
    """Surface points in start-frame coordinates.

    ``xyz`` (M, 3); ``colour`` (M, 3), see ``View.colour``; ``seen`` (M, 3): unit vectors to the
    sensor when last seen, zeros if its position is unknown; ``hits`` and ``misses`` (M,): counts;
    ``spacing``: metres between neighbours.
    """

    options: SurfaceOptions
    xyz: F64
    colour: F32
    seen: F64
    spacing: float
    hits: F32
    misses: F32
    _radius: float | None = None

    @staticmethod
    def of(
        xyz: F64,
        colour: F32,
        eye: F64 | None,
        spacing: float,
        options: SurfaceOptions,
        most: int | None = None,
    ) -> Model:
        """Return a model of at most ``most`` of the points (M, 3).

        ``eye`` (1, 3) or (M, 3): position of the sensor that sees all or each of them.
        """
        n = len(xyz)
        model = Model(
            options,
            xyz,
            colour,
            _towards(xyz, eye),
            spacing,
            np.ones(n, np.float32),
            np.zeros(n, np.float32),
        )
        return model._thin(most or options.max_points)

    @property
    def centre(self) -> F64:
        """(3,) mean of the points."""
        return middle(self.xyz)

    @property
    def radius(self) -> float:
        """Metres from the centre that hold nearly all points."""
        if self._radius is None:
            offset = self.xyz - self.centre
            square = np.einsum("ij,ij->i", offset, offset)
            most = int(self.options.radius_share * (len(square) - 1))
            self._radius = float(np.sqrt(np.partition(square, most)[most]))
        return self._radius

    def facing(self, poses: F64, eye: F64 | None, which: I64 | slice = slice(None)) -> Mask:
        """Mark the points (K, M), or only ``which``, that face ``eye`` at ``poses`` (K, 4, 4).

        ``eye`` (3,): position of one sensor in the world.
        """
        xyz, seen = self.xyz[which], self.seen[which]
        if eye is None:
            return np.ones((len(poses), len(xyz)), np.bool_)
        return _facing(xyz, seen, poses, np.asarray(eye, np.float64), self.options.facing_cos)

    def gather(
        self, xyz: F64, colour: F32, gap: F64, nearest: I64, eye: F64 | None, sure: bool | Mask
    ) -> None:
        """Add assigned points (start-frame coordinates), ``gap`` from model point ``nearest``.

        Points that are not ``sure`` are added only beside well confirmed ones: a hand that holds
        the object moves with it, and must not gradually become part of it.
        """
        options = self.options
        sure = np.broadcast_to(sure, len(xyz))
        on = gap < options.hit_spacings * self.spacing
        self._hit(nearest[on], sure[on])
        self.misses[nearest[on]] = 0
        towards = _towards(xyz, eye)
        self.seen[nearest[on]] = towards[on]
        beside = sure | (self.hits[nearest] >= options.sure_hits)
        new = np.flatnonzero((gap >= options.new_spacings * self.spacing) & beside)
        if len(new) == 0:
            return
        self.xyz = np.vstack([self.xyz, xyz[new]])
        self.colour = np.vstack([self.colour, colour[new]])
        self.seen = np.vstack([self.seen, towards[new]])
        self.hits = np.append(
            self.hits, np.where(sure[new], options.sure_hits, 1.0).astype(np.float32)
        )
        self.misses = np.append(self.misses, np.zeros(len(new), np.float32))
        self._keep(self._distinct(options.max_points))

    def _hit(self, which: I64, sure: Mask) -> None:
        """Count hits of points; points only seen beside a hand never become certain."""
        options = self.options
        capped = self.hits < options.sure_hits
        capped[which[sure]] = False
        self.hits[which] += 1
        self.hits[capped & (self.hits >= options.sure_hits)] = options.sure_hits - 1

    def miss(self, which: Mask) -> I64:
        """Count points that the sensor saw through, and remove points seen through too often.

        Returns the new number of each point (M,), -1 for removed ones.
        """
        self.misses[which] += 1
        return self.drop(self.misses > np.minimum(self.hits, self.options.max_counted_hits) + 1)

    def drop(self, which: Mask) -> I64:
        """Remove points (M,) unless too few would remain; return new numbers as ``miss`` does."""
        if not which.any() or np.count_nonzero(~which) < self.options.min_points:
            return np.arange(len(which))
        self._keep(np.flatnonzero(~which))
        return np.where(which, -1, np.cumsum(~which) - 1)

    def _distinct(self, most: int) -> I64:
        """Return the best confirmed point of each cell of the model's spacing, at most ``most``."""
        options = self.options
        key = np.floor(self.xyz / (options.cell_spacings * self.spacing)).astype(np.int64)
        lo, hi = (end.astype(np.int64) for end in bounds(key))
        size = hi - lo + 1
        flat = ((key[:, 0] - lo[0]) * size[1] + key[:, 1] - lo[1]) * size[2] + key[:, 2] - lo[2]
        kept = _best_of(numbered(flat), self.hits)
        if len(kept) > most:
            self.spacing *= options.coarser_factor * float(np.sqrt(len(kept) / most))
            return self._distinct(most)
        return kept

    def _keep(self, which: I64) -> None:
        self.xyz, self.colour, self.seen = self.xyz[which], self.colour[which], self.seen[which]
        self.hits, self.misses = self.hits[which], self.misses[which]
        self._radius = None

    def _thin(self, most: int) -> Model:
        self._keep(self._distinct(most))
        return self


@compiled
def _best_of(cell: I64, hits: F32) -> I64:
    """Return sorted numbers of the point with the most hits of each cell; ties: the first."""
    best = np.full(cell.max() + 1, -1)
    for i in range(len(cell)):
        if best[cell[i]] < 0 or hits[i] > hits[best[cell[i]]]:
            best[cell[i]] = i
    return np.sort(best)


@compiled
def _facing(xyz: F64, seen: F64, poses: F64, eye: F64, facing_cos: float) -> Mask:
    faces = np.empty((len(poses), len(xyz)), np.bool_)
    for k in range(len(poses)):
        T, own = poses[k], np.zeros(3)
        for a in range(3):
            for c in range(3):
                own[a] += T[c, a] * (eye[c] - T[c, 3])
        for i in range(len(xyz)):
            towards, square = 0.0, 0.0
            for a in range(3):
                way = own[a] - xyz[i, a]
                towards += way * seen[i, a]
                square += way * way
            unknown = seen[i, 0] == 0.0 and seen[i, 1] == 0.0 and seen[i, 2] == 0.0
            faces[k, i] = unknown or towards > facing_cos * np.sqrt(square) + 1e-9
    return faces


def _towards(xyz: F64, eye: F64 | None) -> F64:
    if eye is None:
        return np.zeros_like(xyz)
    way = eye - xyz
    return np.asarray(way / (np.linalg.norm(way, axis=1, keepdims=True) + 1e-9))


@dataclass(frozen=True, slots=True, eq=False)
class Cutout:
    """Part of the depth image of a ``lens`` around an object.

    ``depth`` (H, W): minimum of each pixel and its neighbours, 0 if one of them is unmeasured;
    ``corner``: its first row and column in the depth image.
    """

    lens: Lens
    corner: tuple[int, int]
    depth: F32


@dataclass(frozen=True, slots=True, eq=False)
class CarvingView:
    """Depth images around an object in one frame, for space carving.

    ``pose`` (4, 4) of the object; ``T_world_lens`` (4, 4) or None; ``cutouts``: one of each camera
    that shows the object.
    """

    pose: F64
    T_world_lens: F64 | None
    cutouts: list[Cutout]

    def through(self, xyz: F64, beyond: float, options: LensOptions) -> Mask:
        """Return a mask of the points (M, 3), in object coordinates, that a camera saw through."""
        T = self.pose if self.T_world_lens is None else inverse(self.T_world_lens) @ self.pose
        return any_of(
            _through(c.lens.pixels, T, c.corner, c.depth, xyz, beyond, options.nearest_m)
            for c in self.cutouts
        )


@compiled
def _through(
    lens: Pixels,
    T: F64,
    corner: tuple[int, int],
    image: F32,
    xyz: F64,
    beyond: float,
    nearest_m: float,
) -> Mask:
    result = np.zeros(len(xyz), np.bool_)
    height, width = image.shape
    for i in range(len(xyz)):
        cell, depth = pixel(lens, carried(T, xyz[i, 0], xyz[i, 1], xyz[i, 2]), nearest_m)
        row, column = cell // lens.stride - corner[0], cell % lens.stride - corner[1]
        if cell >= 0 and 0 <= row < height and 0 <= column < width:
            result[i] = image[row, column] > depth + beyond
    return result


def carving_view(view: View, pose: F64, world: F64) -> CarvingView | None:
    """Cut ``view``'s depth images around an object whose surface is at ``world`` (M, 3)."""
    if view.lens is None:
        return None
    lenses = [sight.lens for sight in view.sights if sight.lens is not None]
    cells = [projection.cell for projection in view.project(world)]
    cutouts = [
        _cutout(view, lens, cell[cell >= 0])
        for lens, cell in zip(lenses, cells, strict=True)
        if (cell >= 0).any()
    ]
    return CarvingView(pose, view.T_world_lens, cutouts) if cutouts else None


def _cutout(view: View, lens: Lens, cell: I64 | NDArray[np.int32]) -> Cutout:
    options = view.options.surface
    height, width = view.image_shape
    row, column = np.divmod(cell, width)
    top, left = (
        max(int(row.min()) - options.carve_margin_px, 0),
        max(int(column.min()) - options.carve_margin_px, 0),
    )
    image = view.depth[:-1].reshape(height, width)
    part = image[
        top : int(row.max()) + options.carve_margin_px + 1,
        left : int(column.max()) + options.carve_margin_px + 1,
    ]
    part = np.nan_to_num(part, nan=0.0)
    least = minimum_filter(part, 3, mode="constant")
    return Cutout(lens, (top, left), least)


def remember(carving_views: list[CarvingView], view: View, pose: F64, world: F64) -> None:
    """Add a carving view if it shows the object from another side; drop the oldest if full."""
    # The object stays in front of the sensor, so its own rotation decides.
    options = view.options.surface
    turns = [
        float((earlier.pose[:3, :3] * pose[:3, :3]).sum() - 1.0) / 2.0 for earlier in carving_views
    ]
    if turns and max(turns) > np.cos(np.radians(options.carve_turn_deg)):
        return
    new = carving_view(view, pose, world)
    if new is not None:
        carving_views.append(new)
        del carving_views[: -options.carve_views]


def carved(
    carving_views: list[CarvingView], view: View, pose: F64, points: I64, unit: float
) -> Mask:
    """Mark the ``points`` (M,) in space that earlier views saw through, the object at ``pose``."""
    options = view.options
    votes = np.zeros(len(points), np.int64)
    if len(carving_views) >= options.surface.carve_min_views and len(points):
        own = transform(inverse(pose), view.xyz[points].astype(np.float64))
        for earlier in carving_views:
            votes += earlier.through(own, options.surface.carve_units * unit, options=options.lens)
    return np.asarray(votes >= options.surface.carve_min_views)
