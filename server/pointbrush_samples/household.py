"""Further furniture of a lived-in home, as in ``furniture``: kitchen, bathroom, seats, bags."""

from __future__ import annotations

import math

from pointbrush.samples.geometry import vec
from pointbrush.samples.render import Solid, block, disc, egg, rod
from pointbrush.samples.reproducible import cos, sin
from pointbrush.samples.textures import matte
from pointbrush_samples.furniture import (
    AT_WALLS,
    STANDING,
    WHITE,
    Furniture,
    Makers,
    Rng,
    chair,
    colour,
    fabric,
    material,
    table,
)


def counter(rng: Rng) -> Furniture:
    """Return a run of kitchen units under one worktop, with a sink's tap or a hob."""
    w, d, h = rng.uniform(1.0, 3.0), rng.uniform(0.58, 0.65), rng.uniform(0.85, 0.94)
    front, top = material(rng), material(rng)
    parts = [
        block((-w / 2, 0, -d / 2), (w / 2, 0.1, d / 2 - 0.05), matte(colour(rng))),
        block((-w / 2, 0.1, -d / 2), (w / 2, h - 0.04, d / 2 - 0.02), front),
        block((-w / 2, h - 0.04, -d / 2), (w / 2, h, d / 2), top),
    ]
    units = max(1, round(w / 0.6))
    for k in range(units):
        x0, x1 = -w / 2 + k * w / units + 0.006, -w / 2 + (k + 1) * w / units - 0.006
        parts.append(block((x0, 0.12, d / 2 - 0.02), (x1, h - 0.06, d / 2 - 0.002), front))
    x = rng.uniform(-0.3, 0.3) * w
    if rng.random() < 0.6:
        steel = matte("#9a9c9e")
        parts += [
            rod(vec(x, h, -d / 2 + 0.08), vec(x, h + 0.25, -d / 2 + 0.08), (0.015, 0.015), steel),
            rod(
                vec(x, h + 0.25, -d / 2 + 0.08),
                vec(x, h + 0.22, -d / 2 + 0.25),
                (0.012, 0.01),
                steel,
            ),
        ]
    else:
        black = matte("#1c1c1e", infrared=0.3)
        parts.append(block((x - 0.29, h, -0.22), (x + 0.29, h + 0.008, 0.24), black))
    return Furniture(tuple(parts), w, d, h)


def machine(rng: Rng) -> Furniture:
    """Return a washing machine, a stove or a dishwasher."""
    w, d, h = 0.6, rng.uniform(0.5, 0.62), rng.uniform(0.82, 0.9)
    body, dark = matte(WHITE if rng.random() < 0.7 else colour(rng)), matte("#25262a", infrared=0.3)
    parts = [block((-w / 2, 0, -d / 2), (w / 2, h, d / 2), body)]
    if rng.random() < 0.5:
        parts.append(egg(vec(0, h * 0.48, d / 2), (0.19, 0.19, 0.035), dark))
    else:
        parts.append(block((-0.25, 0.2, d / 2), (0.25, 0.62, d / 2 + 0.012), dark))
        parts.append(
            rod(vec(-0.25, 0.68, d / 2 + 0.04), vec(0.25, 0.68, d / 2 + 0.04), (0.012, 0.012), dark)
        )
    return Furniture(tuple(parts), w, d, h)


def toilet(rng: Rng) -> Furniture:
    """Return a toilet with its cistern."""
    white, tall = matte(WHITE), rng.uniform(0.38, 0.44)
    parts = (
        egg(vec(0, tall * 0.75, 0.08), (0.18, tall * 0.28, 0.24), white),
        rod(vec(0, 0.02, -0.02), vec(0, tall * 0.6, 0.02), (0.12, 0.14), white),
        egg(
            vec(0, tall, 0.08),
            (0.19, 0.03, 0.24),
            matte(colour(rng)) if rng.random() < 0.3 else white,
        ),
        block((-0.19, tall, -0.34), (0.19, tall + 0.36, -0.17), white),
    )
    return Furniture(parts, 0.4, 0.68)


def basin(rng: Rng) -> Furniture:
    """Return a wash basin on a column or on a cupboard."""
    w, d, h, white = (
        rng.uniform(0.45, 0.8),
        rng.uniform(0.4, 0.5),
        rng.uniform(0.8, 0.88),
        matte(WHITE),
    )
    parts = [
        block((-w / 2, h - 0.14, -d / 2), (w / 2, h, -d / 2 + 0.12), white),
        egg(vec(0, h - 0.06, 0.02), (w / 2, 0.13, d / 2), white),
        rod(
            vec(0, h, -d / 2 + 0.06),
            vec(0, h + 0.12, -d / 2 + 0.12),
            (0.02, 0.012),
            matte("#a5a7a9"),
        ),
    ]
    if rng.random() < 0.5:
        parts.append(
            rod(vec(0, 0, -d / 2 + 0.12), vec(0, h - 0.14, -d / 2 + 0.12), (0.08, 0.09), white)
        )
    else:
        parts.append(
            block((-w / 2 + 0.02, 0.1, -d / 2), (w / 2 - 0.02, h - 0.12, d / 4), material(rng))
        )
    return Furniture(tuple(parts), w, d)


def bathtub(rng: Rng) -> Furniture:
    """Return a bathtub: a rim round a hollow."""
    w, d, h, white = (
        rng.uniform(1.4, 1.75),
        rng.uniform(0.68, 0.8),
        rng.uniform(0.5, 0.6),
        matte(WHITE),
    )
    rim = 0.07
    parts = (
        block((-w / 2, 0, -d / 2), (w / 2, 0.15, d / 2), white),
        block((-w / 2, 0.15, -d / 2), (w / 2, h, -d / 2 + rim), white),
        block((-w / 2, 0.15, d / 2 - rim), (w / 2, h, d / 2), white),
        block((-w / 2, 0.15, -d / 2), (-w / 2 + rim, h, d / 2), white),
        block((w / 2 - rim, 0.15, -d / 2), (w / 2, h, d / 2), white),
    )
    return Furniture(parts, w, d)


def nightstand(rng: Rng) -> Furniture:
    """Return a low chest: a bedside table, a television board or a bench."""
    w, d, h = rng.uniform(0.35, 1.7), rng.uniform(0.3, 0.5), rng.uniform(0.35, 0.6)
    stuff, foot = material(rng), rng.uniform(0.0, 0.14)
    parts = [block((-w / 2, foot, -d / 2), (w / 2, h, d / 2), stuff)]
    if foot > 0.03:
        parts += [
            block(
                (sx * w / 2 - 0.02, 0, sz * d / 2 - 0.02),
                (sx * w / 2 + 0.02, foot, sz * d / 2 + 0.02),
                stuff,
            )
            for sx in (-0.9, 0.9)
            for sz in (-0.9, 0.9)
        ]
    rows = max(1, round((h - foot) / 0.18))
    for r in range(rows):
        y0 = foot + r * (h - foot) / rows
        parts.append(
            block(
                (-w / 2 + 0.01, y0 + 0.01, d / 2),
                (w / 2 - 0.01, y0 + (h - foot) / rows - 0.01, d / 2 + 0.012),
                stuff,
            )
        )
    return Furniture(tuple(parts), w, d, h)


def corner_sofa(rng: Rng) -> Furniture:
    """Return a sofa with a long seat at one end, low cushions and loose pillows."""
    w, d, h, stuff = (
        rng.uniform(1.9, 2.9),
        rng.uniform(0.85, 1.0),
        rng.uniform(0.36, 0.46),
        fabric(rng),
    )
    deep, side, back = rng.uniform(1.4, 1.7), 1 if rng.random() < 0.5 else -1, rng.uniform(0.7, 0.9)
    x0, x1 = sorted((side * (w / 2 - 0.9), side * w / 2))
    z = -deep / 2
    parts = [
        block((-w / 2, 0.04, z), (w / 2, h, z + d), stuff, roughness=0.15),
        block((x0, 0.04, z), (x1, h, deep / 2), stuff, roughness=0.15),
        block((-w / 2, 0.04, z), (w / 2, back, z + 0.2), stuff, roughness=0.15),
        block((-w / 2, 0.04, z), (-w / 2 + 0.16, 0.6, z + d), stuff, roughness=0.15),
        block((w / 2 - 0.16, 0.04, z), (w / 2, 0.6, z + d), stuff, roughness=0.15),
    ]
    for k in range(int(rng.integers(2, 5))):
        at = vec((k - 1.5) * w / 4.5, h + 0.18, z + 0.3)
        parts.append(egg(at, (0.25, 0.2, 0.11), stuff, roughness=0.3))
    return Furniture(tuple(parts), w, deep)


def armchair(rng: Rng) -> Furniture:
    """Return a soft chair with round arms and back."""
    w, d, h, stuff = (
        rng.uniform(0.65, 0.9),
        rng.uniform(0.65, 0.9),
        rng.uniform(0.38, 0.45),
        fabric(rng),
    )
    top = rng.uniform(0.75, 1.05)
    parts = (
        block((-w / 2 + 0.08, 0.1, -d / 2 + 0.1), (w / 2 - 0.08, h, d / 2), stuff, roughness=0.2),
        rod(
            vec(-w / 2 + 0.1, h + 0.14, -d / 2 + 0.1),
            vec(-w / 2 + 0.1, h + 0.1, d / 2 - 0.1),
            (0.1, 0.1),
            stuff,
        ),
        rod(
            vec(w / 2 - 0.1, h + 0.14, -d / 2 + 0.1),
            vec(w / 2 - 0.1, h + 0.1, d / 2 - 0.1),
            (0.1, 0.1),
            stuff,
        ),
        egg(
            vec(0, (h + top) / 2, -d / 2 + 0.14),
            (w / 2, (top - h) / 2 + 0.15, 0.14),
            stuff,
            roughness=0.2,
        ),
        block(
            (-w / 2, 0.08, -d / 2 + 0.05),
            (-w / 2 + 0.16, h + 0.1, d / 2 - 0.05),
            stuff,
            roughness=0.2,
        ),
        block(
            (w / 2 - 0.16, 0.08, -d / 2 + 0.05),
            (w / 2, h + 0.1, d / 2 - 0.05),
            stuff,
            roughness=0.2,
        ),
    )
    return Furniture(parts, w, d)


def stool(rng: Rng) -> Furniture:
    """Return a stool or a bar stool, on splayed legs or on a column."""
    r, h, stuff = rng.uniform(0.14, 0.22), rng.uniform(0.4, 0.8), material(rng)
    parts = [disc((0, h - 0.04, 0), r, 0.04, stuff)]
    if rng.random() < 0.5:
        parts += [disc((0, 0, 0), r * 1.1, 0.02, stuff), disc((0, 0, 0), 0.03, h - 0.04, stuff)]
    else:
        for k in range(3):
            a = 2 * math.pi * k / 3
            foot = vec(1.2 * r * cos(a), 0.0, 1.2 * r * sin(a))
            parts.append(
                rod(foot, vec(0.6 * foot[0], h - 0.05, 0.6 * foot[2]), (0.016, 0.016), stuff)
            )
    return Furniture(tuple(parts), 2.4 * r, 2.4 * r)


def pouf(rng: Rng) -> Furniture:
    """Return a cushion on the floor, a bean bag or a full sack."""
    r, h = rng.uniform(0.2, 0.45), rng.uniform(0.15, 0.5)
    stuff = fabric(rng)
    low = egg(vec(0, h * 0.45, 0), (r, h * 0.55, r * rng.uniform(0.7, 1.0)), stuff, roughness=0.3)
    return Furniture((low,), 2 * r, 2 * r)


def bag(rng: Rng) -> Furniture:
    """Return a rucksack or a bag with its straps."""
    w, d, h, stuff = (
        rng.uniform(0.25, 0.4),
        rng.uniform(0.12, 0.22),
        rng.uniform(0.3, 0.5),
        fabric(rng),
    )
    parts = (
        egg(vec(0, h * 0.45, 0), (w / 2, h * 0.52, d / 2), stuff, roughness=0.3),
        egg(vec(0, h * 0.3, d * 0.4), (w * 0.35, h * 0.25, d * 0.3), stuff, roughness=0.3),
        rod(vec(-w * 0.2, h * 0.9, 0), vec(w * 0.2, h * 0.95, 0), (0.012, 0.012), stuff),
    )
    return Furniture(parts, w, d)


def shoes(rng: Rng) -> Furniture:
    """Return a pair of shoes."""
    stuff, long = matte(colour(rng)), rng.uniform(0.22, 0.31)
    parts: list[Solid] = []
    for x in (-0.07, 0.07):
        parts.append(egg(vec(x, 0.04, 0.04), (0.045, 0.045, long / 2), stuff))
        parts.append(egg(vec(x, 0.08, -long * 0.22), (0.04, 0.06, 0.06), stuff))
    return Furniture(tuple(parts), 0.25, long)


def drying_rack(rng: Rng) -> Furniture:
    """Return a coat stand or a rack with clothes over it."""
    w, h, frame = rng.uniform(0.5, 1.0), rng.uniform(0.9, 1.5), matte(colour(rng))
    parts = [
        rod(vec(sx * w / 2, 0, sz * 0.2), vec(sx * w / 2, h, 0), (0.012, 0.012), frame)
        for sx in (-1, 1)
        for sz in (-1, 1)
    ]
    parts.append(rod(vec(-w / 2, h, 0), vec(w / 2, h, 0), (0.012, 0.012), frame))
    for _ in range(int(rng.integers(1, 5))):
        x, wide, fall = rng.uniform(-0.35, 0.35) * w, rng.uniform(0.1, 0.25), rng.uniform(0.2, 0.35)
        parts.append(
            egg(vec(x, h - fall, 0), (wide, fall + 0.04, 0.05), fabric(rng), roughness=0.4)
        )
    return Furniture(tuple(parts), w, 0.4)


HOME_STANDING: Makers = (
    *STANDING, chair, chair, stool, pouf, bag, shoes, drying_rack, armchair, corner_sofa, table,
)  # fmt: skip
HOME_AT_WALLS: Makers = (
    *AT_WALLS, counter, counter, machine, toilet, basin, bathtub, nightstand, nightstand,
    corner_sofa, armchair, bag,
)  # fmt: skip
"""Makers of free-standing things of a home, and of things with their back at a wall."""
