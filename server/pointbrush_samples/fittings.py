"""Things on the walls, floor and tables of a home, as in ``furniture``.

Hanging things have their back at the wall; their solids begin above the floor.
"""

from __future__ import annotations

from functools import partial

from pointbrush.samples.geometry import axis_angle, rigid, vec
from pointbrush.samples.render import Solid, block, disc, egg, rod
from pointbrush.samples.reproducible import cos, sin
from pointbrush.samples.shapes import Box
from pointbrush.samples.textures import Material, matte, poster
from pointbrush_samples.furniture import (
    WHITE,
    Furniture,
    Makers,
    Rng,
    clutter,
    colour,
    fabric,
    material,
    screen,
)


def wall_cabinet(rng: Rng) -> Furniture:
    """Return a hung cupboard or an open board with brackets."""
    w, d, low = rng.uniform(0.4, 1.8), rng.uniform(0.2, 0.4), rng.uniform(1.2, 1.6)
    stuff = material(rng)
    if rng.random() < 0.4:
        parts = [block((-w / 2, low, -d / 2), (w / 2, low + 0.03, d / 2), stuff)]
        return Furniture(tuple(parts), w, d, low + 0.03)
    h = rng.uniform(0.4, 0.75)
    parts = [block((-w / 2, low, -d / 2), (w / 2, low + h, d / 2 - 0.02), stuff)]
    doors = max(1, round(w / 0.45))
    for k in range(doors):
        x0, x1 = -w / 2 + k * w / doors + 0.004, -w / 2 + (k + 1) * w / doors - 0.004
        parts.append(block((x0, low + 0.004, d / 2 - 0.02), (x1, low + h - 0.004, d / 2), stuff))
    return Furniture(tuple(parts), w, d)


def curtain(rng: Rng) -> Furniture:
    """Return a curtain: upright folds from a rail, to the floor or to a sill."""
    w, top = rng.uniform(0.4, 1.6), rng.uniform(2.0, 2.3)
    low, stuff = (0.02 if rng.random() < 0.7 else 0.8), fabric(rng)
    parts: list[Solid] = []
    folds = max(3, int(w / rng.uniform(0.09, 0.16)))
    for k in range(folds):
        x = -w / 2 + (k + 0.5) * w / folds
        middle = vec(x, (low + top) / 2, 0.02 * (-1) ** k)
        parts.append(egg(middle, (0.62 * w / folds, (top - low) * 0.62, 0.045), stuff))
    parts.append(
        rod(vec(-w / 2 - 0.1, top, 0), vec(w / 2 + 0.1, top, 0), (0.014, 0.014), matte(colour(rng)))
    )
    return Furniture(tuple(parts), w, 0.1)


def radiator(rng: Rng) -> Furniture:
    """Return a radiator under a window: ribs or a plate."""
    w, low, h, white = (
        rng.uniform(0.5, 1.6),
        rng.uniform(0.1, 0.15),
        rng.uniform(0.5, 0.7),
        matte(WHITE),
    )
    if rng.random() < 0.5:
        return Furniture((block((-w / 2, low, -0.02), (w / 2, low + h, 0.05), white),), w, 0.1)
    ribs = int(w / 0.06)
    xs = [(k + 0.5) * w / ribs - w / 2 for k in range(ribs)]
    parts = [rod(vec(x, low, 0.01), vec(x, low + h, 0.01), (0.022, 0.022), white) for x in xs]
    return Furniture(tuple(parts), w, 0.1)


def door(rng: Rng) -> Furniture:
    """Return a door in its frame, closed or ajar, with a handle."""
    w, h, leaf = rng.uniform(0.75, 0.95), rng.uniform(1.98, 2.1), material(rng)
    frame = leaf if rng.random() < 0.5 else matte(WHITE)
    parts = [
        block((-w / 2 - 0.07, 0, -0.02), (-w / 2, h + 0.07, 0.02), frame),
        block((w / 2, 0, -0.02), (w / 2 + 0.07, h + 0.07, 0.02), frame),
        block((-w / 2, h, -0.02), (w / 2, h + 0.07, 0.02), frame),
        block((-w / 2, 0.005, -0.02), (w / 2, h, 0.005), leaf),
        rod(vec(w * 0.32, 1.02, 0.05), vec(w * 0.44, 1.02, 0.05), (0.01, 0.01), matte("#8d8f92")),
    ]
    return Furniture(tuple(parts), w, 0.05)


def window(rng: Rng) -> Furniture:
    """Return a window's frame, panes and sill."""
    w, h, low = rng.uniform(0.6, 1.8), rng.uniform(0.8, 1.4), rng.uniform(0.75, 0.95)
    white, pane = matte(WHITE), matte("#b9c7d4", infrared=0.15)
    parts = [
        block((-w / 2, low, -0.03), (w / 2, low + h, -0.01), pane),
        block((-w / 2 - 0.05, low - 0.04, -0.03), (w / 2 + 0.05, low, 0.12), white),
    ]
    parts += [
        block((x - 0.04, low, -0.03), (x + 0.04, low + h, 0.03), white) for x in (-w / 2, 0, w / 2)
    ]
    parts += [
        block((-w / 2, y - 0.04, -0.03), (w / 2, y + 0.04, 0.03), white)
        for y in (low + 0.03, low + h - 0.03)
    ]
    return Furniture(tuple(parts), w, 0.06)


def picture(rng: Rng) -> Furniture:
    """Return a picture, a mirror, a board or a flat television on the wall."""
    w, h, thick = rng.uniform(0.25, 1.5), rng.uniform(0.25, 0.9), rng.uniform(0.012, 0.06)
    low = rng.uniform(1.0, 1.5)
    print_ = Material(partial(poster, seed=float(rng.integers(99)), half=(w / 2, h / 2)), 0.6)
    stuff = print_ if rng.random() < 0.5 else matte(colour(rng), infrared=0.4)
    return Furniture(
        (block((-w / 2, low, -thick / 2), (w / 2, low + h, thick / 2), stuff),), w, thick
    )


def towel(rng: Rng) -> Furniture:
    """Return a towel or a coat on a hook."""
    w, h, low = rng.uniform(0.15, 0.3), rng.uniform(0.3, 0.55), rng.uniform(0.7, 1.2)
    drop = egg(vec(0, low + h / 2, 0.01), (w, h / 2 + 0.1, 0.06), fabric(rng), roughness=0.4)
    return Furniture((drop,), 2 * w, 0.1)


def rug(rng: Rng) -> Furniture:
    """Return a rug."""
    w, d, h = rng.uniform(0.6, 2.4), rng.uniform(0.5, 1.8), rng.uniform(0.008, 0.025)
    if rng.random() < 0.25:
        return Furniture((disc((0, 0, 0), d / 2, h, fabric(rng)),), d, d)
    return Furniture((block((-w / 2, 0, -d / 2), (w / 2, h, d / 2), fabric(rng)),), w, d)


def laptop(rng: Rng) -> Furniture:
    """Return an open laptop, a keyboard or a printer."""
    w, stuff = rng.uniform(0.3, 0.45), matte(colour(rng), infrared=0.35)
    kind = rng.integers(3)
    if kind == 0:
        tilt = rng.uniform(0.1, 0.5)
        far = vec(0, 0.02 + 0.12 * cos(tilt), -0.13 - 0.12 * sin(tilt))
        pose = rigid(axis_angle(vec(1, 0, 0), -tilt), far)
        lid = Solid(Box(), pose, stuff, vec(w / 2, 0.12, 0.006))
        return Furniture((block((-w / 2, 0, -0.13), (w / 2, 0.02, 0.11), stuff), lid), w, 0.4)
    if kind == 1:
        return Furniture((block((-w / 2, 0, -0.07), (w / 2, 0.025, 0.07), stuff),), w, 0.14)
    h = rng.uniform(0.15, 0.3)
    tray = block((-w / 3, h * 0.3, 0.18), (w / 3, h * 0.36, 0.3), stuff)
    return Furniture((block((-w / 2, 0, -0.18), (w / 2, h, 0.18), stuff), tray), w, 0.6)


ON_WALLS: Makers = (
    picture, picture, picture, door, window, curtain, radiator, wall_cabinet, towel,
)  # fmt: skip
"""Makers of hanging things."""
ON_TOPS: Makers = (clutter, clutter, clutter, screen, laptop, laptop)
"""Makers of things on tables."""
