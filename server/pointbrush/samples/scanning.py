"""Single frames of furnished rooms with the instance of every point.

``room_view``: one view of a depth camera; ``room_scan``: many views joined and thinned, as a
scanned room comes from a phone or a scanner.  Rooms are of random size; every piece of furniture
and every thing has its own label.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pointbrush.frame import DepthCamera, PointFrame
from pointbrush.samples.furniture import (
    AT_WALLS,
    STANDING,
    Furniture,
    chair,
    clutter,
    colour,
    material,
    screen,
)
from pointbrush.samples.geometry import Array, Field, dot3, norm3, rigid, unit, vec, yaw
from pointbrush.samples.lighting import Lamp, Lights, ambient_light, lamp_light
from pointbrush.samples.people import body
from pointbrush.samples.posture import LOOKS, Posture, hanging_hands, standing_feet
from pointbrush.samples.render import Caster, Solid, block
from pointbrush.samples.sensor import KINECT, Sensor, develop, measure, pixel_rays
from pointbrush.samples.textures import Material, matte

TRIES = 25
"""Places that are tried for a piece of furniture."""
WIDE = DepthCamera(width=288, height=216, fx=190.0, fy=190.0, cx=143.5, cy=107.5)
"""The camera that is carried through a room to scan it."""
SCAN_NOISE = 0.004
"""Metres; standard deviation of a scan's points along the view."""


@dataclass(eq=False)
class Interior:
    """A room from a seed: ``solids`` with labels from 1, the shell has label 0; y up, metres.

    ``width``, ``depth`` of the floor, whose middle is the origin, and ``height``.
    """

    seed: int
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
        for _ in range(int(rng.integers(4, 9))):
            self._at_wall(AT_WALLS[int(rng.integers(len(AT_WALLS)))](rng))
        for _ in range(int(rng.integers(5, 12))):
            self._standing(STANDING[int(rng.integers(len(STANDING)))](rng))
        for _ in range(int(rng.integers(0, 3))):
            self._person()
        self._on_walls()

    def _add(self, furniture: Furniture, x: float, z: float, turn: float, y: float = 0.0) -> None:
        self.count += 1
        pose = rigid(yaw(turn), vec(x, y, z))
        self.solids += furniture.placed(pose, self.count)
        if furniture.top:
            self._things(furniture, pose, turn)

    def _shell(self) -> None:
        w, d, h, rng = self.width / 2, self.depth / 2, self.height, self._rng
        wall, floor, white = matte(colour(rng)), material(rng), matte("#e6e3dc")
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
            away = (self.depth if side % 2 == 0 else self.width) / 2
            along = rng.uniform(-1, 1) * max(long / 2 - furniture.width / 2, 0)
            turn = side * math.pi / 2
            place = yaw(turn) @ vec(along, 0, -away + furniture.depth / 2 + gap)
            if self._free(float(place[0]), float(place[2]), radius, 0.85):
                self._taken.append((float(place[0]), float(place[2]), radius))
                self._add(furniture, float(place[0]), float(place[2]), turn)
                return

    def _standing(self, furniture: Furniture) -> None:
        rng, radius = self._rng, max(furniture.width, furniture.depth) / 2
        for _ in range(TRIES):
            x = rng.uniform(-1, 1) * (self.width / 2 - radius - 0.02)
            z = rng.uniform(-1, 1) * (self.depth / 2 - radius - 0.02)
            if self._free(x, z, radius, 0.9):
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
            away = reach + self._rng.uniform(-0.12, 0.35)
            heading = turn + side * math.pi / 2
            seat = chair(self._rng)
            place = yaw(heading) @ vec(self._rng.uniform(-0.1, 0.1), 0, away) + vec(x, 0, z)
            inside = abs(place[0]) < self.width / 2 - 0.3 and abs(place[2]) < self.depth / 2 - 0.3
            if inside:
                facing = heading + math.pi + self._rng.uniform(-0.4, 0.4)
                self._add(seat, float(place[0]), float(place[2]), facing)

    def _things(self, furniture: Furniture, pose: Array, turn: float) -> None:
        rng = self._rng
        placed: list[tuple[float, float, float]] = []
        for _ in range(int(rng.integers(0, 8))):
            thing = screen(rng) if rng.random() < 0.2 else clutter(rng)
            r = max(thing.width, thing.depth) / 2
            if 2 * r > min(furniture.width, furniture.depth):
                continue
            for _ in range(TRIES):
                x = rng.uniform(-1, 1) * (furniture.width / 2 - r)
                z = rng.uniform(-1, 1) * (furniture.depth / 2 - r)
                if all(math.hypot(x - a, z - b) > 0.8 * (r + c) for a, b, c in placed):
                    placed.append((x, z, r))
                    at = pose[:3, :3] @ vec(x, furniture.top, z) + pose[:3, 3]
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
        rng = self._rng
        for _ in range(int(rng.integers(2, 8))):
            side, thick = int(rng.integers(4)), rng.uniform(0.015, 0.1)
            long = self.width if side % 2 == 0 else self.depth
            away = (self.depth if side % 2 == 0 else self.width) / 2
            w, h = rng.uniform(0.25, 1.4), rng.uniform(0.25, 1.1)
            low = rng.uniform(0.05, max(self.height - h - 0.1, 0.1))
            if rng.random() < 0.3:
                w, h, low = 0.85, 2.05, 0.0
            x = rng.uniform(-1, 1) * max(long / 2 - w / 2, 0)
            stuff: Material = material(rng)
            panel = block((x - w / 2, low, -away), (x + w / 2, low + h, -away + thick), stuff)
            hung = Furniture((panel,), w, thick)
            self._add(hung, 0.0, 0.0, side * math.pi / 2)


@dataclass(frozen=True, slots=True, eq=False)
class Labelled:
    """A frame with the ``instance`` (N,) uint16 of each point, 0 for floor, walls and ground.

    ``T_room_frame`` (4, 4) stands the frame on its floor, y up.
    """

    frame: PointFrame
    instance: NDArray[np.uint16]
    T_room_frame: Array


def look_at(eye: Array, target: Array) -> Array:
    """``T_room_camera`` (4, 4) of a level camera at ``eye`` (x right, y down, z forward)."""
    z = unit(target - eye)
    x = unit(np.cross(z, vec(0, 1, 0)))
    return rigid(np.column_stack([x, np.cross(z, x), z]), eye)


def room_view(seed: int, camera: DepthCamera = KINECT, noise: float = 1.0) -> Labelled:
    """Return what a depth camera sees of a furnished room, camera coordinates."""
    interior = Interior(seed)
    rng = np.random.default_rng([seed, 43])
    w, d = interior.width / 2, interior.depth / 2
    eye = vec(rng.uniform(-0.8, 0.8) * w, rng.uniform(0.9, 1.9), rng.uniform(-0.8, 0.8) * d)
    aim = _somewhere(interior.solids, eye, rng, 3.5)
    return view_of(interior.solids, look_at(eye, aim), camera, Sensor(noise=noise), rng)


def _somewhere(solids: list[Solid], eye: Array, rng: np.random.Generator, reach: float) -> Array:
    """Return the place of a random labelled solid, one within reach if there is any."""
    places = np.array([s.pose[:3, 3] for s in solids if s.label])
    if len(places) == 0:
        return np.asarray(eye + vec(1, -0.3, 0))
    away = np.linalg.norm(places - eye, axis=1)
    near = np.flatnonzero((away < reach) & (away > 0.9))
    chosen = int(rng.choice(near)) if len(near) else int(away.argmin())
    return np.asarray(places[chosen] + rng.normal(0, 0.15, 3))


def view_of(
    solids: list[Solid],
    T_room_camera: Array,
    camera: DepthCamera,
    sensor: Sensor,
    rng: np.random.Generator,
) -> Labelled:
    """Render a depth camera's view of solids in the light of one lamp, camera coordinates."""
    caster = Caster(camera, T_room_camera, pixel_rays(camera))
    seen = caster.empty()
    caster.cast(solids, seen)
    s = caster.shade(solids, seen)
    lights = Lights((Lamp(vec(rng.uniform(-2, 2), 2.2, rng.uniform(-2, 2)), (2.2, 2.1, 2.0), 3),))
    light = np.zeros((3, seen.depth.size), np.float32)
    light[:, s.pixel] = ambient_light(lights, s) + lamp_light(lights.lamps[0], s, caster.eye)
    shape = (camera.height, camera.width)
    amplitude, label = np.zeros(seen.depth.size, np.float32), np.zeros(seen.depth.size, np.uint16)
    rays: Field = caster.room_rays[:, s.pixel]
    amplitude[s.pixel] = s.infrared * np.maximum(-dot3(s.normal, rays) / norm3(rays), 0)
    label[s.pixel] = s.label
    scan = measure(
        sensor,
        seen.depth.reshape(shape),
        label.reshape(shape),
        amplitude.reshape(shape),
        rng,
    )
    picture = develop(sensor, light.reshape(3, *shape), rng)
    pixel = np.flatnonzero(scan.depth > 0)
    xyz = (caster.rays[:, pixel] * scan.depth.ravel()[pixel]).T
    frame = PointFrame(
        np.ascontiguousarray(xyz, np.float32),
        picture.reshape(-1, 3)[pixel],
        viewpoint=np.zeros(3),
        camera=camera,
        pixel=pixel.astype(np.uint32),
    )
    return Labelled(frame, scan.label.ravel()[pixel], T_room_camera)


def room_scan(seed: int, points: int = 200_000, views: int = 14) -> Labelled:
    """Return a furnished room scanned from many views, about ``points`` points, y up."""
    interior = Interior(seed)
    rng = np.random.default_rng([seed, 47])
    w, d = interior.width / 2 - 0.4, interior.depth / 2 - 0.4
    sensor = Sensor(noise=0.6, nearest=0.3, farthest=9.0)
    xyz, rgb, label = [], [], []
    for k in range(views):
        angle = 2 * math.pi * k / views + rng.uniform(-0.2, 0.2)
        eye = vec(w * math.cos(angle), rng.uniform(1.3, 1.8), d * math.sin(angle))
        aim = vec(-eye[0], rng.uniform(0.1, 1.2), -eye[2]) * rng.uniform(0.1, 0.8)
        if k % 2:
            aim = _somewhere(interior.solids, eye, rng, 5.0)
        made = view_of(interior.solids, look_at(eye, aim), WIDE, sensor, rng)
        T = made.T_room_frame
        room = made.frame.xyz @ T[:3, :3].T + T[:3, 3]
        xyz.append(room + rng.normal(0, SCAN_NOISE, room.shape))
        rgb.append(made.frame.rgb)
        label.append(made.instance)
    every, colours = np.concatenate(xyz), np.concatenate([c for c in rgb if c is not None])
    kept = _thinned(every, points, rng)
    frame = PointFrame(every[kept].astype(np.float32), colours[kept])
    return Labelled(frame, np.concatenate(label)[kept], np.eye(4))


def _thinned(xyz: Array, points: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Numbers of about ``points`` points, spread evenly: the first of each small cube."""
    size = 0.008
    order = rng.permutation(len(xyz))
    while True:
        cube = np.floor(xyz[order] / size).astype(np.int64) + 2**19
        key = (cube[:, 0] << 40) | (cube[:, 1] << 20) | cube[:, 2]
        first = np.unique(key, return_index=True)[1]
        if len(first) <= points:
            return np.sort(order[first])
        size *= 1.15
