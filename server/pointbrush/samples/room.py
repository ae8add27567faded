"""The still room: floor, walls and furniture."""

from __future__ import annotations

from functools import partial

import numpy as np

from pointbrush.samples.geometry import Array, along, rigid, vec
from pointbrush.samples.lighting import Lamp, Lights
from pointbrush.samples.render import Solid, block, disc, egg, rod
from pointbrush.samples.reproducible import cos, sin
from pointbrush.samples.shapes import Ball, Lathe
from pointbrush.samples.textures import (
    Material,
    books,
    cloth,
    linear,
    matte,
    plain,
    planks,
    poster,
    shiny,
    wallpaper,
    weave,
    wood,
)

WIDTH, HEIGHT, BACK, FRONT = 4.7, 2.55, -4.45, 2.2

PINE = Material(partial(wood, color=linear("#b98a58"), along=0), 0.6)
OAK = Material(partial(wood, color=linear("#7d5636"), along=1), 0.5)
WHITE = matte("#e6e3dc", grain=0.05, infrared=0.7)


class LivingRoom:
    """Parts of ``recording.Scene`` that the scenes in the living room share."""

    def __init__(self, seed: int, T_room_camera: Array) -> None:
        self._seed, self._camera = seed, T_room_camera

    @property
    def camera_pose(self) -> Array:
        return self._camera

    @property
    def lights(self) -> Lights:
        return _day_light()

    def still(self) -> list[Solid]:
        return _furnished(np.random.default_rng([self._seed, 3]))


def _furnished(rng: np.random.Generator) -> list[Solid]:
    """All still solids of the room, with small differences by ``rng``."""
    return [
        *_shell(rng),
        *_window(),
        *_door(),
        *_shelf(),
        *_sofa(),
        *_table(),
        *_floor_lamp(),
        *_plant(rng),
        *_clutter(rng),
    ]


def _day_light() -> Lights:
    """Daylight from a tall window on the left, out of view, and a warm ceiling lamp."""
    return Lights(
        (
            Lamp(vec(-2.2, 1.75, -0.9), (2.5, 2.45, 2.4), 2.6, 0.45),
            Lamp(vec(0.35, 2.4, -2.7), (0.75, 0.60, 0.42), 2.2, 0.18),
        )
    )


def _shell(rng: np.random.Generator) -> list[Solid]:
    half = WIDTH / 2
    tint = ["#c9c2ae", "#b9c4c0", "#cdbfa9", "#bfc0c9"][int(rng.integers(4))]
    paper = partial(wallpaper, color=linear(tint))
    side = Material(partial(wallpaper, color=linear("#d4cfc2"), axis=2), 0.65)
    floor = Material(partial(planks, color=linear("#a9774a")), 0.55, 0.12)
    rug = partial(
        weave,
        color=linear("#7c2f2a"),
        second=linear("#c7a06a"),
        border=linear("#27324a"),
        half=(1.35, 0.0, 0.8),
    )
    skirting = matte("#dedbd2", grain=0.04, infrared=0.7)
    return [
        block((-half, -0.1, BACK), (half, 0, FRONT), floor),
        block((-half, 0, BACK - 0.1), (half, HEIGHT, BACK), Material(paper, 0.65)),
        block((-half - 0.1, 0, BACK), (-half, HEIGHT, FRONT), side),
        block((half, 0, BACK), (half + 0.1, HEIGHT, FRONT), side),
        block((-half, HEIGHT, BACK), (half, HEIGHT + 0.1, FRONT), WHITE),
        block((-half, 0, BACK), (half, 0.09, BACK + 0.015), skirting),
        block((-half, 0, BACK), (-half + 0.015, 0.09, FRONT), skirting),
        block((half - 0.015, 0, BACK), (half, 0.09, FRONT), skirting),
        block((-1.35, 0, -3.45), (1.35, 0.012, -1.85), Material(rug, 0.4), 0.06),
        block(
            (0.95, 1.45, BACK),
            (1.75, 2.0, BACK + 0.02),
            Material(partial(poster, seed=float(rng.integers(3, 40)), half=(0.4, 0.275)), 0.6),
        ),
        block(
            (-0.62, 1.35, BACK),
            (-0.22, 1.92, BACK + 0.02),
            Material(partial(poster, seed=float(rng.integers(40, 90)), half=(0.2, 0.285)), 0.6),
        ),
        disc(
            (0.35, 2.42, -2.7),
            0.18,
            0.09,
            Material(partial(plain, color=(0.9, 0.8, 0.6)), 0.6, 0, 2.5),
        ),
    ]


def _window() -> list[Solid]:
    x = -WIDTH / 2
    sky = Material(partial(plain, color=(0.78, 0.88, 1.0), grain=0.05, scale=0.5), 0.0, 0, 4.5)
    fabric = Material(partial(cloth, color=linear("#b7b09a"), fold=0.3), 0.5)
    parts = [block((x, 0.85, -4.15), (x + 0.02, 2.1, -3.25), sky)]
    parts += [block((x, 0.8, z), (x + 0.05, 2.15, z + 0.05), WHITE) for z in (-4.2, -3.72, -3.25)]
    parts += [block((x, y, -4.2), (x + 0.05, y + 0.05, -3.2), WHITE) for y in (0.8, 1.65, 2.1)]
    parts.append(block((x, 0.76, -4.25), (x + 0.16, 0.8, -3.15), WHITE))
    for centre in (-4.28, -3.1):
        for fold in range(4):
            z = centre + (fold - 1.5) * 0.075
            parts.append(
                rod(
                    vec(x + 0.09 + 0.02 * (fold % 2), 0.35, z),
                    vec(x + 0.09, 2.25, z),
                    (0.045, 0.04),
                    fabric,
                    roughness=0.3,
                )
            )
    return parts


def _door() -> list[Solid]:
    z = BACK
    return [
        block((-0.02, 0, z), (0.82, 2.08, z + 0.05), WHITE),
        block((0.04, 0.0, z), (0.76, 2.02, z + 0.065), matte("#cfc8b8", grain=0.04)),
        block((0.13, 1.15, z), (0.67, 1.9, z + 0.07), matte("#c4bcab", grain=0.04)),
        block((0.13, 0.15, z), (0.67, 1.02, z + 0.07), matte("#c4bcab", grain=0.04)),
        rod(
            vec(0.68, 1.02, z + 0.11),
            vec(0.59, 1.02, z + 0.11),
            (0.011, 0.011),
            shiny("#8e8c86", gloss=1.0, infrared=0.3),
        ),
    ]


def _shelf() -> list[Solid]:
    left, right, z, depth = -1.95, -0.85, BACK, 0.3
    parts = [
        block((left, 0, z), (left + 0.025, 1.95, z + depth), OAK),
        block((right - 0.025, 0, z), (right, 1.95, z + depth), OAK),
        block((left, 0, z), (right, 1.95, z + 0.015), OAK),
    ]
    row = Material(partial(books), 0.5)
    for level in range(6):
        y = 0.05 + level * 0.375
        parts.append(block((left, y, z), (right, y + 0.025, z + depth), OAK))
        if level < 5:
            stop = left + 0.03 + (0.98, 0.55, 0.8, 0.62, 0.9)[level]
            tall = (0.27, 0.24, 0.29, 0.25, 0.26)[level]
            parts.append(block((left + 0.03, y + 0.025, z), (stop, y + tall, z + 0.2), row))
    vase = Lathe([0, 0.02, 0.1, 0.2, 0.24, 0.26], [0.05, 0.06, 0.085, 0.04, 0.035, 0.045])
    parts.append(Solid(vase, rigid(np.eye(3), vec(-1.05, 0.45, z + 0.16)), shiny("#2f6f75")))
    parts.append(egg(vec(-1.06, 1.29, z + 0.17), (0.1, 0.1, 0.1), shiny("#c8552b")))
    return parts


def _sofa() -> list[Solid]:
    fabric = Material(partial(cloth, color=linear("#5b6b78"), fold=0.35), 0.45)
    pillow = Material(partial(cloth, color=linear("#d9a441"), fold=0.1), 0.5)
    z = BACK + 0.08
    parts = [
        block((0.98, 0.08, z), (2.22, 0.3, z + 0.82), fabric, roughness=0.1),
        block((0.98, 0.3, z), (2.22, 0.72, z + 0.2), fabric, roughness=0.1),
        rod(vec(1.0, 0.72, z + 0.1), vec(2.2, 0.72, z + 0.1), (0.1, 0.1), fabric, roughness=0.2),
    ]
    for x in (1.0, 2.2):
        parts.append(block((x - 0.1, 0.05, z), (x + 0.1, 0.5, z + 0.85), fabric, roughness=0.1))
        parts.append(
            rod(vec(x, 0.5, z + 0.08), vec(x, 0.5, z + 0.78), (0.11, 0.11), fabric, roughness=0.2)
        )
    for x in (1.33, 1.87):
        parts.append(
            Solid(
                Ball(),
                rigid(np.eye(3), vec(x, 0.36, z + 0.52)),
                fabric,
                vec(0.3, 0.12, 0.36),
                0,
                0.25,
            )
        )
        parts.append(egg(vec(x, 0.6, z + 0.27), (0.29, 0.22, 0.12), fabric, roughness=0.25))
    parts.append(egg(vec(1.2, 0.6, z + 0.42), (0.19, 0.19, 0.09), pillow, roughness=0.25))
    return parts


def _table() -> list[Solid]:
    """Return a side table with a screen, a mug and papers, on the left."""
    parts = [block((-2.3, 0.70, -3.35), (-1.72, 0.735, -2.45), PINE)]
    parts += [
        block((x - 0.025, 0, z - 0.025), (x + 0.025, 0.70, z + 0.025), PINE)
        for x in (-2.26, -1.77)
        for z in (-3.31, -2.5)
    ]
    black = matte("#101113", infrared=0.06)
    mug = Lathe([0, 0.004, 0.09, 0.095], [0.036, 0.04, 0.04, 0.037])
    parts += [
        block((-2.24, 0.85, -3.25), (-2.2, 1.2, -2.65), black, 0.5),
        block((-2.2, 0.735, -3.02), (-2.12, 0.86, -2.9), black, 0.5),
        Solid(mug, rigid(np.eye(3), vec(-1.85, 0.735, -2.65)), shiny("#b33a3a")),
        block((-2.02, 0.735, -2.95), (-1.8, 0.755, -2.78), matte("#e9e6dd"), 0.3),
        disc((-1.95, 0, -2.2), 0.15, 0.36, matte("#6d7466")),
    ]
    return parts


def _floor_lamp() -> list[Solid]:
    shade = Lathe([0, 0.02, 0.24, 0.26], [0.19, 0.19, 0.12, 0.11])
    glow = Material(partial(plain, color=linear("#f0d9a8"), grain=0.05), 0.55, 0, 0.9)
    steel = shiny("#5a5a5c", gloss=0.8, infrared=0.3)
    x, z = -0.62, BACK + 0.28
    return [
        disc((x, 0, z), 0.14, 0.025, steel),
        rod(vec(x, 0.02, z), vec(x, 1.02, z), (0.012, 0.012), steel),
        Solid(shade, rigid(np.eye(3), vec(x, 0.98, z)), glow),
    ]


def _plant(rng: np.random.Generator) -> list[Solid]:
    x, z = 1.98, -3.1
    pot = Lathe([0, 0.01, 0.28, 0.3, 0.31], [0.11, 0.12, 0.16, 0.17, 0.15])
    parts = [Solid(pot, rigid(np.eye(3), vec(x, 0, z)), matte("#a5583a", infrared=0.5))]
    for number in range(26):
        angle = number * 2.4
        height = 0.45 + 0.75 * rng.random()
        reach = 0.10 + 0.24 * rng.random()
        tip = vec(x + reach * cos(angle), height, z + reach * sin(angle))
        root = vec(x, 0.3 + 0.35 * (height - 0.3), z)
        green = matte(["#3d6b34", "#4f7f3c", "#2f5a33"][number % 3], grain=0.3, infrared=0.9)
        R = along(root, tip, vec(-sin(angle), 0.2, cos(angle)))[:3, :3]
        parts.append(egg(tip, (0.055, 0.15, 0.01), green, R=R, roughness=0.2))
        parts.append(rod(root, tip, (0.006, 0.004), green))
    return parts


def _clutter(rng: np.random.Generator) -> list[Solid]:
    card = Material(partial(plain, color=linear("#a77f52"), grain=0.12, scale=0.2), 0.6)
    tape = matte("#c9b183")
    turn = float(rng.uniform(-0.4, 0.4))
    return [
        block((1.75, 0, -2.5), (2.25, 0.34, -2.1), card, turn),
        block((1.97, 0.001, -2.502), (2.03, 0.342, -2.098), tape, turn),
        block((1.82, 0.34, -2.45), (2.18, 0.58, -2.16), card, turn + 0.5),
        egg(vec(-1.5, 0.11, -3.75), (0.11, 0.11, 0.11), shiny("#2d62a8")),
        block((-0.5, 0, BACK + 0.02), (-0.42, 0.75, BACK + 0.1), PINE, 0.2),
        block((0.86, 0, BACK + 0.1), (0.9, 0.35, BACK + 0.4), matte("#22262b", infrared=0.1)),
    ]
