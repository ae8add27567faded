"""Household things that get moved about on a table: each a few solids that move as one.

A thing's own frame has its origin at the middle of its base, y up.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

from pointbrush.samples.geometry import Array, axis_angle, rigid, vec
from pointbrush.samples.render import Solid
from pointbrush.samples.shapes import Lathe
from pointbrush.samples.solids import block, disc, egg, rod
from pointbrush.samples.textures import (
    Material,
    banded,
    linear,
    matte,
    poster,
    shiny,
    striped,
    wood,
)


@dataclass(frozen=True, slots=True, eq=False)
class Thing:
    """Solids in the thing's own frame, and where a hand takes it: radius and height, metres."""

    name: str
    color: str
    solids: tuple[Solid, ...]
    radius: float
    height: float

    def placed(self, T_room_thing: Array, label: int) -> list[Solid]:
        """Return its solids in the room."""
        return [replace(s, pose=T_room_thing @ s.pose, label=label) for s in self.solids]


def _turned(heights: list[float], radii: list[float], material: Material) -> Solid:
    return Solid(Lathe(heights, radii), np.eye(4), material)


def _mug() -> Thing:
    glaze = shiny("#c23b36", gloss=0.7)
    handle = [
        vec(0.036 + 0.028 * math.sin(a), 0.048 - 0.03 * math.cos(a), 0)
        for a in np.linspace(0.15, math.pi - 0.15, 6)
    ]
    ring = [rod(a, b, 0.0065, 0.0065, glaze) for a, b in pairwise(handle)]
    cup = _turned([0, 0.004, 0.09, 0.096, 0.097], [0.032, 0.037, 0.039, 0.039, 0.034], glaze)
    return Thing("mug", "#c23b36", (cup, *ring), 0.04, 0.09)


def _carton() -> Thing:
    print_ = Material(partial(poster, seed=7.0, half=(0.07, 0.3), size=0.09), 0.6)
    return Thing(
        "carton", "#e0a23a", (block((-0.07, 0, -0.026), (0.07, 0.19, 0.026), print_),), 0.05, 0.16
    )


def _ball() -> Thing:
    skin = Material(
        partial(striped, color=linear("#f2e6c9"), second=linear("#2f6fbf"), width=0.03), 0.6, 0.3
    )
    return Thing("ball", "#2f6fbf", (egg(vec(0, 0.042, 0), (0.042,) * 3, skin),), 0.04, 0.06)


def _bottle() -> Thing:
    glass = shiny("#2e7d4f", gloss=0.9, infrared=0.35)
    paper = matte("#e9e2c8", infrared=0.6)
    heights = [0, 0.006, 0.12, 0.155, 0.175, 0.215, 0.23]
    bottle = _turned(heights, [0.028, 0.033, 0.033, 0.026, 0.014, 0.013, 0.011], glass)
    return Thing(
        "bottle", "#2e7d4f", (bottle, disc((0, 0.035, 0), 0.0338, 0.065, paper)), 0.033, 0.14
    )


def _can() -> Thing:
    steel, red, white = linear("#b9bcc0"), linear("#d9772b"), linear("#f2f0ea")
    bands = ((-0.05, steel), (-0.012, red), (0.012, white), (0.05, red), (1.0, steel))
    material = Material(partial(banded, bands=bands), 0.45, 0.6)
    return Thing("can", "#d9772b", (disc((0, 0, 0), 0.033, 0.115, material),), 0.033, 0.09)


def _brick() -> Thing:
    timber = Material(partial(wood, color=linear("#d2a56a")), 0.65)
    return Thing(
        "wooden block",
        "#d2a56a",
        (
            block((-0.05, 0, -0.03), (0.05, 0.05, 0.03), timber),
            block((-0.025, 0.05, -0.03), (0.025, 0.085, 0.03), matte("#4a8c5c")),
        ),
        0.045,
        0.06,
    )


def _car() -> Thing:
    paint, tyre = shiny("#7a3fb0", gloss=0.6), matte("#1d1d1f", infrared=0.25)
    wheels = tuple(
        Solid(d.shape, rigid(axis_angle(vec(1, 0, 0), math.pi / 2), vec(x, 0.02, z)), tyre, d.scale)
        for x in (-0.045, 0.045)
        for z in (-0.032, 0.032)
        for d in (disc((0, 0, 0), 0.02, 0.014, tyre),)
    )
    shell = (
        block((-0.075, 0.018, -0.032), (0.075, 0.05, 0.032), paint),
        block((-0.035, 0.05, -0.028), (0.04, 0.078, 0.028), shiny("#cfd8de", gloss=0.8)),
    )
    return Thing("toy car", "#7a3fb0", (*shell, *wheels), 0.045, 0.06)


def _bowl() -> Thing:
    glaze = shiny("#2a9d96", gloss=0.6)
    heights, radii = [0, 0.004, 0.03, 0.058, 0.06], [0.03, 0.034, 0.06, 0.073, 0.066]
    return Thing("bowl", "#2a9d96", (_turned(heights, radii, glaze),), 0.07, 0.05)


THINGS: tuple[Callable[[], Thing], ...] = (
    _mug,
    _carton,
    _ball,
    _bottle,
    _car,
    _can,
    _brick,
    _bowl,
)
"""Makers of all the things there are."""
