"""Four things on a table, which a hand pushes or lifts one after the other."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from scenes.figures import SKIN, room
from scenes.raycaster import Camera, Frame, Part, Sensor

THINGS = 4
TURN = 24
"""Frames for which the hand is at one of them; it holds it from HELD[0] to HELD[1] of these."""
HELD = (0.2, 0.85)
TOP = 0.74
"""Height of the table, metres."""
SLEEVE = (60, 70, 120)


def tabletop(seed=0, frames=60, sensor=None) -> list[Frame]:
    """Things 1 to 4: boxes, discs and beakers; the first has nearly the table's colour."""
    rng = np.random.default_rng(seed)
    flat, wood = np.eye(3), (150, 110, 70)
    table = Part(0, wood, np.array([0, 0.72, 1.5]), np.array([0.8, 0.02, 0.4]), rot=flat)
    sensor = sensor or Sensor()
    sensor.look = Rotation.from_euler("x", 25, degrees=True).as_matrix()
    camera = Camera(sensor, [*room(), table])
    places, colours, angles = [], [], []
    for k in range(THINGS):
        places.append(np.array([-0.42 + 0.28 * k, 0.0, 1.45 + rng.uniform(-0.12, 0.12)]))
        colours.append(tuple(rng.integers(30, 230, 3)) if k else (150, 112, 72))
        angles.append(rng.uniform(0, 3))
    heights = [0.0] * THINGS
    turns = rng.permutation(THINGS)
    out = []
    for i in range(frames):
        k, phase = int(turns[(i // TURN) % THINGS]), (i % TURN) / TURN
        lifted = k % 2 == 1
        held = HELD[0] < phase < HELD[1]
        if held:
            inward = np.array([1 if places[k][0] < 0 else -1, 0, 0.3 * np.sin(k)]) * 0.006
            places[k] = places[k] + inward * (1.0 if lifted else 0.4)
            angles[k] += 0.02
        arc = np.sin((phase - HELD[0]) / (HELD[1] - HELD[0]) * np.pi)
        heights[k] = 0.14 * arc if held and lifted else 0.0
        bases = [p + np.array([0, TOP + h, 0]) for p, h in zip(places, heights, strict=True)]
        parts = [_thing(j + 1, j % 3, bases[j], angles[j], colours[j]) for j in range(THINGS)]
        away = 1 - np.clip(min(phase, 1 - phase) * 6, 0, 1)
        if held or away < 1:
            parts += _hand(
                places[k] + np.array([0.05, TOP + heights[k] + 0.12 + away * 0.25, 0.06])
            )
        out.append(camera.shoot(parts, rng))
    return out


def _thing(label: int, shape: int, base: np.ndarray, angle: float, colour) -> Part:
    if shape == 0:
        turned = Rotation.from_euler("y", angle).as_matrix()
        half = np.array([0.07, 0.06, 0.05])
        return Part(label, colour, base + [0, 0.06, 0], half, rot=turned, stripe=1.0)
    if shape == 1:
        return Part(label, colour, base + [0, 0.06, 0], base + [0, 0.061, 0], 0.06, 0.06)
    low, high = base + [0, 0.04, 0], base + [0, 0.14, 0]
    return Part(label, colour, low, high, 0.04, 0.035, stripe=3)


def _hand(tip: np.ndarray) -> list[Part]:
    wrist, elbow = tip + [0.04, 0.05, 0.08], tip + [0.25, 0.35, 0.4]
    return [Part(0, SKIN, tip, wrist, 0.035, 0.04), Part(0, SLEEVE, wrist, elbow, 0.045, 0.06)]
