"""Furniture of random size and colour: each a few solids, base at the origin, y up, front to +z."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pointbrush.samples.geometry import Array, vec
from pointbrush.samples.render import Solid, block, disc, egg, rod
from pointbrush.samples.reproducible import cos, draw_normal, matmul, sin
from pointbrush.samples.textures import Material, books, cloth, linear, matte, poster, wood

Rng = np.random.Generator
ODD_PART = 0.15
"""Share of parts with a separate colour."""
WHITE = "#e4e2dd"
"""Paint and ceramics."""


@dataclass(frozen=True, slots=True, eq=False)
class Furniture:
    """``width`` along x and ``depth`` along z, metres; things may stand at the height ``top``."""

    solids: tuple[Solid, ...]
    width: float
    depth: float
    top: float = 0.0

    def placed(self, T_room_furniture: Array, label: int) -> list[Solid]:
        """Return its solids in the room."""
        return [replace(s, pose=matmul(T_room_furniture, s.pose), label=label) for s in self.solids]

    def repainted(self, palette: Sequence[Material], share: float, rng: Rng) -> Furniture:
        """Return it with a share of its materials, and now and then a part, from a palette."""

        def other(stuff: Material) -> Material:
            return palette[int(rng.integers(len(palette)))] if rng.random() < share else stuff

        painted: dict[int, Material] = {}
        solids = []
        for solid in self.solids:
            key = id(solid.material)
            if key not in painted:
                painted[key] = other(solid.material)
            stuff = other(painted[key]) if rng.random() < ODD_PART else painted[key]
            solids.append(replace(solid, material=stuff))
        return replace(self, solids=tuple(solids))


def colour(rng: Rng) -> str:
    """Return a random "#rrggbb", grey more often than not."""
    base = rng.uniform(30, 225)
    tint = rng.uniform(0, 70) * draw_normal(rng, 1, 3) * (rng.random() < 0.6)
    r, g, b = np.clip(base + tint, 8, 245).astype(int).tolist()
    return f"#{r:02x}{g:02x}{b:02x}"


def material(rng: Rng) -> Material:
    """Return timber, fabric or paint."""
    kind = rng.integers(3)
    if kind == 0:
        return Material(partial(wood, color=linear(colour(rng)), along=int(rng.integers(3))), 0.55)
    if kind == 1:
        return Material(partial(cloth, color=linear(colour(rng)), fold=0.25), 0.5)
    return matte(colour(rng))


def fabric(rng: Rng) -> Material:
    """Return cloth of random colour."""
    return Material(partial(cloth, color=linear(colour(rng)), fold=rng.uniform(0.1, 0.35)), 0.5)


def _legs(rng: Rng, w: float, d: float, height: float, stuff: Material) -> list[Solid]:
    thick = rng.uniform(0.015, 0.035)
    x, z = w / 2 - thick, d / 2 - thick
    corners = [(sx * x, sz * z) for sx in (-1, 1) for sz in (-1, 1)]
    if rng.random() < 0.4:
        return [rod(vec(a, 0, b), vec(a, height, b), (thick, thick), stuff) for a, b in corners]
    return [
        block((a - thick, 0, b - thick), (a + thick, height, b + thick), stuff) for a, b in corners
    ]


def table(rng: Rng) -> Furniture:
    """Return a table or desk, on four legs, on side panels or on a column."""
    w, d, h = rng.uniform(0.5, 1.8), rng.uniform(0.45, 0.9), rng.uniform(0.4, 0.8)
    stuff, thick = material(rng), rng.uniform(0.02, 0.05)
    parts = [block((-w / 2, h - thick, -d / 2), (w / 2, h, d / 2), stuff)]
    kind = rng.integers(4)
    if kind == 0:
        parts += [
            block((x - 0.02, 0, -d / 2), (x + 0.02, h - thick, d / 2), stuff)
            for x in (-w / 2 + 0.02, w / 2 - 0.02)
        ]
    elif kind == 1:
        parts += [
            disc((0, 0, 0), min(w, d) * 0.35, 0.03, stuff),
            disc((0, 0, 0), 0.04, h - thick, stuff),
        ]
    else:
        parts += _legs(rng, w, d, h - thick, stuff)
    return Furniture(tuple(parts), w, d, h)


def chair(rng: Rng) -> Furniture:
    """Return a chair with a back, some with arms, some on a star of castors."""
    w, d, h = rng.uniform(0.38, 0.56), rng.uniform(0.38, 0.55), rng.uniform(0.4, 0.5)
    back, stuff, seat = rng.uniform(0.35, 0.6), material(rng), material(rng)
    frame = matte(colour(rng))
    parts = [
        block((-w / 2, h - 0.06, -d / 2), (w / 2, h, d / 2), seat),
        block((-w / 2, h + 0.08, -d / 2), (w / 2, h + back, -d / 2 + 0.05), seat, roughness=0.1),
    ]
    if rng.random() < 0.35:
        parts.append(rod(vec(0, 0.08, 0), vec(0, h - 0.06, 0), (0.03, 0.03), frame))
        for k in range(5):
            a = 2 * math.pi * k / 5
            tip = vec(0.28 * cos(a), 0.04, 0.28 * sin(a))
            parts.append(rod(vec(0, 0.09, 0), tip, (0.025, 0.03), frame))
    else:
        parts += _legs(rng, w, d, h - 0.06, stuff)
    parts += [
        block((x - 0.02, h, -d / 2), (x + 0.02, h + 0.12, -d / 2 + 0.04), stuff)
        for x in (-w / 2 + 0.03, w / 2 - 0.03)
    ]
    if rng.random() < 0.4:
        for x in (-w / 2, w / 2):
            parts.append(block((x - 0.025, h + 0.18, -d / 2), (x + 0.025, h + 0.22, d / 4), stuff))
            parts.append(
                block((x - 0.02, h - 0.05, d / 4), (x + 0.02, h + 0.2, d / 4 + 0.04), stuff)
            )
    return Furniture(tuple(parts), w, d)


def sofa(rng: Rng) -> Furniture:
    """Return a sofa or armchair with cushions."""
    w, d, h = rng.uniform(0.75, 2.2), rng.uniform(0.75, 0.95), rng.uniform(0.36, 0.46)
    stuff, back = material(rng), rng.uniform(0.7, 0.95)
    parts = [
        block((-w / 2, 0.05, -d / 2), (w / 2, h * 0.75, d / 2), stuff, roughness=0.1),
        block((-w / 2, 0.05, -d / 2), (w / 2, back, -d / 2 + 0.22), stuff, roughness=0.1),
    ]
    parts += [
        block((x - 0.09, 0.05, -d / 2), (x + 0.09, 0.6, d / 2), stuff, roughness=0.1)
        for x in (-w / 2 + 0.09, w / 2 - 0.09)
    ]
    seats = max(1, round(w / 0.7))
    for k in range(seats):
        x = (k + 0.5 - seats / 2) * (w - 0.4) / seats
        half = (w - 0.4) / seats / 2
        parts.append(egg(vec(x, h * 0.8, 0.08), (half, 0.12, d * 0.38), stuff, roughness=0.25))
        parts.append(egg(vec(x, h + 0.2, -d / 2 + 0.26), (half, 0.22, 0.1), stuff, roughness=0.25))
    return Furniture(tuple(parts), w, d)


def bed(rng: Rng) -> Furniture:
    """Return a bed with a blanket and pillows; its head is at the wall."""
    w, d, h = rng.uniform(0.9, 1.8), rng.uniform(1.95, 2.15), rng.uniform(0.35, 0.55)
    frame, sheet = material(rng), Material(partial(cloth, color=linear(colour(rng)), fold=0.3), 0.6)
    white = matte("#e8e4da")
    parts = [
        block((-w / 2, 0.12, -d / 2), (w / 2, h - 0.15, d / 2), frame),
        block((-w / 2 + 0.03, h - 0.15, -d / 2 + 0.03), (w / 2 - 0.03, h, d / 2 - 0.03), white),
        block((-w / 2 - 0.02, 0.2, -d / 4), (w / 2 + 0.02, h + 0.05, d / 2), sheet, roughness=0.3),
        block((-w / 2, 0, -d / 2), (w / 2, h + rng.uniform(0.1, 0.6), -d / 2 + 0.06), frame),
    ]
    parts += [
        egg(vec(x, h + 0.05, -d / 2 + 0.35), (0.33, 0.1, 0.22), white, roughness=0.3)
        for x in ((-w / 4, w / 4) if w > 1.3 else (0.0,))
    ]
    return Furniture(tuple(parts), w, d)


def cabinet(rng: Rng) -> Furniture:
    """Return a cupboard, chest of drawers, fridge or box: closed, with gaps and handles."""
    w, d = rng.uniform(0.35, 1.4), rng.uniform(0.3, 0.65)
    h = rng.uniform(0.4, 2.1)
    body, front = material(rng), material(rng)
    parts = [block((-w / 2, 0, -d / 2), (w / 2, h, d / 2), body)]
    rows, columns = max(1, round(h / rng.uniform(0.2, 0.9))), max(1, round(w / 0.5))
    for r in range(rows):
        for c in range(columns):
            x0, x1 = -w / 2 + c * w / columns + 0.01, -w / 2 + (c + 1) * w / columns - 0.01
            y0, y1 = r * h / rows + 0.01, (r + 1) * h / rows - 0.01
            parts.append(block((x0, y0, d / 2), (x1, y1, d / 2 + 0.018), front))
            middle = (x0 + x1) / 2
            parts.append(
                block(
                    (middle - 0.06, y1 - 0.07, d / 2),
                    (middle + 0.06, y1 - 0.05, d / 2 + 0.05),
                    body,
                )
            )
    return Furniture(tuple(parts), w, d, h if h < 1.3 else 0.0)


def shelf(rng: Rng) -> Furniture:
    """Return an open shelf, with rows of books."""
    w, d, h = rng.uniform(0.5, 1.5), rng.uniform(0.22, 0.4), rng.uniform(0.8, 2.1)
    stuff, row = material(rng), Material(partial(books), 0.5)
    parts = [
        block((-w / 2, 0, -d / 2), (-w / 2 + 0.025, h, d / 2), stuff),
        block((w / 2 - 0.025, 0, -d / 2), (w / 2, h, d / 2), stuff),
        block((-w / 2, 0, -d / 2), (w / 2, h, -d / 2 + 0.012), stuff),
    ]
    levels = max(2, round(h / 0.36))
    for k in range(levels + 1):
        y = k * (h - 0.025) / levels
        parts.append(block((-w / 2, y, -d / 2), (w / 2, y + 0.025, d / 2), stuff))
        if k < levels and rng.random() < 0.75:
            stop = -w / 2 + w * rng.uniform(0.3, 0.97)
            tall = min(rng.uniform(0.18, 0.3), (h - 0.025) / levels - 0.06)
            parts.append(block((-w / 2 + 0.03, y + 0.025, -d / 2), (stop, y + tall, d * 0.2), row))
    return Furniture(tuple(parts), w, d, h if h < 1.3 else 0.0)


def lamp(rng: Rng) -> Furniture:
    """Return a floor lamp or a coat stand."""
    h, r, stuff = rng.uniform(1.2, 1.8), rng.uniform(0.12, 0.22), matte(colour(rng))
    shade = rod(vec(0, h - 0.1, 0), vec(0, h + 0.12, 0), (r, r * 0.7), matte(colour(rng)))
    pole = rod(vec(0, 0.02, 0), vec(0, h, 0), (0.015, 0.015), stuff)
    return Furniture((disc((0, 0, 0), 0.15, 0.03, stuff), pole, shade), 2 * r, 2 * r)


def plant(rng: Rng) -> Furniture:
    """Return a plant in a pot."""
    h, pot = rng.uniform(0.4, 1.5), rng.uniform(0.1, 0.2)
    parts = [disc((0, 0, 0), pot, pot * 1.8, matte(colour(rng)))]
    for _ in range(int(rng.integers(14, 30))):
        a, up = rng.uniform(0, 2 * math.pi), rng.uniform(0.45, 1.0) * h
        reach = rng.uniform(0.05, 0.2) + 0.1 * h
        tip = vec(reach * cos(a), pot * 1.8 + up * 0.8, reach * sin(a))
        green = matte(["#3d6b34", "#4f7f3c", "#2f5a33"][int(rng.integers(3))], grain=0.3)
        size = rng.uniform(0.04, 0.12)
        parts.append(egg(tip, (size, size * 1.3, 0.02 + size * 0.3), green, roughness=0.3))
        parts.append(rod(vec(0, pot * 1.7, 0), tip, (0.008, 0.005), green))
    return Furniture(tuple(parts), 2 * pot + 0.2, 2 * pot + 0.2)


def carton(rng: Rng) -> Furniture:
    """Return a cardboard box, a case or a stool."""
    w, d, h = rng.uniform(0.2, 0.6, 3)
    stuff = material(rng)
    if rng.random() < 0.25:
        return Furniture((disc((0, 0, 0), w / 2, h, stuff),), w, w)
    return Furniture((block((-w / 2, 0, -d / 2), (w / 2, h, d / 2), stuff),), w, d)


def bin_(rng: Rng) -> Furniture:
    """Return a waste bin or a bucket."""
    r, h = rng.uniform(0.1, 0.2), rng.uniform(0.25, 0.6)
    return Furniture((disc((0, 0, 0), r, h, matte(colour(rng))),), 2 * r, 2 * r)


def screen(rng: Rng) -> Furniture:
    """Return a monitor on its foot, for a table's top."""
    w, h, lift = rng.uniform(0.4, 0.75), rng.uniform(0.25, 0.42), rng.uniform(0.06, 0.16)
    black = matte(colour(rng), infrared=0.3)
    parts = (
        block((-w / 2, lift, -0.02), (w / 2, lift + h, 0.02), black),
        block((-0.03, 0, -0.05), (0.03, lift + 0.1, -0.01), black),
        block((-0.12, 0, -0.1), (0.12, 0.015, 0.08), black),
    )
    return Furniture(parts, w, 0.2)


def clutter(rng: Rng) -> Furniture:
    """Return a small thing of a table's top: box, can, ball, mug, bottle, pile of paper."""
    kind, stuff = rng.integers(6), matte(colour(rng))
    r, h = rng.uniform(0.025, 0.07), rng.uniform(0.06, 0.26)
    if kind == 0:
        w, d = rng.uniform(0.05, 0.3, 2)
        print_ = Material(partial(poster, seed=float(rng.integers(99)), half=(w / 2, h / 2)), 0.6)
        return Furniture((block((-w / 2, 0, -d / 2), (w / 2, h, d / 2), print_),), w, d)
    if kind == 1:
        return Furniture((egg(vec(0, r, 0), (r, r, r), stuff),), 2 * r, 2 * r)
    if kind == 2:
        parts = [disc((0, 0, 0), r, h * 0.6, stuff)]
        parts += [rod(vec(0, h * 0.55, 0), vec(0, h, 0), (r * 0.6, 0.012), stuff)]
        return Furniture(tuple(parts), 2 * r, 2 * r)
    if kind == 3:
        w, d, h = rng.uniform(0.15, 0.35), rng.uniform(0.1, 0.25), rng.uniform(0.01, 0.08)
        return Furniture((block((-w / 2, 0, -d / 2), (w / 2, h, d / 2), stuff),), w, d)
    if kind == 4:
        handle = rod(vec(r, h * 0.2, 0), vec(r + 0.03, h * 0.35, 0), (0.008, 0.008), stuff)
        return Furniture((disc((0, 0, 0), r, h * 0.5, stuff), handle), 2 * r + 0.06, 2 * r)
    return Furniture((disc((0, 0, 0), r, h, stuff),), 2 * r, 2 * r)


Makers = tuple[Callable[[Rng], Furniture], ...]
STANDING: Makers = (chair, carton, bin_, plant, lamp, sofa, table)
AT_WALLS: Makers = (cabinet, shelf, sofa, bed, cabinet, table)
"""Makers of free-standing furniture, and of furniture with its back at a wall."""
