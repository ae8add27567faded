"""Placed solids, and ray casting of them on a depth camera's pixel grid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pointbrush.frame import DepthCamera
from pointbrush.samples.geometry import Array, Field, along, inverse, norm3, rigid, vec, yaw
from pointbrush.samples.reproducible import matmul, norm
from pointbrush.samples.shapes import Ball, Box, Cylinder, RoundCone, Shape
from pointbrush.samples.textures import Material, noise

NEAREST = 0.05
"""Metres in front of the camera below which a solid's box is not projected."""


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A shape in the room: scaled, then moved by ``pose`` (``T_room_solid``)."""

    shape: Shape
    pose: Array
    material: Material
    scale: Array = field(default_factory=lambda: np.ones(3))
    label: int = 0
    roughness: float = 0.0
    """Amplitude of the folds that tilt the normals (clothes, foliage)."""


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Surfaces that the pixels of a cast see; pixels without a surface have ``owner`` -1."""

    depth: Field
    """(H*W,) metres along the camera's z, inf for none."""
    owner: NDArray[np.int16]
    """(H*W,) index of the solid."""

    def copy(self) -> Surface:
        """Return a copy to cast more solids into."""
        return Surface(self.depth.copy(), self.owner.copy())


@dataclass(frozen=True, slots=True, eq=False)
class Shaded:
    """Properties of some pixels' surfaces: component-major (3, N) in room coordinates."""

    pixel: NDArray[np.intp]
    point: Field
    normal: Field
    albedo: Field
    infrared: Field
    gloss: Field
    glow: Field
    label: NDArray[np.uint16]


class Caster:
    """The rays of one camera in one place."""

    def __init__(self, camera: DepthCamera, T_room_camera: Array, rays: Field) -> None:
        self.camera = camera
        self.T_room_camera = T_room_camera
        self.T_camera_room = inverse(T_room_camera)
        self.rays = rays
        R = T_room_camera[:3, :3].astype(np.float32)
        self.room_rays: Field = matmul(R, rays)
        self.eye: Field = T_room_camera[:3, 3].astype(np.float32)

    def empty(self) -> Surface:
        """Return a surface with nothing in view."""
        n = self.camera.width * self.camera.height
        return Surface(np.full(n, np.inf, np.float32), np.full(n, -1, np.int16))

    def cast(self, solids: Sequence[Solid], into: Surface, first: int = 0) -> None:
        """Put ``solids`` into the depth buffer; their owners count from ``first``."""
        shape = (self.camera.height, self.camera.width)
        depth, owner = into.depth.reshape(shape), into.owner.reshape(shape)
        rays = self.rays.reshape(3, *shape)
        for number, solid in enumerate(solids, first):
            T_camera_solid = matmul(self.T_camera_room, solid.pose)
            window = self._window(solid, T_camera_solid)
            if window is None:
                continue
            R = T_camera_solid[:3, :3]
            to_unit = R.T / solid.scale[:, None]
            o = matmul(-to_unit, T_camera_solid[:3, 3]).astype(np.float32)
            patch = np.ascontiguousarray(rays[:, window[0], window[1]]).reshape(3, -1)
            d = matmul(to_unit.astype(np.float32), patch)
            t = solid.shape.hit(o, d).reshape(depth[window].shape)
            nearer = (t < depth[window]) & (t > 0)  # not behind a camera beside the solid
            depth[window][nearer] = t[nearer]
            owner[window][nearer] = number

    def _window(self, solid: Solid, T_camera_solid: Array) -> tuple[slice, slice] | None:
        """Rows and columns of the screen that the solid's box may cover, None for none."""
        lo, hi = (bound * solid.scale for bound in solid.shape.bounds)
        corners = np.array(list(product(*zip(lo, hi, strict=True))))
        p = matmul(corners, T_camera_solid[:3, :3].T) + T_camera_solid[:3, 3]
        width, height = self.camera.width, self.camera.height
        if p[:, 2].max() < NEAREST:
            return None
        if p[:, 2].min() < NEAREST:
            return slice(0, height), slice(0, width)
        u = p[:, 0] / p[:, 2] * self.camera.fx + self.camera.cx
        v = p[:, 1] / p[:, 2] * self.camera.fy + self.camera.cy
        left, right = max(0, int(u.min())), min(width, int(u.max()) + 2)
        top, bottom = max(0, int(v.min())), min(height, int(v.max()) + 2)
        if left >= right or top >= bottom:
            return None
        return slice(top, bottom), slice(left, right)

    def points(self, pixel: NDArray[np.intp], depth: Field) -> Field:
        """(3, N) room coordinates of pixels at their depths."""
        return np.asarray(self.eye[:, None] + self.room_rays[:, pixel] * depth, np.float32)

    def shade(self, solids: Sequence[Solid], seen: Surface, first: int = 0) -> Shaded:
        """Surface properties of all pixels that ``solids`` own."""
        owned = np.flatnonzero((seen.owner >= first) & (seen.owner < first + len(solids)))
        pixel = owned[np.argsort(seen.owner[owned], kind="stable")]
        numbers = seen.owner[pixel]
        ends = np.searchsorted(numbers, np.arange(first, first + len(solids) + 1))
        point = self.points(pixel, seen.depth[pixel])
        scalars = np.empty((3, pixel.size), np.float32)
        result = Shaded(
            pixel=pixel,
            point=point,
            normal=np.empty_like(point),
            albedo=np.empty_like(point),
            infrared=scalars[0],
            gloss=scalars[1],
            glow=scalars[2],
            label=np.empty(pixel.size, np.uint16),
        )
        for solid, start, stop in zip(solids, ends[:-1], ends[1:], strict=True):
            if start < stop:
                _fill(result, solid, slice(int(start), int(stop)))
        return result


def _fill(out: Shaded, solid: Solid, part: slice) -> None:
    R = solid.pose[:3, :3].astype(np.float32)
    scale = solid.scale.astype(np.float32)[:, None]
    metric = matmul(R.T, out.point[:, part] - solid.pose[:3, 3].astype(np.float32)[:, None])
    n = np.asarray(solid.shape.normal(np.asarray(metric / scale, np.float32)) / scale, np.float32)
    if solid.roughness:
        n = np.asarray(n / norm3(n) + _folds(metric, solid.roughness), np.float32)
    n = matmul(R, n)
    out.normal[:, part] = n / np.maximum(norm3(n), 1e-6)
    material = solid.material
    out.albedo[:, part] = material.texture(metric)
    tone = out.albedo[:, part].mean(axis=0)
    out.infrared[part] = material.infrared * (0.75 + 0.5 * np.minimum(tone, 1))
    out.gloss[part] = material.gloss
    out.glow[part] = material.glow
    out.label[part] = solid.label


def _folds(p: Field, amplitude: float) -> Field:
    """(3, N) tilt of the normals by wrinkles some centimetres long."""
    q = p * np.array([[1], [0.6], [1]], np.float32)
    waves = [noise(q + np.float32(5.1 * k), 0.07, 2) - np.float32(0.5) for k in range(3)]
    return np.float32(amplitude) * np.stack(waves)


def block(
    lo: tuple[float, float, float],
    hi: tuple[float, float, float],
    material: Material,
    turn: float = 0.0,
    roughness: float = 0.0,
) -> Solid:
    """Box between two corners, turned round its own vertical by ``turn`` radians."""
    a, b = vec(*lo), vec(*hi)
    return Solid(Box(), rigid(yaw(turn), (a + b) / 2), material, (b - a) / 2, 0, roughness)


def disc(
    base: tuple[float, float, float], radius: float, height: float, material: Material
) -> Solid:
    """Upright cylinder standing on ``base``."""
    centre = vec(*base) + vec(0, height / 2, 0)
    return Solid(Cylinder(), rigid(np.eye(3), centre), material, vec(radius, height / 2, radius))


def rod(
    a: Array,
    b: Array,
    radii: tuple[float, float],
    material: Material,
    label: int = 0,
    flat: tuple[float, Array | None] = (1.0, None),
    roughness: float = 0.0,
) -> Solid:
    """Rounded cone from ``a`` to ``b``; ``flat``: depth across a direction to the right."""
    (ra, rb), (depth, right) = radii, flat
    length = norm(b - a)
    if length <= abs(ra - rb):
        length = abs(ra - rb) + 1e-3
    pose = along(a, b, vec(1, 0, 0) if right is None else right)
    return Solid(RoundCone(ra, rb, length), pose, material, vec(1, 1, depth), label, roughness)


def egg(
    centre: Array,
    radii: tuple[float, float, float],
    material: Material,
    label: int = 0,
    R: Array | None = None,
    roughness: float = 0.0,
) -> Solid:
    """Ellipsoid."""
    pose = rigid(np.eye(3) if R is None else R, centre)
    return Solid(Ball(), pose, material, vec(*radii), label, roughness)
