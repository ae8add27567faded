"""Light in the room: a window, a lamp, and what the walls give back.

Whatever moves throws its shadow by a few balls that stand for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pointbrush.samples.geometry import Array, Field, dot3, norm3
from pointbrush.samples.render import Shaded


@dataclass(frozen=True, slots=True, eq=False)
class Lamp:
    """A light of linear ``color`` at ``position``; ``reach`` is where it has fallen to a half."""

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
"""Centre in the room and radius: a stand-in for something that throws a shadow."""


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
    spark = s.gloss * np.maximum(dot3(s.normal, half), 0) ** 40
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
