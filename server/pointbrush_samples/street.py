"""Streets as a spinning lidar sees them: cars, people, poles, signs, trees, walls, kerbs."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pointbrush.frame import PointFrame
from pointbrush.samples.geometry import Array, along, rigid, vec, yaw
from pointbrush.samples.render import Solid, block, disc, egg, rod
from pointbrush.samples.reproducible import draw_normal, matmul, sines
from pointbrush.samples.sensor import Spinner, spin
from pointbrush.samples.shapes import Cylinder
from pointbrush.samples.textures import Material, matte
from pointbrush_samples.furniture import colour
from pointbrush_samples.scanning import Labelled

LENGTH = 75.0
"""Metres of street before and behind the sensor."""
FOLIAGE = 1.0
"""Roughness from which on rays enter a solid."""
SPINNERS = (
    Spinner(),
    Spinner(rings=32, lowest=-30, highest=10, steps=1800),
    Spinner(rings=64, lowest=-25, highest=15, steps=1024, noise=0.03),
    Spinner(rings=40, lowest=-25, highest=12, steps=1300, farthest=180),
    Spinner(rings=100, lowest=-24, highest=8, steps=1800),
)
Rng = np.random.Generator


class Body(NamedTuple):
    """A vehicle's class (car, van, truck), its length in metres, and its solids, along z."""

    kind: str
    length: float
    solids: list[Solid]


class Street:
    """A street from a seed: ``solids``, labels from 1; ground, kerbs and houses have label 0.

    ``objects``: the class that a detector learns (car, van, truck, pedestrian, cyclist) and
    ``T_room_object`` of a label, at first.
    """

    def __init__(self, seed: int) -> None:
        rng = self._rng = np.random.default_rng([seed, 53])
        self.solids: list[Solid] = []
        self.objects: dict[int, tuple[str, Array]] = {}
        self.count = 0
        self.road = rng.uniform(3.5, 9.0)
        self._walk = self.road + rng.uniform(1.5, 6.0)
        self._ground()
        for side in (-1, 1):
            self._houses(side)
            self._parked(side)
            self._pavement(side)
        self._driving()
        self._crossing()

    def _add(
        self,
        solids: list[Solid],
        x: float,
        z: float,
        turn: float,
        y: float = 0.0,
        model: str = "",
    ) -> None:
        self.count += 1
        T = rigid(yaw(turn), vec(x, y, z))
        if model:
            self.objects[self.count] = model, T
        for s in solids:
            self.solids.append(
                Solid(s.shape, matmul(T, s.pose), s.material, s.scale, self.count, s.roughness)
            )

    def _ground(self) -> None:
        asphalt, stone, grass = matte("#55565a"), matte("#8f8c84"), matte("#4c5f38")
        r, w, far = self.road, self._walk, 160.0
        self.solids += [
            block((-r, -1, -far), (r, 0, far), asphalt),
            block((r, -1, -far), (w, 0.13, far), stone),
            block((-w, -1, -far), (-r, 0.13, far), stone),
            block((w, -1, -far), (far, 0.1, far), grass),
            block((-far, -1, -far), (-w, 0.1, far), grass),
        ]

    def _houses(self, side: int) -> None:
        rng, z = self._rng, -LENGTH
        while z < LENGTH:
            long, facade = rng.uniform(6, 22), self._walk + rng.uniform(0.5, 9.0)
            kind, stuff = rng.random(), matte(colour(rng))
            if kind < 0.55:
                self._block(side, (facade, facade + 12), (z, z + long), rng.uniform(4, 16), stuff)
                for k in range(int(long / 3)):
                    a = z + 1 + 3 * k
                    out = facade - rng.uniform(-0.05, 0.3)
                    self._block(side, (out, facade + 0.1), (a, a + 1.2), 2.2, stuff, 0.9)
            elif kind < 0.8:
                self._block(
                    side, (facade, facade + 0.3), (z, z + long), rng.uniform(0.8, 2.2), stuff
                )
            z += long + rng.uniform(0.0, 6.0)

    def _block(
        self,
        side: int,
        x: tuple[float, float],
        z: tuple[float, float],
        height: float,
        stuff: Material,
        low: float = 0.0,
    ) -> None:
        (x0, x1), (z0, z1) = sorted(side * each for each in x), z
        self.solids.append(block((x0, low, z0), (x1, low + height, z1), stuff))

    def _parked(self, side: int) -> None:
        rng, z = self._rng, -LENGTH + self._rng.uniform(0, 8)
        full = rng.uniform(0.1, 0.8)
        while z < LENGTH:
            body = vehicle(rng)
            if rng.random() < full:
                x = side * (self.road - rng.uniform(0.9, 1.3))
                turn = math.pi * rng.integers(2) + draw_normal(rng, 0.03)
                self._add(body.solids, x, z, turn, model=body.kind)
            z += body.length + rng.uniform(0.5, 3.0)

    def _driving(self) -> None:
        rng = self._rng
        for _ in range(int(rng.integers(1, 8))):
            z = rng.uniform(-LENGTH, LENGTH)
            if abs(z) < 7:
                continue
            side = 1 if rng.random() < 0.5 else -1
            body = cyclist(rng) if rng.random() < 0.25 else vehicle(rng).solids
            self._add(body, side * rng.uniform(0.2, 0.5) * self.road, z, math.pi * (side > 0))

    def _crossing(self) -> None:
        """Put cars across the street, as at a junction or in a car park."""
        rng = self._rng
        if rng.random() < 0.5:
            z = rng.uniform(10, 30) * (1 if rng.random() < 0.5 else -1)
            for k in range(int(rng.integers(2, 7))):
                x = (k - 3) * rng.uniform(2.3, 2.8)
                turn = math.pi / 2 + draw_normal(rng, 0.05)
                self._add(vehicle(rng).solids, x, z, turn)

    def _pavement(self, side: int) -> None:
        rng = self._rng
        for _ in range(int(rng.integers(10, 30))):
            x = side * rng.uniform(self.road + 0.4, self._walk + 2)
            z, y, kind = rng.uniform(-LENGTH, LENGTH), 0.13, rng.random()
            if kind < 0.35:
                group = int(rng.integers(1, 4))
                for k in range(group):
                    body, along = pedestrian(rng), z + draw_normal(rng, 0.3)
                    turn = rng.uniform(0, 6)
                    self._add(body, x + 0.6 * k, along, turn, y, "pedestrian")
            elif kind < 0.6:
                self._add(tree(rng), x, z, 0.0, y)
            elif kind < 0.75:
                self._add(pole(rng), x, z, rng.uniform(0, 6), y)
            elif kind < 0.85:
                self._add(bush(rng), x, z, rng.uniform(0, 6), y)
            elif kind < 0.92:
                self._add(cyclist(rng), x, z, rng.uniform(0, 6), y, "cyclist")
            else:
                w, h = rng.uniform(0.25, 0.7), rng.uniform(0.6, 1.4)
                box = [block((-w, 0, -w), (w, h, w), matte(colour(rng)))]
                self._add(box, x, z, 0.0, y)


def vehicle(rng: Rng) -> Body:
    """Make a car, a van or a lorry, its front towards +z."""
    kind, paint, glass = rng.random(), matte(colour(rng)), matte("#20242a", grain=0.02)
    tyre = matte("#18181a")
    if kind < 0.75:
        long, w, h = rng.uniform(3.6, 5.0), rng.uniform(0.82, 0.95), rng.uniform(1.4, 1.75)
        belt, nose, tail = h * 0.58, rng.uniform(0.2, 0.28), rng.uniform(0.02, 0.2)
        parts = [
            block((-w, 0.22, -long / 2), (w, belt, long / 2), paint),
            block(
                (-w + 0.1, belt, -long / 2 + tail * long),
                (w - 0.1, h, long / 2 - nose * long),
                glass,
            ),
        ]
    elif kind < 0.9:
        long, w, h = rng.uniform(4.6, 6.5), rng.uniform(0.95, 1.05), rng.uniform(1.9, 2.7)
        parts = [
            block((-w, 0.3, -long / 2), (w, h, long * 0.32), paint),
            block((-w, 0.3, long * 0.32), (w, h * 0.6, long / 2), paint),
        ]
    else:
        long, w, h = rng.uniform(7, 12), rng.uniform(1.15, 1.3), rng.uniform(2.7, 3.6)
        gap = rng.uniform(0.0, 0.6)
        parts = [
            block((-w, 0.5, -long / 2), (w, h, long * 0.28), paint),
            block((-w, 0.4, long * 0.28 + gap), (w, h * 0.85, long / 2), matte(colour(rng))),
            block((-w * 0.5, 0.4, long * 0.2), (w * 0.5, 0.9, long * 0.4), tyre),
        ]
    turn = along(vec(0, 0, 0), vec(1, 0, 0), vec(0, 0, 1))[:3, :3]
    for x in (-w + 0.12, w - 0.12):
        for z in (-long * 0.3, long * 0.3):
            parts.append(
                Solid(Cylinder(), rigid(turn, vec(x, 0.32, z)), tyre, vec(0.32, 0.12, 0.32))
            )
    return Body("car" if kind < 0.75 else "van" if kind < 0.9 else "truck", long, parts)


def pedestrian(rng: Rng) -> list[Solid]:
    """Return a standing or walking person, of rods and eggs."""
    s, stride = rng.uniform(0.7, 1.08), rng.uniform(-0.3, 0.3)
    shirt, trousers, skin = matte(colour(rng)), matte(colour(rng)), matte("#c99b7d")
    parts = [
        egg(vec(0, 1.62, 0) * s, (0.1 * s, 0.13 * s, 0.11 * s), skin),
        rod(
            vec(0, 0.95, 0) * s, vec(0, 1.36, 0) * s, (0.17 * s, 0.19 * s), shirt, flat=(0.7, None)
        ),
        rod(vec(-0.1, 0.9, 0) * s, vec(-0.1, 0.06, stride) * s, (0.09 * s, 0.06 * s), trousers),
        rod(vec(0.1, 0.9, 0) * s, vec(0.1, 0.06, -stride) * s, (0.09 * s, 0.06 * s), trousers),
        rod(vec(-0.23, 1.4, 0) * s, vec(-0.28, 0.85, -stride) * s, (0.055 * s, 0.045 * s), shirt),
        rod(vec(0.23, 1.4, 0) * s, vec(0.28, 0.85, stride) * s, (0.055 * s, 0.045 * s), shirt),
    ]
    if rng.random() < 0.3:
        parts.append(egg(vec(0, 1.2, -0.2) * s, (0.16 * s, 0.24 * s, 0.12 * s), shirt))
    return parts


def cyclist(rng: Rng) -> list[Solid]:
    """Return a person on a bicycle or motorbike, or the bicycle alone, along z."""
    frame, tall = matte(colour(rng)), 0.34
    turn = along(vec(0, 0, 0), vec(1, 0, 0), vec(0, 0, 1))[:3, :3]
    parts = [
        Solid(
            Cylinder(),
            rigid(turn, vec(0, tall, z)),
            frame,
            vec(tall, rng.uniform(0.02, 0.07), tall),
        )
        for z in (-0.52, 0.52)
    ]
    parts += [
        rod(vec(0, 0.4, -0.4), vec(0, 0.85, 0.1), (0.04, 0.04), frame),
        rod(vec(0, 0.35, 0.5), vec(0, 1.0, 0.4), (0.03, 0.03), frame),
        rod(vec(-0.28, 1.0, 0.36), vec(0.28, 1.0, 0.36), (0.02, 0.02), frame),
    ]
    if rng.random() < 0.8:
        shirt = matte(colour(rng))
        parts += [
            rod(vec(0, 0.95, -0.2), vec(0, 1.4, 0.05), (0.17, 0.19), shirt, flat=(0.8, None)),
            egg(vec(0, 1.66, 0.12), (0.11, 0.14, 0.12), matte("#c99b7d")),
            rod(vec(-0.1, 0.9, -0.15), vec(-0.12, 0.3, 0.1), (0.09, 0.06), shirt),
            rod(vec(0.1, 0.9, -0.15), vec(0.12, 0.4, 0.05), (0.09, 0.06), shirt),
            rod(vec(-0.2, 1.35, 0.05), vec(-0.25, 1.02, 0.35), (0.05, 0.04), shirt),
            rod(vec(0.2, 1.35, 0.05), vec(0.25, 1.02, 0.35), (0.05, 0.04), shirt),
        ]
    return parts


def pole(rng: Rng) -> list[Solid]:
    """Return a lamp post, a traffic sign or a post."""
    h, r, steel = rng.uniform(0.8, 7.0), rng.uniform(0.04, 0.15), matte(colour(rng))
    parts = [disc((0, 0, 0), r, h, steel)]
    kind = rng.random()
    if kind < 0.4 and h > 2:
        s = rng.uniform(0.25, 0.5)
        parts.append(block((-s, h - 2 * s, 0.05), (s, h, 0.09), matte("#d8d4cc")))
    elif kind < 0.7 and h > 4:
        parts.append(rod(vec(0, h, 0), vec(rng.uniform(0.8, 2.2), h + 0.3, 0), (r, r), steel))
    return parts


def tree(rng: Rng) -> list[Solid]:
    """Return a tree: a trunk and a crown that rays enter."""
    h, r = rng.uniform(1.5, 3.5), rng.uniform(0.08, 0.3)
    bark, leaf = matte("#5b4a3a"), matte("#4f6b38", grain=0.3)
    parts = [rod(vec(0, 0, 0), vec(draw_normal(rng, 0.15), h + 1, 0), (r, r * 0.7), bark)]
    size = rng.uniform(0.8, 2.2)
    for _ in range(int(rng.integers(3, 8))):
        at = vec(*draw_normal(rng, size * 0.5, 3)) + vec(0, h + size, 0)
        a, b, c = rng.uniform(0.5, 1.0, 3) * size
        parts.append(egg(at, (a, b, c), leaf, roughness=FOLIAGE))
    return parts


def bush(rng: Rng) -> list[Solid]:
    """Return a bush or a piece of a hedge."""
    leaf, size = matte("#45602f", grain=0.3), rng.uniform(0.4, 1.0)
    return [
        egg(vec(0.8 * size * k, size * 0.6, 0), (size, size * 0.8, size), leaf, roughness=FOLIAGE)
        for k in range(int(rng.integers(1, 6)))
    ]


def street(seed: int) -> Labelled:
    """Return one turn of a lidar on a car in a street, y up, the sensor at the viewpoint."""
    made = Street(seed)
    rng = np.random.default_rng([seed, 59])
    eye = vec(rng.uniform(-0.4, 0.4) * made.road, rng.uniform(1.6, 2.2), rng.uniform(-5, 5))
    turn = spin(SPINNERS[int(rng.integers(len(SPINNERS)))], eye, made.solids, rng)
    xyz = _hilly(turn.xyz, rng) - eye
    frame = PointFrame(xyz.astype(np.float32), intensity=turn.intensity, viewpoint=np.zeros(3))
    T = np.eye(4)
    T[:3, 3] = eye
    return Labelled(frame, turn.label, T)


def _hilly(xyz: Array, rng: Rng) -> Array:
    """Lift points (N, 3) by gentle hills, everything with the ground under it."""
    lifted = xyz.copy()
    for _ in range(3):
        wave = draw_normal(rng, 1, 2) / rng.uniform(12, 40)
        height, phase = rng.uniform(0.02, 0.4), rng.uniform(0, 6)
        lifted[:, 1] += height * sines(matmul(xyz[:, [0, 2]], wave) + phase)
    return lifted
