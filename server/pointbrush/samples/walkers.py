"""The walking scene: people who walk to and fro at different distances and hide each other."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.samples.geometry import UP, Array, smoothstep, vec, wobble, yaw
from pointbrush.samples.people import body, shadow_balls
from pointbrush.samples.posture import LOOKS, Foot, Look, Posture, hanging_hands
from pointbrush.samples.recording import LabelInfo, Moment
from pointbrush.samples.room import LivingRoom
from pointbrush.samples.sensor import tripod

LANES = ((-2.1, 0.0, 1.05), (-2.75, 0.05, 1.25), (-3.32, -0.45, 1.1), (-3.9, 0.25, 0.55))
"""Each lane's z, middle x and half length, metres."""
STANCE = 0.6
"""Share of a stride during which a foot stands."""
COLORS = ("#4e79ff", "#ff9a3c", "#52c46a", "#c562d8")


@dataclass(frozen=True, slots=True)
class WalkingOptions:
    """Options of a walking recording: ``people`` 1 to 4; ``pace`` multiplies their speed."""

    people: int = 3
    pace: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """Flat loop on the floor round (``x``, ``z``), walked at ``rate`` radians a second.

    ``half`` its length and ``width`` its breadth from the middle, metres, breadth signed by the
    sense; ``turn`` radians of its long way off the room's x.
    """

    x: float
    z: float
    half: float
    width: float
    turn: float
    rate: float
    phase: float
    sway: Array

    @staticmethod
    def drawn(
        x: float,
        z: float,
        half: float,
        width: float,
        turn: float,
        pace: float,
        rng: np.random.Generator,
    ) -> Loop:
        """Draw the sense, the rate and where it begins."""
        sense = 1.0 if rng.random() < 0.5 else -1.0
        rate = pace * rng.uniform(0.85, 1.1) / half
        phase = rng.uniform(0, 2 * math.pi)
        return Loop(x, z, half, width * sense, turn, rate, phase, rng.uniform(0, 2 * math.pi, 2))

    def place(self, t: float) -> Array:
        """(3,) where the person is on the floor."""
        angle = self.phase + self.rate * t
        along, across = self.half * math.sin(angle), self.width * math.cos(angle)
        drift = 0.06 * wobble(t, self.sway, (4.1, 6.7))
        c, s = math.cos(self.turn), math.sin(self.turn)
        return vec(
            self.x + c * along + s * drift + s * across,
            0,
            self.z + c * drift - s * along + c * across,
        )


class Walk:
    """One person's way: a loop, strides counted along it.

    ``posture(t)`` -> the body at time ``t``.
    """

    def __init__(
        self, look: Look, loop: Loop, seconds: float, pace: float, rng: np.random.Generator
    ) -> None:
        self.look, self._size = look, look.height / 1.75
        self.place = loop.place
        self._gaze = rng.uniform(0, 2 * math.pi, 2)
        self._stride = 1.28 * self._size * math.sqrt(pace)
        self._times = np.arange(-0.1, seconds + 0.2, 0.01)
        places = np.array([self.place(t) for t in self._times])
        steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
        self._walked = np.concatenate([[0.0], np.cumsum(steps)]) + rng.uniform(0, 2)

    def posture(self, t: float) -> Posture:
        """Return the body in mid-stride."""
        here = self.place(t)
        ahead = self.place(t + 0.05) - self.place(t - 0.05)
        heading = math.atan2(ahead[0], ahead[2])
        speed = min(1.0, math.hypot(ahead[0], ahead[2]) / 0.1 / 0.7)
        cycle = float(np.interp(t, self._times, self._walked)) / self._stride
        swing = 2 * math.pi * cycle
        bob = 0.018 * math.cos(2 * swing) * speed
        pelvis = here + UP * ((0.925 + bob) * self._size)
        pelvis = pelvis + yaw(heading) @ vec(0.02 * math.sin(swing), 0, 0)
        feet = (
            self._foot(here, heading, cycle, 1.0, speed),
            self._foot(here, heading, cycle + 0.5, -1.0, speed),
        )
        hands = hanging_hands(
            pelvis, heading, self.look.height, -0.8 * speed * math.cos(swing - 0.3)
        )
        gaze = here + yaw(heading + 0.4 * wobble(t, self._gaze, (2.9, 4.3))) @ vec(0, 1.5, 2)
        return Posture(
            pelvis,
            heading,
            feet,
            hands,
            lean=0.045,
            twist=0.10 * math.cos(swing) * speed,
            gaze=gaze,
            breath=math.sin(2 * math.pi * t / 3.1),
            elbows=vec(0.25, -0.35, -1.0),
        )

    def _foot(self, here: Array, heading: float, cycle: float, side: float, speed: float) -> Foot:
        """Return a foot: still on the floor in stance, then swung forward."""
        u = cycle % 1.0
        half = STANCE * self._stride / 2 * (0.35 + 0.65 * speed)
        if u < STANCE:
            forward, lift = half * (1 - 2 * u / STANCE), 0.0
            pitch = (
                0.6 * max(0.0, u / STANCE - 0.7) / 0.3 - 0.25 * max(0.0, 0.15 - u / STANCE) / 0.15
            )
        else:
            s = (u - STANCE) / (1 - STANCE)
            forward, lift = half * (2 * smoothstep(s) - 1), 0.05 * math.sin(math.pi * s)
            pitch = 0.6 * (1 - smoothstep(s * 1.4)) - 0.25 * smoothstep(s * 2 - 1)
        pitch *= 0.2 + 0.8 * speed
        height = 0.085 * self._size + lift + 0.16 * max(0.0, math.sin(pitch))
        ankle = here + yaw(heading) @ vec(side * 0.085, height, forward - 0.02)
        return Foot(ankle, heading + side * 0.08, pitch)


class WalkingScene(LivingRoom):
    """See ``recording.Scene``."""

    def __init__(self, seed: int, seconds: float, options: WalkingOptions) -> None:
        if not 1 <= options.people <= len(LANES):
            raise BadInputError(f"people: expected 1 to {len(LANES)}, got {options.people}")
        if not 0.3 <= options.pace <= 2:
            raise BadInputError(f"pace: expected 0.3 to 2, got {options.pace}")
        rng = np.random.default_rng([seed, 11])
        super().__init__(seed, tripod(1.35, 5.0))
        order = rng.permutation(len(LOOKS))
        self._walks = []
        for k, (z, x, half) in zip(order[: options.people], LANES, strict=False):
            loop = Loop.drawn(x, z, half, 0.17, 0.0, options.pace, rng)
            self._walks.append(Walk(LOOKS[int(k)], loop, seconds, options.pace, rng))

    @property
    def labels(self) -> list[LabelInfo]:
        """See Scene."""
        return [
            LabelInfo(p + 1, f"person {p + 1}", "person", COLORS[p])
            for p in range(len(self._walks))
        ]

    def at(self, t: float) -> Moment:
        """See Scene; people are not rigid, so there are no poses."""
        solids, balls = [], []
        for p, walk in enumerate(self._walks):
            posture = walk.posture(t)
            solids += body(walk.look, posture, p + 1)
            balls += shadow_balls(posture)
        return Moment(solids, balls, {})
