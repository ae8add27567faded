"""Looks of people, and postures of their bodies at a moment.

A body's own axes are x to its left, y up, z forward; a person with yaw 0 faces the camera.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial

from pointbrush.samples.geometry import Array, vec, yaw
from pointbrush.samples.reproducible import matmul
from pointbrush.samples.textures import Material, checked, cloth, linear, striped


@dataclass(frozen=True, slots=True)
class Look:
    """Looks of a person; colours are "#rrggbb"."""

    shirt: str
    second: str | None = None
    pattern: str = "plain"
    trousers: str = "#2f3a4c"
    skin: str = "#c99b7d"
    hair: str = "#2b2018"
    shoes: str = "#d8d8d4"
    height: float = 1.76
    build: float = 1.0
    sleeves: float = 0.5
    """Share of the upper arm (under 1) or of the whole arm (up to 2) that is covered."""
    long_hair: bool = False

    def shirt_material(self) -> Material:
        """Return the shirt's cloth."""
        color, second = linear(self.shirt), linear(self.second or self.shirt)
        if self.pattern == "stripes":
            return Material(partial(striped, color=color, second=second, width=0.075), 0.6)
        if self.pattern == "checks":
            return Material(partial(checked, color=color, second=second, width=0.06), 0.55)
        return Material(partial(cloth, color=color), 0.6)


LOOKS: tuple[Look, ...] = (
    Look("#b8402f", trousers="#2c3b57", skin="#c89a7c", hair="#3a281a", height=1.80),
    Look(
        "#e3e1da",
        "#3b5a80",
        "stripes",
        "#57524a",
        "#d8ae92",
        "#8a5a2b",
        "#7a3b30",
        1.70,
        0.93,
        1.7,
        True,
    ),
    Look(
        "#3f6b4a", "#b9b08a", "checks", "#23252b", "#8d5e43", "#15110e", "#23252b", 1.84, 1.08, 1.9
    ),
    Look("#6a5a8c", trousers="#b0a58c", skin="#e0b79d", hair="#c9a25e", height=1.66, build=0.95),
)


@dataclass(frozen=True, slots=True, eq=False)
class Foot:
    """A foot: the ankle's position, heading, and pitch (toes down is positive), radians."""

    ankle: Array
    heading: float
    pitch: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Posture:
    """Posture of a body at one moment; positions in the room, index 0 left and 1 right."""

    pelvis: Array
    facing: float
    feet: tuple[Foot, Foot]
    hands: tuple[Array, Array]
    lean: float = 0.03
    side: float = 0.0
    twist: float = 0.0
    gaze: Array | None = None
    breath: float = 0.0
    elbows: Array = field(default_factory=lambda: vec(0.55, -0.75, -0.35))


def hanging_hands(
    posture_pelvis: Array, facing: float, height: float, swing: float = 0.0
) -> tuple[Array, Array]:
    """Return hands hanging at the sides; ``swing`` moves the left forward, the right back."""
    s = height / 1.75
    axes = yaw(facing)
    left = posture_pelvis + matmul(
        axes, vec(0.24, -0.145 + 0.1 * abs(swing), 0.02 + 0.26 * swing) * s
    )
    right = posture_pelvis + matmul(
        axes, vec(-0.24, -0.145 + 0.1 * abs(swing), 0.02 - 0.26 * swing) * s
    )
    return left, right


def standing_feet(
    place: Array, facing: float, height: float, apart: float = 0.13
) -> tuple[Foot, Foot]:
    """Return the feet of a standing person at ``place`` on the floor."""
    axes = yaw(facing)
    y = 0.085 * height / 1.75
    return (
        Foot(place + matmul(axes, vec(apart, y, 0.03)), facing + math.radians(10)),
        Foot(place + matmul(axes, vec(-apart, y, -0.03)), facing - math.radians(10)),
    )
