"""Placed solids in one call: blocks, discs, rods and eggs."""

from __future__ import annotations

import numpy as np

from pointbrush.samples.geometry import Array, along, rigid, vec, yaw
from pointbrush.samples.render import Solid
from pointbrush.samples.shapes import Ball, Box, Cylinder, RoundCone
from pointbrush.samples.textures import Material


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
    ra: float,
    rb: float,
    material: Material,
    label: int = 0,
    depth: float = 1.0,
    right: Array | None = None,
    roughness: float = 0.0,
) -> Solid:
    """Rounded cone from ``a`` to ``b``; ``depth`` flattens it across ``right``."""
    length = float(np.linalg.norm(b - a))
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
