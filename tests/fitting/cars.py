"""Points of a car, and of the ground round it, as a sensor sees them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.fitting import Observation

Floats = NDArray[np.float64]
UP = np.array([0.0, 0, 1])
SIZE = np.array([4.3, 1.8, 1.5])


def surface(sides: str, rng: np.random.Generator) -> Floats:
    """Points (n, 3) on sides of a car at the origin: l(eft), r(ight), f(ront), b(ack), t(op)."""
    places = []
    for side in sides:
        flat = rng.uniform(-0.5, 0.5, (600, 3))
        axis, sign = {"l": (1, 1), "r": (1, -1), "f": (0, 1), "b": (0, -1), "t": (2, 1)}[side]
        flat[:, axis] = 0.5 * sign
        places.append(flat * SIZE)
    return np.concatenate(places) + [0, 0, SIZE[2] / 2]


def ground(eye: Floats, rng: np.random.Generator) -> Floats:
    """Points of the ground round the car that a sensor at ``eye`` (3,) sees past it."""
    flat = rng.uniform(-7, 7, (4000, 3))
    flat[:, 2] = 0
    steps = np.linspace(0.5, 1, 60)[:, None, None]
    along = np.abs(eye + (flat - eye) * steps - [0, 0, SIZE[2] / 2])
    return np.asarray(flat[~(along < SIZE / 2).all(axis=2).any(axis=0)])


def placed(points: Floats, yaw: float, at: tuple[float, float]) -> Floats:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.asarray(points @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + [*at, 0])


def seen(sides: str, yaw: float, at: tuple[float, float], frame: int = 0) -> Observation:
    """A car at a place, seen by a sensor at the origin, 1.7 m above the ground."""
    rng = np.random.default_rng(frame)
    eye = np.array([0, 0, 1.7])
    turn = placed(np.eye(3), yaw, (0, 0))
    xyz = placed(surface(sides, rng), yaw, at) + rng.normal(0, 0.01, (600 * len(sides), 3))
    others = placed(ground((eye - [*at, 0]) @ turn.T, rng), yaw, at)
    return Observation(frame, xyz, UP, frame / 10, eye, np.eye(4), others)
