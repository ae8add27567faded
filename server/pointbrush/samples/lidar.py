"""A spinning lidar: rings of rays round the sensor, one turn of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.samples.geometry import Array, Field, norm3
from pointbrush.samples.render import Solid


@dataclass(frozen=True, slots=True)
class Spinner:
    """``rings`` rays between ``lowest`` and ``highest`` (degrees), ``steps`` a turn.

    ``noise`` standard deviation of the range, ``farthest`` return: metres; ``lost`` share of rays
    that give none.
    """

    rings: int = 64
    lowest: float = -24.8
    highest: float = 2.0
    steps: int = 1800
    noise: float = 0.02
    farthest: float = 100.0
    lost: float = 0.04


@dataclass(frozen=True, slots=True, eq=False)
class Turn:
    """``xyz`` (N, 3) metres in the solids' coordinates, ``intensity`` (N,) 0..1, ``label`` (N,)."""

    xyz: Array
    intensity: NDArray[np.float32]
    label: NDArray[np.uint16]


def spin(spinner: Spinner, eye: Array, solids: Sequence[Solid], rng: np.random.Generator) -> Turn:
    """Return what one turn at ``eye`` (3,) meets; solids of roughness 1 and more are foliage,
    which rays enter or pass."""
    up = np.radians(np.linspace(spinner.lowest, spinner.highest, spinner.rings))
    up = up + rng.normal(0, 0.0004, spinner.rings)
    round_ = np.arange(spinner.steps) * (2 * math.pi / spinner.steps)
    azimuth, elevation = np.meshgrid(round_, up)
    level = np.cos(elevation)
    # x right, y up, z toward the viewer: azimuth from x to -z.
    rays = np.stack([level * np.cos(azimuth), np.sin(elevation), -level * np.sin(azimuth)])
    rays = rays.reshape(3, -1).astype(np.float32)
    depth = np.full(rays.shape[1], np.inf, np.float32)
    owner = np.full(rays.shape[1], -1, np.int32)
    for number, solid in enumerate(solids):
        aimed = _aimed(spinner, solid, eye)
        if len(aimed):
            t = _meet(solid, eye, rays[:, aimed], rng)
            nearer = t < depth[aimed]
            depth[aimed[nearer]], owner[aimed[nearer]] = t[nearer], number
    kept = (owner >= 0) & (depth < spinner.farthest) & (rng.random(depth.size) > spinner.lost)
    return _returns(spinner, eye, solids, rays[:, kept], depth[kept], owner[kept], rng)


def _aimed(spinner: Spinner, solid: Solid, eye: Array) -> NDArray[np.intp]:
    """Numbers of the rays that may meet a solid: those toward the ball round its box."""
    lo, hi = (bound * solid.scale for bound in solid.shape.bounds)
    middle = solid.pose[:3, :3] @ ((lo + hi) / 2) + solid.pose[:3, 3] - eye
    radius = float(np.linalg.norm(hi - lo)) / 2
    away = float(np.linalg.norm(middle))
    if away <= radius * 1.05:
        return np.arange(spinner.rings * spinner.steps)
    half = math.asin(radius / away)
    elevation = math.asin(float(middle[1]) / away)
    span = math.radians(spinner.highest - spinner.lowest) / (spinner.rings - 1)
    first = math.floor((elevation - half - math.radians(spinner.lowest)) / span)
    last = math.ceil((elevation + half - math.radians(spinner.lowest)) / span)
    rings = np.arange(max(first, 0), min(last + 1, spinner.rings))
    ratio = math.sin(half) / max(math.cos(elevation), 1e-6)
    wide = math.asin(ratio) if ratio < 1 else math.pi
    step = 2 * math.pi / spinner.steps
    toward = math.atan2(-float(middle[2]), float(middle[0]))
    reach = min(math.ceil(wide / step) + 1, spinner.steps // 2)
    columns = np.unique((round(toward / step) + np.arange(-reach, reach + 1)) % spinner.steps)
    return np.asarray((rings[:, None] * spinner.steps + columns).ravel(), np.intp)


def _meet(solid: Solid, eye: Array, rays: Field, rng: np.random.Generator) -> Field:
    inverse = solid.pose[:3, :3].T / solid.scale[:, None]
    o = (inverse @ (eye - solid.pose[:3, 3])).astype(np.float32)
    t = solid.shape.hit(o, inverse.astype(np.float32) @ rays)
    if solid.roughness >= 1:
        deeper = rng.exponential(0.35, t.size).astype(np.float32)
        t = np.where(rng.random(t.size) < 0.35, np.float32(np.inf), t + deeper)
    return np.asarray(t, np.float32)


def _returns(
    spinner: Spinner,
    eye: Array,
    solids: Sequence[Solid],
    rays: Field,
    depth: Field,
    owner: NDArray[np.int32],
    rng: np.random.Generator,
) -> Turn:
    exact = eye[:, None] + rays * depth
    strength = np.empty(depth.size, np.float32)
    labels = np.array([solid.label for solid in solids], np.uint16)
    for number in np.unique(owner):
        on = np.flatnonzero(owner == number)
        solid = solids[int(number)]
        metric = solid.pose[:3, :3].T @ (exact[:, on] - solid.pose[:3, 3][:, None])
        scale = solid.scale[:, None]
        n = np.asarray(solid.shape.normal(np.asarray(metric / scale, np.float32)) / scale)
        n = solid.pose[:3, :3] @ n / np.maximum(norm3(np.asarray(n, np.float32)), 1e-9)
        facing = np.abs((n * rays[:, on]).sum(axis=0))
        tone = solid.material.texture(np.asarray(metric, np.float32)).mean(axis=0)
        strength[on] = tone * (0.3 + 0.7 * facing)
    strength *= rng.uniform(0.85, 1.15, depth.size).astype(np.float32)
    measured = depth + rng.normal(0, spinner.noise, depth.size)
    xyz = (eye[:, None] + rays * measured).T
    return Turn(xyz, np.clip(strength, 0, 1), labels[owner])
