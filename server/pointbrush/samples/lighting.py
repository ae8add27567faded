"""Light in the room: a window, a lamp, and reflections of the walls.

A few balls represent each moving object and cast its shadow.  The still room is lit once; each
frame then only darkens it near moving objects.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import zoom

from pointbrush.samples.geometry import Array, Field, dot3, norm3
from pointbrush.samples.render import Caster, Shaded, Solid, Surface
from pointbrush.samples.reproducible import cos, gaussian_blur, matmul, sin


@dataclass(frozen=True, slots=True, eq=False)
class Lamp:
    """A light of linear ``color`` at ``position``; ``reach``: the distance of half intensity."""

    position: Array
    color: tuple[float, float, float]
    reach: float
    size: float = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class Lights:
    """All light of a scene; ``sky`` and ``ground`` are the ambient colours from above and below."""

    lamps: tuple[Lamp, ...]
    sky: tuple[float, float, float] = (0.30, 0.31, 0.34)
    ground: tuple[float, float, float] = (0.17, 0.15, 0.13)


Ball = tuple[Array, float]
"""Centre in the room, and radius, of a ball that casts an object's shadow."""


def lamp_light(lamp: Lamp, s: Shaded, eye: Field) -> Field:
    """(3, N) light of one lamp off the surfaces, without shadows."""
    to_lamp = lamp.position.astype(np.float32)[:, None] - s.point
    distance = norm3(to_lamp)
    direction = to_lamp / distance
    lambert = np.clip((dot3(s.normal, direction) + 0.15) / 1.15, 0, 1)
    fall = 1 / (1 + (distance / lamp.reach) ** 2)
    view = eye[:, None] - s.point
    half = direction + view / norm3(view)
    half /= np.maximum(norm3(half), 1e-6)
    eighth = ((np.maximum(dot3(s.normal, half), 0) ** 2) ** 2) ** 2
    spark = s.gloss * eighth * (eighth**2) ** 2  # to the power of 40
    color = np.array(lamp.color, np.float32)[:, None]
    return np.asarray((s.albedo * lambert + spark * 0.6) * (fall * color), np.float32)


def ambient_light(lights: Lights, s: Shaded) -> Field:
    """(3, N) light from all round: sky above, floor below."""
    up = 0.5 + 0.5 * s.normal[1]
    sky, ground = (np.array(c, np.float32)[:, None] for c in (lights.sky, lights.ground))
    return np.asarray(s.albedo * (ground + (sky - ground) * up + s.glow), np.float32)


def ball_shade(
    points: Field, normals: Field, lamps: Sequence[Lamp], balls: Sequence[Ball]
) -> tuple[Field, list[Field]]:
    """Darken surfaces by moving things: ambient factor (N,), and a shadow factor per lamp."""
    ambient = np.ones(points.shape[1], np.float32)
    shadows = [np.ones(points.shape[1], np.float32) for _ in lamps]
    rays = []
    for lamp in lamps:
        to_lamp = lamp.position.astype(np.float32)[:, None] - points
        distance = norm3(to_lamp)
        rays.append((to_lamp / distance, distance))
    for centre, radius in balls:
        v = centre.astype(np.float32)[:, None] - points
        square = np.maximum(dot3(v, v), np.float32(radius * radius))
        near = np.maximum(dot3(v, normals), 0) / np.sqrt(square)
        ambient *= 1 - 0.8 * near * np.float32(radius * radius) / square
        for (direction, distance), shadow, lamp in zip(rays, shadows, lamps, strict=True):
            ahead = dot3(v, direction)
            aside = np.sqrt(np.maximum(square - ahead * ahead, 0))
            blur = np.maximum(radius * 0.25 + ahead / distance * lamp.size * 0.8, 1e-3)
            light = np.clip((aside - radius + blur) / (2 * blur), 0, 1)
            cover = np.minimum(1, (radius / blur) ** 2)
            behind = (ahead > 0) & (ahead < distance)
            shadow *= np.where(behind, 1 - cover * (1 - light * light * (3 - 2 * light)), 1)
    return ambient, shadows


class LitRoom:
    """The still part of a scene, cast and lit once.

    ``colors``: (L + 1, 3, H*W) linear light, the ambient part first, then one per lamp.
    """

    COARSE = 3

    def __init__(self, caster: Caster, solids: Sequence[Solid], lights: Lights) -> None:
        self.caster, self.solids, self.lights = caster, tuple(solids), lights
        self.surface: Surface = caster.empty()
        caster.cast(self.solids, self.surface)
        s = caster.shade(self.solids, self.surface)
        width, height = caster.camera.width, caster.camera.height
        count = width * height
        self.colors: Field = np.zeros((len(lights.lamps) + 1, 3, count), np.float32)
        openness = np.ones(count, np.float32)
        for reach in (0.35, 0.1):
            grid = np.ones(count, np.float32)
            grid[s.pixel] = crevices(self.surface.depth, s.pixel, width, height, reach)
            openness *= gaussian_blur(grid.reshape(height, width), 1.5).ravel()
        self.colors[0][:, s.pixel] = ambient_light(lights, s) * openness[s.pixel]
        self.infrared: Field = np.zeros(count, np.float32)
        self.infrared[s.pixel] = s.infrared
        self.normal: Field = np.zeros((3, count), np.float32)
        self.normal[:, s.pixel] = s.normal
        self.label = np.zeros(count, np.uint16)
        self.label[s.pixel] = s.label
        self._light_lamps(s, openness)
        self._coarse_grid()

    def _light_lamps(self, s: Shaded, openness: Field) -> None:
        width, height = self.caster.camera.width, self.caster.camera.height
        coarse = np.arange(width * height).reshape(height, width)[::2, ::2]
        pixel = coarse.ravel()
        points = self.caster.points(pixel, np.minimum(self.surface.depth[pixel], 20))
        blockers = [solid for solid in self.solids if solid.material.glow == 0]
        for number, lamp in enumerate(self.lights.lamps, 1):
            share = still_shadow(blockers, lamp, points).reshape(coarse.shape)
            share = zoom(gaussian_blur(share, 0.8), 2, order=1, grid_mode=True, mode="nearest")
            light = lamp_light(lamp, s, self.caster.eye)
            dim = 0.5 + 0.5 * openness[s.pixel]
            self.colors[number][:, s.pixel] = light * (share.ravel()[s.pixel] * dim)

    def _coarse_grid(self) -> None:
        width, height = self.caster.camera.width, self.caster.camera.height
        step = self.COARSE
        rows, columns = np.mgrid[0:height:step, 0:width:step]
        pixel = (rows * width + columns).ravel()
        self._coarse_shape = rows.shape
        self._coarse_points = self.caster.points(pixel, np.minimum(self.surface.depth[pixel], 20))
        self._coarse_normals = self.normal[:, pixel]

    def lit(self, balls: Sequence[Ball]) -> Field:
        """(3, H*W) linear colours of the room with the shade of ``balls`` on it."""
        ambient, shadows = ball_shade(
            self._coarse_points, self._coarse_normals, self.lights.lamps, balls
        )
        result = self.colors[0] * self._spread(ambient)
        for color, shadow in zip(self.colors[1:], shadows, strict=True):
            result += color * self._spread(shadow)
        return np.asarray(result, np.float32)

    def _spread(self, coarse: Field) -> Field:
        width, height = self.caster.camera.width, self.caster.camera.height
        grid = coarse.reshape(self._coarse_shape)
        wide = zoom(grid, self.COARSE, order=1, grid_mode=True, mode="nearest")
        return np.asarray(wide[:height, :width].ravel(), np.float32)


def light_moving(room: LitRoom, s: Shaded, depth: Field, balls: Sequence[Ball]) -> Field:
    """(3, N) linear colours of moving surfaces ``s``; ``depth`` is the finished depth buffer."""
    camera = room.caster.camera
    openness = crevices(depth, s.pixel, camera.width, camera.height, 0.15)
    result = ambient_light(room.lights, s) * openness
    shadows = ball_shade(s.point, s.normal, room.lights.lamps, balls)[1]
    for lamp, shadow in zip(room.lights.lamps, shadows, strict=True):
        result += lamp_light(lamp, s, room.caster.eye) * (shadow * (0.4 + 0.6 * openness))
    return result


def crevices(depth: Field, pixel: NDArray[np.intp], width: int, height: int, reach: float) -> Field:
    """(N,) 0..1 openness of pixels, from how many neighbours stand up to ``reach`` in front."""
    rows, columns = pixel // width, pixel % width
    own_depth = depth[pixel]
    radius = np.clip(reach * 365.0 / np.maximum(own_depth, 0.3) * 0.6, 2, 40)
    closed = np.zeros(pixel.size, np.float32)
    for number in range(10):
        angle, part = number * 2.4, math.sqrt((number + 0.5) / 10)
        r = np.clip(rows + sin(angle) * part * radius, 0, height - 1).astype(np.intp)
        c = np.clip(columns + cos(angle) * part * radius, 0, width - 1).astype(np.intp)
        step = (own_depth - depth[r * width + c]) / np.float32(reach)
        closed += np.where(step < 1.5, np.clip((step - 0.06) * 2, 0, 1), 0)
    return np.asarray(1 - 0.62 * np.minimum(closed / 7, 1), np.float32)


def still_shadow(solids: Sequence[Solid], lamp: Lamp, points: Field) -> Field:
    """(N,) share of the lamp seen from ``points`` (3, N), past the solids of the room."""
    rng = np.random.default_rng(5)
    share = np.zeros(points.shape[1], np.float32)
    samples = 4
    for _ in range(samples):
        target = lamp.position + rng.uniform(-lamp.size, lamp.size, 3)
        open_ = np.ones(points.shape[1], bool)
        for solid in solids:
            open_ &= ~_blocked(solid, points, target)
        share += open_
    return np.asarray(share / samples, np.float32)


def _blocked(solid: Solid, points: Field, target: Array) -> NDArray[np.bool_]:
    """Return whether the solid lies between the points and the target; rays start at the target."""
    inverse = (solid.pose[:3, :3].T / solid.scale[:, None]).astype(np.float32)
    o = matmul(inverse, (target - solid.pose[:3, 3]).astype(np.float32))
    d = matmul(inverse, points - target.astype(np.float32)[:, None])
    return np.asarray(solid.shape.hit(o, d) < 0.985)
