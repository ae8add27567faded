"""The walking scene: people walk to and fro at different distances and occlude each other."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.samples.geometry import UP, Array, rigid, smoothstep, vec, wobble, yaw
from pointbrush.samples.people import body, shadow_balls
from pointbrush.samples.posture import LOOKS, Foot, Look, Posture, hanging_hands
from pointbrush.samples.recording import LabelInfo, Moment
from pointbrush.samples.render import Solid, block, rod
from pointbrush.samples.reproducible import atan2, cos, matmul, norm, norms, sin
from pointbrush.samples.room import LivingRoom
from pointbrush.samples.sensor import tripod
from pointbrush.samples.textures import Material, matte, poster

LANES = ((-2.1, 0.0, 1.05), (-2.75, 0.05, 1.25), (-3.32, -0.45, 1.1), (-3.9, 0.25, 0.55))
"""Each lane's z, middle x and half length, metres."""
STANCE = 0.6
"""Share of a stride during which a foot stands."""
BOX_Z, BOX_XS = -2.44, (-0.35, 0.45)
"""Metres; places of boxes, between the first two lanes."""
COLORS = ("#4e79ff", "#ff9a3c", "#52c46a", "#c562d8")


@dataclass(frozen=True, slots=True)
class WalkingOptions:
    """Options of a walking recording: ``people`` 1 to 4; ``pace`` multiplies their speed; up to 2
    ``boxes`` turn on stands beside their way, near enough for an arm to pass them."""

    people: int = 3
    pace: float = 1.0
    boxes: int = 0


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
        along, across = self.half * sin(angle), self.width * cos(angle)
        drift = 0.06 * wobble(t, self.sway, (4.1, 6.7))
        c, s = cos(self.turn), sin(self.turn)
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
        steps = norms(np.diff(places, axis=0))
        self._walked = np.concatenate([[0.0], np.cumsum(steps)]) + rng.uniform(0, 2)

    def posture(self, t: float) -> Posture:
        """Return the body in mid-stride."""
        place = self.place(t)
        ahead = self.place(t + 0.05) - self.place(t - 0.05)
        heading = atan2(ahead[0], ahead[2])
        speed = min(1.0, norm(ahead) / 0.1 / 0.7)
        cycle = float(np.interp(t, self._times, self._walked)) / self._stride
        swing = 2 * math.pi * cycle
        bob = 0.018 * cos(2 * swing) * speed
        pelvis = place + UP * ((0.925 + bob) * self._size)
        pelvis = pelvis + matmul(yaw(heading), vec(0.02 * sin(swing), 0, 0))
        feet = (
            self._foot(place, heading, cycle, 1.0, speed),
            self._foot(place, heading, cycle + 0.5, -1.0, speed),
        )
        hands = hanging_hands(pelvis, heading, self.look.height, -0.8 * speed * cos(swing - 0.3))
        gaze = place + matmul(
            yaw(heading + 0.4 * wobble(t, self._gaze, (2.9, 4.3))), vec(0, 1.5, 2)
        )
        return Posture(
            pelvis,
            heading,
            feet,
            hands,
            lean=0.045,
            twist=0.10 * cos(swing) * speed,
            gaze=gaze,
            breath=sin(2 * math.pi * t / 3.1),
            elbows=vec(0.25, -0.35, -1.0),
        )

    def _foot(self, place: Array, heading: float, cycle: float, side: float, speed: float) -> Foot:
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
            forward, lift = half * (2 * smoothstep(s) - 1), 0.05 * sin(math.pi * s)
            pitch = 0.6 * (1 - smoothstep(s * 1.4)) - 0.25 * smoothstep(s * 2 - 1)
        pitch *= 0.2 + 0.8 * speed
        height = 0.085 * self._size + lift + 0.16 * max(0.0, sin(pitch))
        ankle = place + matmul(yaw(heading), vec(side * 0.085, height, forward - 0.02))
        return Foot(ankle, heading + side * 0.08, pitch)


@dataclass(frozen=True, slots=True, eq=False)
class TurningBox:
    """A printed box on a stand, at the place ``at`` (3,); ``half`` (3,) of its sides, metres;
    ``rate`` radians a second about the vertical."""

    at: Array
    half: Array
    print_: float
    rate: float
    phase: float

    @staticmethod
    def drawn(x: float, rng: np.random.Generator) -> TurningBox:
        """Draw its size, height and turn."""
        half = rng.uniform(0.07, 0.14, 3) * vec(1.0, 1.4, 1.0)
        at = vec(
            x + rng.uniform(-0.1, 0.1), rng.uniform(0.7, 1.05), BOX_Z + rng.uniform(-0.04, 0.04)
        )
        rate = rng.uniform(0.5, 1.6) * (1.0 if rng.random() < 0.5 else -1.0)
        return TurningBox(at, half, float(rng.integers(1, 90)), rate, rng.uniform(0, 2 * math.pi))

    def stand(self) -> Solid:
        """Return the stand under it."""
        foot, top = self.at * vec(1, 0, 1), self.at - UP * self.half[1]
        return rod(foot, top, (0.015, 0.015), matte("#333333"))

    def pose(self, t: float) -> Array:
        """Return ``T_room_box``."""
        return rigid(yaw(self.phase + self.rate * t), self.at)

    def solids(self, t: float, label: int) -> list[Solid]:
        """Return its two halves, differently printed."""
        x, y, z = self.half
        parts = (
            block((-x, -y, -z), (x, y, 0), self._paper(0)),
            block((-x, -y, 0), (x, y, z), self._paper(9)),
        )
        return [replace(s, pose=matmul(self.pose(t), s.pose), label=label) for s in parts]

    def _paper(self, other: float) -> Material:
        pattern = partial(poster, seed=self.print_ + other, half=(self.half[0], self.half[1]))
        return Material(pattern, 0.6)


class WalkingScene(LivingRoom):
    """See ``recording.Scene``."""

    def __init__(self, seed: int, seconds: float, options: WalkingOptions) -> None:
        if not 1 <= options.people <= len(LANES):
            raise BadInputError(f"people: expected 1 to {len(LANES)}, got {options.people}")
        if not 0 <= options.boxes <= len(BOX_XS):
            raise BadInputError(f"boxes: expected 0 to {len(BOX_XS)}, got {options.boxes}")
        if not 0.3 <= options.pace <= 2:
            raise BadInputError(f"pace: expected 0.3 to 2, got {options.pace}")
        rng = np.random.default_rng([seed, 11])
        super().__init__(seed, tripod(1.35, 5.0))
        order = rng.permutation(len(LOOKS))
        self._walks = []
        for k, (z, x, half) in zip(order[: options.people], LANES, strict=False):
            loop = Loop.drawn(x, z, half, 0.17, 0.0, options.pace, rng)
            self._walks.append(Walk(LOOKS[int(k)], loop, seconds, options.pace, rng))
        self._boxes = [TurningBox.drawn(x, rng) for x in BOX_XS[: options.boxes]]

    def still(self) -> list[Solid]:
        return [*super().still(), *(box.stand() for box in self._boxes)]

    @property
    def labels(self) -> list[LabelInfo]:
        count = len(self._walks)
        found = [LabelInfo(p + 1, f"person {p + 1}", "person", COLORS[p]) for p in range(count)]
        names = [f"box {k + 1}" for k in range(len(self._boxes))]
        return found + [
            LabelInfo(count + 1 + k, name, "thing", "#c9a227") for k, name in enumerate(names)
        ]

    def at(self, t: float) -> Moment:
        """See Scene; people are not rigid, so that only boxes have poses."""
        solids, balls = [], []
        for p, walk in enumerate(self._walks):
            posture = walk.posture(t)
            solids += body(walk.look, posture, p + 1)
            balls += shadow_balls(posture)
        first = len(self._walks) + 1
        for label, box in enumerate(self._boxes, first):
            solids += box.solids(t, label)
            balls.append((box.at, float(box.half.max())))
        return Moment(solids, balls, {n: box.pose(t) for n, box in enumerate(self._boxes, first)})
