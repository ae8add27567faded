"""Jugglers and the pins that they throw, pass and catch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from scenes.figures import person, room
from scenes.raycaster import Camera, Frame, Part, Sensor

FLIGHT, DWELL = 0.75, 0.33
"""Seconds that a pin is in the air, and in a hand."""
RATE = 30
GRAVITY = 9.81


@dataclass(frozen=True)
class Throw:
    """A pin is held from ``taken`` to ``thrown`` and flies until ``caught`` (seconds).

    ``turn``: how far it has turned before, in radians; it turns ``spins`` times in the air.
    """

    taken: float
    thrown: float
    caught: float
    hand: int
    to: int
    turn: float
    spins: int


class Jugglers:
    """One person, or two who face each other; hand 2 p is the left one of person p."""

    def __init__(self, people: int) -> None:
        if people == 1:
            self.places, self.headings = [np.array([0.1, 0, 2.4])], [np.pi]
        else:
            self.places = [np.array([-1.1, 0, 2.7]), np.array([1.1, 0, 2.7])]
            self.headings = [np.pi / 2 + 0.35, -np.pi / 2 - 0.35]
        self.shift = np.zeros(2)

    def hand(self, number: int, time: float) -> np.ndarray:
        """(3,) where a hand is, on its circle of 0.9 s."""
        who, side = divmod(number, 2)
        heading = self.headings[who]
        ahead = np.array([np.sin(heading), 0, np.cos(heading)])
        right = np.array([ahead[2], 0, -ahead[0]])
        phase = 2 * np.pi * (time / 0.9 + self.shift[who] + (0.5 if side else 0))
        return (
            self.places[who]
            + np.array([0, 1.02 + 0.09 * np.sin(phase), 0])
            + ahead * (0.36 + 0.06 * np.cos(phase))
            + right * (0.3 if side else -0.3)
            + right * 0.09 * np.cos(phase)
        )

    def pin(self, throw: Throw, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Place (3,) and rotation (3, 3) of a pin."""
        if time < throw.thrown:
            at = self.hand(throw.hand, time)
            held = (time - throw.taken) / (throw.thrown - throw.taken)
            angle = throw.turn + 0.4 * np.sin(held * np.pi)
        else:
            seconds, since = throw.caught - throw.thrown, time - throw.thrown
            start, end = self.hand(throw.hand, throw.thrown), self.hand(throw.to, throw.caught)
            speed = (end - start) / seconds
            speed[1] += 0.5 * GRAVITY * seconds
            at = start + speed * since
            at[1] -= 0.5 * GRAVITY * since * since
            angle = throw.turn + 2 * np.pi * throw.spins * (since / seconds)
        heading = self.headings[throw.hand // 2]
        right = np.array([np.cos(heading), 0, -np.sin(heading)])
        spun = Rotation.from_rotvec(-angle * right) * Rotation.from_rotvec(0.9 * right)
        turned = spun.as_matrix()
        return at + np.array([0, 0.06, 0]) + turned @ np.array([0, 0.14, 0]), turned

    def parts(self, time: float, tints) -> list[Part]:
        """The people, who sway a little."""
        parts: list[Part] = []
        sway = [[0.02 * np.sin(time * 2 + who), 0, 0.02 * np.cos(time * 1.7)] for who in (0, 1)]
        for who, place in enumerate(self.places):
            at, swing = place + np.array(sway[who]), 0.2 * np.sin(time)
            arms = [self.hand(2 * who + side, time) for side in (0, 1)]
            parts += person(0, at, self.headings[who], swing, tints[who], arms)
        return parts


def juggling(seed=0, frames=60, pins=3, sensor=None, people=None) -> list[Frame]:
    """Pins 1, 2, ... that people throw who have no label; of odd seeds all of one colour."""
    rng = np.random.default_rng(seed)
    camera = Camera(sensor or Sensor(), room())
    people = people or (1 if pins == 3 else 2)
    tints = [tuple(rng.integers(40, 230, 3)) for _ in range(2)]
    jugglers = Jugglers(people)
    throws = [_throws(rng, people, k, pins, frames / RATE + 2) for k in range(pins)]
    colours = [tints[0] if seed % 2 else tuple(rng.integers(30, 240, 3)) for _ in range(pins)]
    jugglers.shift = rng.random(2)
    out = []
    for time in (i / RATE for i in range(frames)):
        parts: list[Part] = []
        for label, (course, colour) in enumerate(zip(throws, colours, strict=True), start=1):
            throw = next(t for t in course if t.taken <= time < t.caught or t is course[-1])
            parts += _pin(label, *jugglers.pin(throw, time), colour)
        out.append(camera.shoot(parts + jugglers.parts(time, tints), rng))
    return out


def _throws(rng, people: int, k: int, pins: int, end: float) -> list[Throw]:
    """All throws of pin ``k`` of ``pins`` until ``end`` (seconds); each person has two hands."""
    time = -rng.random() * 0.2 - k * (FLIGHT + DWELL) / pins
    at, turn = k % (2 * people), 0.0
    course = []
    while time < end:
        other = (at + 1) % 2 + 2 * (at // 2)
        to = other if people == 1 or rng.random() < 0.4 else (at + 2) % 4
        passed = to // 2 != at // 2
        thrown = time + DWELL
        caught = thrown + FLIGHT * (1.25 if passed else 1.0)
        spins = 1 if rng.random() < 0.75 else 2
        course.append(Throw(time, thrown, caught, at, to, turn, spins))
        time, at, turn = caught, to, turn + 2 * np.pi * spins
    return course


def _pin(label: int, centre: np.ndarray, rotation: np.ndarray, tint) -> list[Part]:
    axis = rotation @ np.array([0, 1.0, 0])
    neck, belly, top = (-0.26, -0.02), (0.0, 0.1), (0.1, 0.22)
    return [
        Part(label, (235, 235, 230), *(centre + axis * h for h in neck), 0.013, 0.02),
        Part(label, tint, *(centre + axis * h for h in belly), 0.028, 0.045, stripe=1.0),
        Part(label, tint, *(centre + axis * h for h in top), 0.045, 0.028),
    ]
