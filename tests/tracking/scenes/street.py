"""A street that a lidar on a car drives along, or sees at rest."""

from __future__ import annotations

import numpy as np

from scenes.figures import person
from scenes.raycaster import Camera, Frame, Part, Sensor

LANES = ((-2.0, 9.0), (2.0, -8.0), (5.5, 0.0))
"""Metres beside the sensor, and metres a second, of the lanes: with it, towards it, parked."""
SPEED = 8.0
"""Metres a second of the sensor."""
CARS, WALKERS = 7, 4
LEVEL = np.eye(3)


def street(seed=0, frames=20, ego=True, rate=10.0, beams=48) -> list[Frame]:
    """Cars 1 to 7 and walkers 20 to 23 before a lidar, in its coordinates with poses."""
    rng = np.random.default_rng(seed)
    scenery = _houses_and_posts(rng)
    cars = _cars(rng, frames / rate)
    walkers = [
        (rng.uniform(-7, 7), rng.uniform(4, 20), rng.uniform(-1.4, 1.4)) for _ in range(WALKERS)
    ]
    out = []
    for time in (i / rate for i in range(frames)):
        parts: list[Part] = []
        for label, (x, speed, z) in enumerate(cars, start=1):
            parts += _car(label, np.array([x, 0.55, z + speed * time]))
        for label, (x, z, speed) in enumerate(walkers, start=20):
            at, heading = np.array([x + speed * time, 0, z]), np.pi / 2 * np.sign(speed)
            parts += person(label, at, heading, 8 * time, (90, 90, 200))
        origin = np.array([0, 1.9, SPEED * time if ego else 0.0])
        seen = Camera(Sensor(900, beams, spherical=True, origin=origin), scenery).shoot(parts, rng)
        pose = np.eye(4)
        pose[:3, 3] = origin
        out.append(
            Frame(
                (seen.xyz - origin).astype(np.float32),
                truth=seen.truth,
                intensity=rng.random(len(seen.xyz)).astype(np.float32),
                viewpoint=np.zeros(3),
                pose=pose if ego else None,
            )
        )
    return out


def _houses_and_posts(rng) -> list[Part]:
    """The ground, and along both sides houses and tree trunks, 9 m apart."""
    ground = np.array([0, -0.1, 40.0]), np.array([60, 0.1, 120])
    parts = [Part(0, (90, 90, 90), *ground, rot=LEVEL)]
    for k in range(14):
        side, along = -1 if k % 2 else 1, 9.0 * (k // 2)
        house = np.array([side * rng.uniform(11, 14), 4, along - 20])
        foot = np.array([side * 8.0, 0, along - 18])
        parts.append(Part(0, (150, 120, 100), house, np.array([3, 4, 4.0]), rot=LEVEL))
        parts.append(Part(0, (60, 90, 50), foot, foot + [0, 3, 0], 0.15, 0.12))
    return parts


def _cars(rng, seconds: float) -> list[tuple[float, float, float]]:
    """Lane, speed and place in it of cars that never come closer than 5 m to each other."""
    cars: list[tuple[float, float, float]] = []
    while len(cars) < CARS:
        lane, speed = LANES[len(cars) % 3]
        car = lane, rng.uniform(0.8, 1.2) * speed, rng.uniform(-12, 30)
        if not any(_meet(car, other, seconds) for other in cars):
            cars.append(car)
    return cars


def _meet(one, other, seconds: float) -> bool:
    gaps = [one[2] - other[2] + t * (one[1] - other[1]) for t in (0.0, seconds)]
    return one[0] == other[0] and (min(np.abs(gaps)) < 5.0 or gaps[0] * gaps[1] < 0)


def _car(label: int, centre: np.ndarray) -> list[Part]:
    red = (120, 40, 40)
    body, cabin = np.array([0.9, 0.4, 2.1]), np.array([0.75, 0.3, 1.1])
    return [
        Part(label, red, centre, body, rot=LEVEL),
        Part(label, red, centre + [0, 0.65, -0.2], cabin, rot=LEVEL),
    ]
