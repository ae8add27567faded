"""Airborne lidar scans of land: terrain, roads, houses, trees, water, vehicles.

Every point has its class, intensity, and the number of its return; a tile is one frame, z up, in
coordinates as far from the origin as in a national grid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.frame import PointFrame
from pointbrush.samples.recording import LabelInfo
from pointbrush.samples.reproducible import (
    cos,
    draw_exponential,
    draw_normal,
    matmul,
    norms,
    sin,
    sines,
)

Array = NDArray[np.float64]
Rng = np.random.Generator

GROUND, VEGETATION, BUILDING, WATER, VEHICLE = 1, 2, 3, 4, 5
CLASSES = (
    LabelInfo(GROUND, "ground", "ground", "#b08d57"),
    LabelInfo(VEGETATION, "vegetation", "vegetation", "#3f9b46"),
    LabelInfo(BUILDING, "building", "building", "#d0503c"),
    LabelInfo(WATER, "water", "water", "#3b7dd8"),
    LabelInfo(VEHICLE, "vehicle", "vehicle", "#b44fd0"),
)
CORNER = (482_000.0, 5_361_000.0, 240.0)
"""Metres; the lower corner of the first tile."""
NOISE = 0.025
"""Metres; standard deviation of a point, each way."""
BANK = 12.0
"""Metres from water over which the ground rises to its height."""
INSIDE = 0.8
"""Metres that a pulse goes into a crown on average."""
ASPHALT, GRASS, POND, LEAVES = 0.22, 0.5, 0.07, 0.38
"""Intensities, shares of the strongest."""


@dataclass(frozen=True, slots=True)
class AerialOptions:
    """Contents of a tile."""

    edge: float = 130.0
    """Metres."""
    pulses: float = 8.0
    """Pulses on a square metre."""
    houses: int = 60
    trees: int = 200
    cars: int = 34
    tilt: float = 0.22
    """Horizontal metres of a pulse per metre down; greater values show more of walls."""

    def check(self) -> None:
        """Raise BadInputError for numbers out of range."""
        if not (10 <= self.edge <= 2000 and 0 < self.pulses <= 100):
            raise BadInputError("edge, pulses: expected 10 to 2000 m and up to 100 on a square m")
        if min(self.houses, self.trees, self.cars, self.tilt) < 0:
            raise BadInputError("houses, trees, cars, tilt: expected 0 or more")


@dataclass(slots=True, eq=False)
class _Points:
    """Returns so far; ``fields`` per point: x, y, z, class, intensity, return, of how many."""

    rows: list[Array]

    def add(
        self,
        xyz: Array,
        kind: int,
        intensity: Array,
        number: float | Array = 1,
        many: float | Array = 1,
    ) -> None:
        """Add returns (n, 3): the ``number``-th of ``many`` of their pulses."""
        n = len(xyz)
        beside = [np.broadcast_to(v, n) for v in (kind, intensity, number, many)]
        self.rows.append(np.column_stack([xyz, *beside]))


class Land:
    """A tile from a seed: its terrain, and the objects on it."""

    def __init__(self, seed: int, options: AerialOptions) -> None:
        self.options = options
        rng = self._rng = np.random.default_rng([seed, 83])
        steep = rng.uniform(0.3, 1.6)
        self._waves = [
            (draw_normal(rng, 1, 2) / rng.uniform(18, 60), rng.uniform(0, 6.28),
             steep * rng.uniform(0.3, 2.0))
            for _ in range(5)
        ]  # fmt: skip
        edge = options.edge
        self.slope = draw_normal(rng, 0.015, 2)
        self.roads = [self._road(k) for k in range(3)]
        self._bend = (rng.uniform(0.2, 0.8) * edge, rng.uniform(4, 11), rng.uniform(0, 6.28))
        self._wide = rng.uniform(3.0, 8.0)
        self._pond = (*rng.uniform(0.15, 0.85, 2) * edge, rng.uniform(6, 14))

    def _road(self, k: int) -> tuple[Array, Array, float]:
        rng, edge = self._rng, self.options.edge
        angle = draw_normal(rng, 0.15) + (math.pi / 2 if k % 2 else 0.0)
        middle = rng.uniform(0.2, 0.8, 2) * edge
        return middle, np.array([cos(angle), sin(angle)]), rng.uniform(2.5, 5.0)

    def height(self, xy: Array) -> Array:
        """Return the height (n,) of the ground at places (n, 2), with level water."""
        z = 12.0 + matmul(xy, self.slope)
        for wave, phase, high in self._waves:
            z = z + high * sines(matmul(xy, wave) + phase)
        near = np.clip(self.shore(xy) / BANK, 0.0, 1.0)
        return np.asarray(z * near + self._level(xy) * (1 - near))

    def _level(self, xy: Array) -> Array:
        return np.full(len(xy), 10.5) + 0.004 * xy[:, 1]

    def shore(self, xy: Array) -> Array:
        """Metres (n,) to the shore, below 0 on water."""
        at, swing, phase = self._bend
        river = np.abs(xy[:, 0] - at - swing * sines(xy[:, 1] / 23 + phase)) - self._wide
        x, y, radius = self._pond
        pond = norms((xy - (x, y)) * (1, 0.7)) - radius
        return np.asarray(np.minimum(river, pond))

    def on_road(self, xy: Array) -> NDArray[np.bool_]:
        """Return whether each of the places (n, 2) is on a road."""
        found = np.zeros(len(xy), np.bool_)
        for middle, way, wide in self.roads:
            found |= np.abs(matmul(xy - middle, np.array([-way[1], way[0]]))) < wide
        return found


@dataclass(frozen=True, slots=True)
class _House:
    """A house on a rectangle: ``middle`` (2,), ``turn``, half lengths, eaves and rise, metres."""

    middle: Array
    turn: float
    half: Array
    base: float
    eaves: float
    rise: float
    hipped: bool
    tone: float

    def own(self, xy: Array) -> Array:
        """Places (n, 2) along its axes."""
        c, s = cos(self.turn), sin(self.turn)
        return matmul(xy - self.middle, np.array([[c, -s], [s, c]]))

    def roof(self, own: Array) -> Array:
        """Height (n,) of the roof."""
        height_share = 1 - np.abs(own[:, 1]) / self.half[1]
        if self.hipped:
            height_share = np.minimum(
                height_share, (self.half[0] - np.abs(own[:, 0])) / self.half[1]
            )
        return np.asarray(self.base + self.eaves + self.rise * np.clip(height_share, 0, 1))


def aerial_tile(seed: int, options: AerialOptions | None = None) -> PointFrame:
    """Return a tile: ``label`` are its classes, ``other`` number of the return and of returns.

    Raises BadInputError for the options.
    """
    options = options or AerialOptions()
    options.check()
    land, rng = Land(seed, options), np.random.default_rng([seed, 89])
    edge = options.edge
    xy = rng.uniform(0, edge, (int(edge * edge * options.pulses), 2))
    ground = land.height(xy)
    points, free = _Points([]), np.ones(len(xy), np.bool_)
    taken: list[tuple[Array, float]] = []
    for _ in range(options.houses):
        _house(land, rng, xy, free, points, taken)
    for _ in range(options.cars):
        _car(land, rng, xy, ground, free, points, taken)
    for _ in range(options.trees):
        _tree(land, rng, xy, ground, free, points, taken)
    _floor(land, rng, xy, ground, free, points)
    return _frame(np.concatenate(points.rows), seed, edge, rng)


def _frame(rows: Array, seed: int, edge: float, rng: Rng) -> PointFrame:
    xyz = rows[:, :3] + draw_normal(rng, NOISE, (len(rows), 3))
    inside = ((xyz[:, :2] > 0) & (xyz[:, :2] < edge)).all(axis=1)
    rows, xyz = rows[inside], xyz[inside]
    along_strips = np.floor(xyz[:, 0] / 2) * 1e6 + xyz[:, 1]  # in the order of the flight
    order = np.argsort(along_strips, kind="stable")
    rows, xyz = rows[order], xyz[order] + CORNER + np.array([seed % 10, seed // 10, 0]) * edge
    strength = np.clip(rows[:, 4] * rng.uniform(0.8, 1.2, len(rows)), 0, 1)
    return PointFrame(
        np.round(xyz, 3),
        intensity=(strength * 4095).astype(np.float32),
        label=rows[:, 3].astype(np.uint16),
        other={
            "return_number": rows[:, 5].astype(np.uint8),
            "number_of_returns": rows[:, 6].astype(np.uint8),
        },
    )


def _clear(taken: list[tuple[Array, float]], at: Array, radius: float) -> bool:
    return all(math.hypot(*(at - other)) > radius + r for other, r in taken)


def _house(
    land: Land, rng: Rng, xy: Array, free: NDArray[np.bool_], points: _Points,
    taken: list[tuple[Array, float]],
) -> None:  # fmt: skip
    half = np.sort(rng.uniform(3.0, 8.5, 2))[::-1]
    if rng.random() < 0.12:
        half = half * rng.uniform(1.4, 2.2)
    middle = rng.uniform(0, land.options.edge, 2)
    around = middle + float(half.max()) * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1], [0, 0]])
    if land.shore(around).min() < 3 or land.on_road(around).any():
        return
    if not _clear(taken, middle, float(half.max()) * 1.1):
        return
    taken.append((middle, float(half.max())))
    flat = rng.random() < 0.3
    house = _House(
        middle, rng.uniform(0, math.pi), half, float(land.height(middle[None])[0]),
        rng.uniform(2.6, 9.0), 0.0 if flat else rng.uniform(0.3, 0.9) * float(half[1]),
        bool(rng.random() < 0.4), rng.uniform(0.12, 0.7),
    )  # fmt: skip
    own = house.own(xy)
    on = (np.abs(own) < house.half).all(axis=1) & free
    free[on] = False
    z = house.roof(own[on])
    if rng.random() < 0.5:  # a chimney, or a box on a flat roof
        place = house.half * rng.uniform(-0.6, 0.6, 2)
        z = np.where((np.abs(own[on] - place) < 0.6).all(axis=1), z + rng.uniform(0.6, 1.4), z)
    points.add(np.column_stack([xy[on], z]), BUILDING, np.full(int(on.sum()), house.tone))
    _walls(land, rng, house, points)


def _walls(land: Land, rng: Rng, house: _House, points: _Points) -> None:
    """Add the points of the two walls that face the flight."""
    c, s = cos(house.turn), sin(house.turn)
    to_plan = np.array([[c, s], [-s, c]])
    for axis in (0, 1):
        side = 1.0 if rng.random() < 0.5 else -1.0
        area = 2 * house.half[1 - axis] * house.eaves
        n = int(area * land.options.pulses * land.options.tilt * abs((c, s)[axis]))
        own = np.empty((n, 2))
        own[:, axis] = side * house.half[axis]
        own[:, 1 - axis] = rng.uniform(-1, 1, n) * house.half[1 - axis]
        z = house.base + house.eaves * rng.uniform(0, 1, n)
        wall = np.column_stack([matmul(own, to_plan) + house.middle, z])
        points.add(wall, BUILDING, np.full(n, 0.3))


def _car(
    land: Land, rng: Rng, xy: Array, ground: Array, free: NDArray[np.bool_], points: _Points,
    taken: list[tuple[Array, float]],
) -> None:  # fmt: skip
    middle, way, wide = land.roads[int(rng.integers(len(land.roads)))]
    aside = np.array([-way[1], way[0]])
    at = middle + way * rng.uniform(-1, 1) * land.options.edge
    at = at + aside * rng.choice([-1, 1]) * rng.uniform(0.25, 0.8) * wide
    if land.shore(at[None])[0] < 4 or not _clear(taken, at, 2.6):
        return
    taken.append((at, 2.4))
    lorry = rng.random() < 0.15
    long, broad = (rng.uniform(3.2, 5), 1.2) if lorry else (rng.uniform(1.9, 2.5), 0.9)
    high = rng.uniform(2.6, 3.6) if lorry else rng.uniform(1.4, 1.7)
    own = matmul(xy - at, np.column_stack([way, aside]))
    on = (np.abs(own[:, 0]) < long) & (np.abs(own[:, 1]) < broad) & free
    free[on] = False
    front = own[on, 0] > 0.45 * long
    top = np.where(front & (not lorry), 0.6 * high, high)
    points.add(
        np.column_stack([xy[on], ground[on] + top]), VEHICLE,
        rng.uniform(0.1, 0.9) * np.ones(int(on.sum())),
    )  # fmt: skip


def _tree(
    land: Land, rng: Rng, xy: Array, ground: Array, free: NDArray[np.bool_], points: _Points,
    taken: list[tuple[Array, float]],
) -> None:  # fmt: skip
    at, bush = rng.uniform(0, land.options.edge, 2), rng.random() < 0.3
    radius = rng.uniform(0.6, 1.6) if bush else rng.uniform(1.5, 5.0)
    if land.shore(at[None])[0] < 1 or land.on_road(at[None])[0]:
        return
    if not _clear(taken, at, 0.6 * radius):
        return
    base = float(land.height(at[None])[0])
    low = 0.0 if bush else rng.uniform(1.0, 4.0)
    high = low + radius * (rng.uniform(0.9, 1.8) if bush else rng.uniform(1.6, 3.4))
    offset = norms(xy - at) / radius
    on = np.flatnonzero((offset < 1) & free)
    free[on] = False
    half = (high - low) / 2 * np.sqrt(1 - offset[on] ** 2)
    top, foot = base + (low + high) / 2 + half, base + (low + high) / 2 - half
    first = top - draw_exponential(rng, INSIDE, len(on))
    met = first > foot
    second = first - 0.5 - draw_exponential(rng, 1.5, len(on))
    between = met & (second > foot) & (rng.random(len(on)) < 0.6)
    through = ~met | (rng.random(len(on)) < 0.45)
    many = met.astype(int) + between + through
    kept = many > 0
    every: tuple[NDArray[Any], ...] = (on, first, second, met, between, through, many)
    on, first, second, met, between, through, many = (each[kept] for each in every)
    tone = LEAVES / np.maximum(many, 1) + draw_normal(rng, 0.05, len(on))
    leaves = ((met, first, np.ones(len(on))), (between, second, met + np.ones(len(on))))
    for which, z, number in leaves:
        rows = np.column_stack([xy[on], z])[which]
        points.add(rows, VEGETATION, tone[which], number[which], many[which])
    soil = np.column_stack([xy[on], ground[on]])[through]
    points.add(soil, GROUND, GRASS / many[through], many[through], many[through])


def _floor(
    land: Land, rng: Rng, xy: Array, ground: Array, free: NDArray[np.bool_], points: _Points
) -> None:
    """Add the remaining points: roads, grass, and water, which returns few pulses."""
    wet = land.shore(xy) < 0
    kept = free & (~wet | (rng.random(len(xy)) < 0.35))
    for kind, which in ((WATER, wet), (GROUND, ~wet)):
        on = kept & which
        road = land.on_road(xy[on])
        tone = np.full(int(on.sum()), POND) if kind == WATER else np.where(road, ASPHALT, GRASS)
        z = ground[on] + (0.0 if kind == WATER else 1.0) * draw_normal(rng, 0.02, int(on.sum()))
        points.add(np.column_stack([xy[on], z]), kind, tone)
