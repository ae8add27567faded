"""Traffic with known boxes: parked, driving and turning vehicles, walkers and riders.

Boxes are amodal: they contain the whole object, including parts that the lidar never sees.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from pointbrush.frame import PointFrame
from pointbrush.geometry.oriented_box import BoxPose, OrientedBox
from pointbrush.geometry.quaternions import quaternion_of
from pointbrush.samples.geometry import Array, inverse, rigid, vec, yaw
from pointbrush.samples.render import Solid
from pointbrush.samples.reproducible import cos, matmul, norm, norms, sin
from pointbrush.samples.sensor import spin
from pointbrush.samples.shapes import Ball, Box, RoundCone
from pointbrush_samples.driving import HEIGHT, LANE, LIDAR, START, DrivenStreet
from pointbrush_samples.scanning import Labelled
from pointbrush_samples.street import cyclist, pedestrian, vehicle

AXLE = 0.28
"""Share of a vehicle's length from its middle back to the axle that does not steer."""
CLEAR_M = 4.5
"""Least metres between the middle of a turning, walking or riding object and all other objects."""
CLEAR_SECONDS = (0.0, 1.0, 2.0, 3.0)
"""Seconds after the start at which the objects keep this distance."""
TRIES = 100
"""Places that are tried for each turning, walking or riding object."""
BOX_AXES = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
"""``R_box_object``: axes x left, y up, z ahead → axes x ahead, y left, z up."""


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """A path: ``T_room_object`` at first, metres and radians a second; ``axle`` metres behind the
    middle of the object is the point that moves straight ahead."""

    start: Array
    speed: float
    turning: float = 0.0
    axle: float = 0.0

    def at(self, t: float) -> Array:
        """Compute ``T_room_object`` after ``t`` seconds."""
        back = vec(0, 0, -self.axle)
        angle = self.turning * t
        if abs(angle) < 1e-9:
            moved = vec(0, 0, self.speed * t)
        else:
            radius = self.speed / self.turning
            moved = radius * vec(1 - cos(angle), 0, sin(angle))
        turned = yaw(angle)
        step = rigid(turned, back + moved - matmul(turned, back))
        return matmul(self.start, step)


class Traffic(DrivenStreet):
    """A driven street with turning, walking and riding objects: ``ways`` of all moving labels."""

    def __init__(self, seed: int) -> None:
        self.ways: dict[int, Way] = {}
        super().__init__(seed)
        for label, car in self.driving.items():
            T = self.objects[label][1]
            self.ways[label] = Way(T, abs(car.speed))
        self._turning()
        self._walking()

    def place(self, label: int, t: float) -> Array:
        """Compute ``T_room_object`` of a label after ``t`` seconds."""
        way = self.ways.get(label)
        return self.objects[label][1] if way is None else way.at(t)

    def at(self, t: float) -> list[Solid]:
        """See DrivenStreet."""
        moved = {
            label: matmul(way.at(t), inverse(self.objects[label][1]))
            for label, way in self.ways.items()
        }
        return [
            replace(s, pose=matmul(moved[s.label], s.pose)) if s.label in moved else s
            for s in self.solids
        ]

    def _turning(self) -> None:
        rng = self._rng
        for _ in range(int(rng.integers(2, 5))):
            body = vehicle(rng)
            speed, side = rng.uniform(3, 7), 1 if rng.random() < 0.5 else -1
            for _ in range(TRIES):
                x, z = rng.uniform(-0.5, 0.5) * self.road, START + rng.uniform(-35, 10)
                T = rigid(yaw(rng.uniform(0, 2 * math.pi)), vec(x, 0, z))
                turning = side * speed / rng.uniform(7, 20)
                if self._put(body.kind, body.solids, Way(T, speed, turning, AXLE * body.length)):
                    break

    def _walking(self) -> None:
        rng = self._rng
        for _ in range(int(rng.integers(4, 9))):
            rides = rng.random() < 0.3
            body, kind = (cyclist(rng), "cyclist") if rides else (pedestrian(rng), "pedestrian")
            speed = rng.uniform(3, 6) if rides else rng.uniform(0.8, 1.8)
            for _ in range(TRIES):
                x, z = rng.uniform(-0.8, 0.8) * self.road, START + rng.uniform(-25, 10)
                T = rigid(yaw(rng.uniform(0, 2 * math.pi)), vec(x, 0, z))
                if self._put(kind, body, Way(T, speed)):
                    break

    def _put(self, kind: str, solids: list[Solid], way: Way) -> bool:
        """Add an object if it keeps its distance from all others; return whether it does."""
        for t in CLEAR_SECONDS:
            at = way.at(t)[:3, 3]
            others = [self.place(label, t)[:3, 3] for label in self.objects]
            others.append(vec(LANE * self.road, 0, START + self.own.speed * t))
            if min(norm(other - at) for other in others) < CLEAR_M:
                return False
        self._add(solids, 0, 0, 0, model=kind)
        self.objects[self.count] = kind, way.start
        for number in range(len(self.solids) - len(solids), len(self.solids)):
            solid = self.solids[number]
            self.solids[number] = replace(solid, pose=matmul(way.start, solid.pose))
        self.ways[self.count] = way
        return True


@dataclass(frozen=True, slots=True, eq=False)
class TrueTraffic:
    """``frames`` with the label of every point, classes and true ``boxes`` of the labels, in all
    frames, and the labels that move (``moving``)."""

    frames: list[Labelled]
    kinds: Mapping[int, str]
    boxes: Mapping[int, OrientedBox]
    moving: frozenset[int]


def traffic(seed: int, frames: int, rate: float = 10.0) -> TrueTraffic:
    """Make ``frames`` turns of a lidar on a car among traffic, y up, the sensor at the origin.

    Labels are of the objects; ``T_room_frame`` is the sensor's pose.
    """
    street, made = Traffic(seed), []
    is_labelled = np.zeros(street.count + 1, np.bool_)
    is_labelled[list(street.objects)] = True
    eyes = [
        vec(LANE * street.road, HEIGHT, START + street.own.speed * i / rate) for i in range(frames)
    ]
    for i, eye in enumerate(eyes):
        turn = spin(LIDAR, eye, street.at(i / rate), np.random.default_rng([seed, 71, i]))
        frame = PointFrame(
            (turn.xyz - eye).astype(np.float32), intensity=turn.intensity, viewpoint=np.zeros(3)
        )
        label = np.where(is_labelled[turn.label], turn.label, 0).astype(np.uint16)
        made.append(Labelled(frame, label, rigid(np.eye(3), eye)))
    boxes = {label: _box(street, label, eyes, rate) for label in street.objects}
    kinds = {label: kind for label, (kind, _) in street.objects.items()}
    return TrueTraffic(made, kinds, boxes, frozenset(street.ways))


def _box(street: Traffic, label: int, eyes: list[Array], rate: float) -> OrientedBox:
    T_object_room = inverse(street.objects[label][1])
    parts = [_bounds(s, matmul(T_object_room, s.pose)) for s in street.solids if s.label == label]
    low = np.min([part[0] for part in parts], axis=0)
    high = np.max([part[1] for part in parts], axis=0)
    poses = {}
    for i, eye in enumerate(eyes):
        T = street.place(label, i / rate)
        centre = matmul(T[:3, :3], (low + high) / 2) + T[:3, 3] - eye
        poses[i] = BoxPose(centre, quaternion_of(matmul(T[:3, :3], BOX_AXES.T)), "imported")
    return OrientedBox(label, label, matmul(BOX_AXES, high - low), poses, provenance="imported")


def _bounds(solid: Solid, T: Array) -> tuple[Array, Array]:
    """Compute the lower and upper corner (3,) of a solid that is placed by ``T`` (4, 4)."""
    R, scale = T[:3, :3], solid.scale
    if isinstance(solid.shape, Box):
        corners = np.array(list(product((-1, 1), repeat=3))) * scale
        reach = np.abs(matmul(corners, R.T)).max(axis=0)
        return T[:3, 3] - reach, T[:3, 3] + reach
    rows = R * scale  # how far the ball round each axis of the room reaches
    if isinstance(solid.shape, Ball):
        reach = norms(rows)
        return T[:3, 3] - reach, T[:3, 3] + reach
    if isinstance(solid.shape, RoundCone):
        reach = norms(rows)
        top = T[:3, 3] + rows[:, 1] * solid.shape.length
        a, b = reach * solid.shape.ra, reach * solid.shape.rb
        return np.minimum(T[:3, 3] - a, top - b), np.maximum(T[:3, 3] + a, top + b)
    reach = norms(rows[:, [0, 2]]) + np.abs(rows[:, 1])  # a cylinder
    return T[:3, 3] - reach, T[:3, 3] + reach
