"""Furnished rooms of random size; every piece of furniture and every thing has its own label."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.samples.geometry import Array, rigid, vec, yaw
from pointbrush.samples.people import body
from pointbrush.samples.posture import LOOKS, Posture, hanging_hands, standing_feet
from pointbrush.samples.render import Solid, block
from pointbrush.samples.reproducible import matmul
from pointbrush.samples.textures import Material, matte
from pointbrush_samples.fittings import ON_TOPS, ON_WALLS, rug
from pointbrush_samples.furniture import (
    AT_WALLS,
    STANDING,
    Furniture,
    Makers,
    chair,
    clutter,
    colour,
    material,
    screen,
)
from pointbrush_samples.household import HOME_AT_WALLS, HOME_STANDING

TRIES = 25
"""Places that are tried for a piece of furniture."""


@dataclass(frozen=True, slots=True)
class Furnishing:
    """Makers of a room's contents, and bounds of their numbers (from, below)."""

    standing: Makers = STANDING
    at_walls: Makers = AT_WALLS
    on_walls: Makers = ()
    """Without any, plain panels hang."""
    on_tops: Makers = ()
    """Without any, screens and small things lie on tops."""
    many_standing: tuple[int, int] = (5, 12)
    many_at_walls: tuple[int, int] = (4, 9)
    many_on_walls: tuple[int, int] = (2, 8)
    many_rugs: tuple[int, int] = (0, 1)
    alike: float = 0.0
    """Share of materials from the room's palette: of its walls, its floor and a few more."""
    apart: float = 0.85
    """Least distance of two pieces of furniture, as a multiple of the sum of their radii."""

    def check(self) -> None:
        """Raise BadInputError for bounds that allow nothing."""
        for name in ("many_standing", "many_at_walls", "many_on_walls", "many_rugs"):
            low, high = getattr(self, name)
            if not 0 <= low < high:
                raise BadInputError(f"{name}: expected 0 <= from < below, got {low}, {high}")
        if not (0 <= self.alike <= 1 and self.apart > 0):
            raise BadInputError("alike, apart: expected a share, 0 to 1, and a number above 0")


HOME = Furnishing(
    HOME_STANDING,
    HOME_AT_WALLS,
    ON_WALLS,
    ON_TOPS,
    many_standing=(6, 13),
    many_at_walls=(6, 12),
    many_on_walls=(5, 12),
    many_rugs=(0, 3),
    alike=0.65,
    apart=0.7,
)
"""A lived-in home: kitchen, bathroom, living and bedroom in one."""


@dataclass(eq=False)
class Interior:
    """A room from a seed: ``solids`` with labels from 1, the shell has label 0; y up, metres.

    ``width``, ``depth`` of the floor, whose middle is the origin, and ``height``.
    Raises BadInputError for a furnishing out of range.
    """

    seed: int
    furnishing: Furnishing = Furnishing()
    width: float = field(init=False)
    depth: float = field(init=False)
    height: float = field(init=False)
    solids: list[Solid] = field(default_factory=list)
    count: int = 0

    def __post_init__(self) -> None:
        rng = self._rng = np.random.default_rng([self.seed, 41])
        self.width, self.depth = rng.uniform(3.0, 7.0), rng.uniform(3.0, 7.0)
        self.height = rng.uniform(2.4, 3.0)
        self._taken: list[tuple[float, float, float]] = []
        self._shell()
        kinds = self.furnishing
        kinds.check()
        for _ in range(int(rng.integers(*kinds.many_at_walls))):
            self._at_wall(self._one_of(kinds.at_walls))
        for _ in range(int(rng.integers(*kinds.many_standing))):
            self._standing(self._one_of(kinds.standing))
        for _ in range(int(rng.integers(0, 3))):
            self._person()
        self._on_walls()
        for _ in range(int(rng.integers(*kinds.many_rugs)) if kinds.many_rugs[1] > 1 else 0):
            x, z = rng.uniform(-0.35, 0.35, 2) * (self.width, self.depth)
            self._add(rug(rng), float(x), float(z), rng.uniform(-0.4, 0.4))

    def _one_of(self, makers: Makers) -> Furniture:
        made = makers[int(self._rng.integers(len(makers)))](self._rng)
        share = self.furnishing.alike
        return made.repainted(self._palette, share, self._rng) if share else made

    def _add(self, furniture: Furniture, x: float, z: float, turn: float, y: float = 0.0) -> None:
        self.count += 1
        pose = rigid(yaw(turn), vec(x, y, z))
        self.solids += furniture.placed(pose, self.count)
        if furniture.top:
            self._things(furniture, pose, turn)

    def _shell(self) -> None:
        w, d, h, rng = self.width / 2, self.depth / 2, self.height, self._rng
        wall, floor, white = matte(colour(rng)), material(rng), matte("#e6e3dc")
        self._palette = [wall, floor, white]
        if self.furnishing.alike:
            self._palette += [white, material(rng), material(rng)]
        self.solids += [
            block((-w, -0.1, -d), (w, 0, d), floor),
            block((-w, h, -d), (w, h + 0.1, d), white),
            block((-w, 0, -d - 0.1), (w, h, -d), wall),
            block((-w, 0, d), (w, h, d + 0.1), wall),
            block((-w - 0.1, 0, -d), (-w, h, d), wall),
            block((w, 0, -d), (w + 0.1, h, d), wall),
        ]

    def _free(self, x: float, z: float, radius: float, touch: float) -> bool:
        return all(math.hypot(x - a, z - b) > touch * (radius + r) for a, b, r in self._taken)

    def _at_wall(self, furniture: Furniture) -> None:
        rng, radius = self._rng, max(furniture.width, furniture.depth) / 2
        for _ in range(TRIES):
            side, gap = int(rng.integers(4)), rng.uniform(0.0, 0.06) * (rng.random() < 0.6)
            long = self.width if side % 2 == 0 else self.depth
            wall_distance = (self.depth if side % 2 == 0 else self.width) / 2
            along = rng.uniform(-1, 1) * max(long / 2 - furniture.width / 2, 0)
            turn = side * math.pi / 2
            place = matmul(yaw(turn), vec(along, 0, -wall_distance + furniture.depth / 2 + gap))
            if self._free(float(place[0]), float(place[2]), radius, self.furnishing.apart):
                self._taken.append((float(place[0]), float(place[2]), radius))
                self._add(furniture, float(place[0]), float(place[2]), turn)
                return

    def _standing(self, furniture: Furniture) -> None:
        rng, radius = self._rng, max(furniture.width, furniture.depth) / 2
        for _ in range(TRIES):
            x = rng.uniform(-1, 1) * (self.width / 2 - radius - 0.02)
            z = rng.uniform(-1, 1) * (self.depth / 2 - radius - 0.02)
            if self._free(x, z, radius, self.furnishing.apart + 0.05):
                self._taken.append((x, z, radius))
                turn = rng.uniform(0, 2 * math.pi)
                self._add(furniture, x, z, turn)
                if 0.6 < furniture.top < 0.85:
                    self._chairs(furniture, x, z, turn)
                return

    def _chairs(self, table: Furniture, x: float, z: float, turn: float) -> None:
        """Put chairs at a table, some pushed under it."""
        for side in range(4):
            if self._rng.random() < 0.5:
                continue
            reach = (table.depth if side % 2 == 0 else table.width) / 2
            distance = reach + self._rng.uniform(-0.12, 0.35)
            heading = turn + side * math.pi / 2
            seat = chair(self._rng)
            place = matmul(yaw(heading), vec(self._rng.uniform(-0.1, 0.1), 0, distance)) + vec(
                x, 0, z
            )
            inside = abs(place[0]) < self.width / 2 - 0.3 and abs(place[2]) < self.depth / 2 - 0.3
            if inside:
                facing = heading + math.pi + self._rng.uniform(-0.4, 0.4)
                self._add(seat, float(place[0]), float(place[2]), facing)

    def _things(self, furniture: Furniture, pose: Array, turn: float) -> None:
        rng = self._rng
        placed: list[tuple[float, float, float]] = []
        for _ in range(int(rng.integers(0, 8))):
            if self.furnishing.on_tops:
                thing = self._one_of(self.furnishing.on_tops)
            else:
                thing = screen(rng) if rng.random() < 0.2 else clutter(rng)
            r = max(thing.width, thing.depth) / 2
            if 2 * r > min(furniture.width, furniture.depth):
                continue
            for _ in range(TRIES):
                x = rng.uniform(-1, 1) * (furniture.width / 2 - r)
                z = rng.uniform(-1, 1) * (furniture.depth / 2 - r)
                if all(math.hypot(x - a, z - b) > 0.8 * (r + c) for a, b, c in placed):
                    placed.append((x, z, r))
                    at = matmul(pose[:3, :3], vec(x, furniture.top, z)) + pose[:3, 3]
                    facing = turn + rng.uniform(-0.5, 0.5)
                    self._add(thing, float(at[0]), float(at[2]), facing, float(at[1]))
                    break

    def _person(self) -> None:
        rng, look = self._rng, LOOKS[int(self._rng.integers(len(LOOKS)))]
        x = rng.uniform(-1, 1) * (self.width / 2 - 0.6)
        z = rng.uniform(-1, 1) * (self.depth / 2 - 0.6)
        if not self._free(x, z, 0.3, 1.0):
            return
        self._taken.append((x, z, 0.3))
        facing, place = rng.uniform(0, 2 * math.pi), vec(x, 0, z)
        pelvis = place + vec(0, 0.93 * look.height / 1.75, 0)
        hands = hanging_hands(pelvis, facing, look.height, rng.uniform(-0.6, 0.6))
        feet = standing_feet(place, facing, look.height)
        self.count += 1
        self.solids += body(look, Posture(pelvis, facing, feet, hands), self.count)

    def _on_walls(self) -> None:
        """Hang pictures, boards, radiators, and put in doors and windows."""
        rng, kinds = self._rng, self.furnishing
        for _ in range(int(rng.integers(*kinds.many_on_walls))):
            side, thick = int(rng.integers(4)), rng.uniform(0.015, 0.1)
            long = self.width if side % 2 == 0 else self.depth
            wall_distance = (self.depth if side % 2 == 0 else self.width) / 2
            if kinds.on_walls:
                hung = self._one_of(kinds.on_walls)
                along = rng.uniform(-1, 1) * max(long / 2 - hung.width / 2, 0)
                turn = side * math.pi / 2
                place = matmul(yaw(turn), vec(along, 0, -wall_distance + hung.depth / 2))
                self._add(hung, float(place[0]), float(place[2]), turn)
                continue
            w, h = rng.uniform(0.25, 1.4), rng.uniform(0.25, 1.1)
            low = rng.uniform(0.05, max(self.height - h - 0.1, 0.1))
            if rng.random() < 0.3:
                w, h, low = 0.85, 2.05, 0.0
            x = rng.uniform(-1, 1) * max(long / 2 - w / 2, 0)
            stuff: Material = material(rng)
            panel = block(
                (x - w / 2, low, -wall_distance),
                (x + w / 2, low + h, -wall_distance + thick),
                stuff,
            )
            hung = Furniture((panel,), w, thick)
            self._add(hung, 0.0, 0.0, side * math.pi / 2)
