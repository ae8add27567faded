"""A drive along a street: turns of a lidar on a car, with the label of every vehicle."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.frame import PointFrame
from pointbrush.samples.geometry import Array, rigid, vec
from pointbrush.samples.render import Solid
from pointbrush.samples.reproducible import matmul
from pointbrush.samples.sensor import Spinner, spin
from pointbrush_samples.scanning import Labelled
from pointbrush_samples.street import Rng, Street, vehicle

LIDAR = Spinner(farthest=80.0)
HEIGHT = 1.73
"""Metres of the lidar above the road."""
START = 15.0
"""Metres along the street at which the drive begins, towards -z."""
HALF_ROAD = 7.0
"""Metres from the middle of the road to its kerb at least."""
LANE = 0.3
"""Share of half the road from its middle to the middle of a lane."""
SPEEDS = (4.0, 11.0)
"""Range of the speed of driving vehicles, metres a second."""
CLEAR_M = 14.0
"""Metres between vehicles of a lane at least."""
CLEAR_SECONDS = 3.0
"""Seconds for which the vehicles keep this distance."""


@dataclass(frozen=True, slots=True)
class Vehicle:
    """A vehicle: its ``lane`` -1 or 1, ``z`` metres at first, ``speed`` metres a second along z."""

    lane: int
    z: float
    speed: float

    def clear_of(self, other: Vehicle) -> bool:
        """Return whether it keeps its distance from another vehicle in its lane."""
        gaps = [self.z - other.z]
        gaps.append(gaps[0] + CLEAR_SECONDS * (self.speed - other.speed))
        apart = min(map(abs, gaps)) > CLEAR_M and gaps[0] * gaps[1] > 0
        return self.lane != other.lane or apart


class DrivenStreet(Street):
    """A street with known vehicles: ``parked`` labels, ``driving`` label -> vehicle; the sensor is
    on ``own``."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng([seed, 61])
        self.own = Vehicle(1, START, -rng.uniform(*SPEEDS))
        self.parked: set[int] = set()
        self.driving: dict[int, Vehicle] = {}
        super().__init__(seed)

    def at(self, t: float) -> list[Solid]:
        """Return all solids ``t`` seconds after the start."""
        way = {label: vec(0, 0, car.speed * t) for label, car in self.driving.items()}
        return [
            replace(s, pose=matmul(rigid(np.eye(3), way[s.label]), s.pose)) if s.label in way else s
            for s in self.solids
        ]

    def _parked(self, side: int) -> None:
        before = self.count
        super()._parked(side)
        self.parked |= set(range(before + 1, self.count + 1))

    def _ground(self) -> None:
        """Widen the road first, for two lanes between parked vehicles."""
        wider = max(self.road, HALF_ROAD) - self.road
        self.road, self._walk = self.road + wider, self._walk + wider
        super()._ground()

    def _crossing(self) -> None:
        """Put no cars across the road, which driving vehicles use."""

    def _driving(self) -> None:
        rng: Rng = self._rng
        for _ in range(int(rng.integers(2, 6))):
            lane = 1 if rng.random() < 0.5 else -1
            car = Vehicle(lane, rng.uniform(-40, 40), -lane * rng.uniform(*SPEEDS))
            if all(car.clear_of(other) for other in (self.own, *self.driving.values())):
                body, turn = vehicle(rng), math.pi * (lane > 0)
                x = lane * LANE * self.road
                self._add(body.solids, x, car.z, turn, model=body.kind)
                self.driving[self.count] = car


def drive(seed: int, frames: int, rate: float = 10.0) -> list[Labelled]:
    """Return ``frames`` turns of a lidar on a car, y up, the sensor at the viewpoint.

    Labels are of vehicles; ``T_room_frame`` is the sensor's pose.
    """
    street = DrivenStreet(seed)
    is_labelled = np.zeros(street.count + 1, np.bool_)
    is_labelled[[*street.parked, *street.driving]] = True
    made = []
    for i in range(frames):
        eye: Array = vec(LANE * street.road, HEIGHT, START + street.own.speed * i / rate)
        turn = spin(LIDAR, eye, street.at(i / rate), np.random.default_rng([seed, 67, i]))
        xyz = (turn.xyz - eye).astype(np.float32)
        frame = PointFrame(xyz, intensity=turn.intensity, viewpoint=np.zeros(3))
        label: NDArray[np.uint16] = np.where(is_labelled[turn.label], turn.label, 0).astype(
            np.uint16
        )
        made.append(Labelled(frame, label, rigid(np.eye(3), eye)))
    return made
