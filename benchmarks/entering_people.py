"""A room that people enter close to the camera and leave, while others enter after them.

The first person stands in the picture's border in frame 0, cut off by it, crosses and leaves at the
other side.  Some seconds later a second one in similar clothes enters, or in a third of the
recordings the first one comes back; a third one passes behind them, and some turn their backs.  The
camera looks as the one of the crowd does.

In recordings of the kind ``stepping-out`` the first person steps out of the picture for a moment,
comes back at the same place and crosses, before the second one enters.  In those of the kind
``entering-part`` only a small part of the first person is in the picture in frame 0.

Seeds 1 to 12 are for tuning; seeds from 101 on are for checks only.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pointbrush.samples.crowd import CROWD_LOOKS, HEIGHT, PITCH
from pointbrush.samples.geometry import Array, vec, wobble
from pointbrush.samples.people import body, shadow_balls
from pointbrush.samples.posture import Look
from pointbrush.samples.recording import LabelInfo, Moment, Recording
from pointbrush.samples.reproducible import norms
from pointbrush.samples.room import LivingRoom
from pointbrush.samples.sensor import tripod
from pointbrush.samples.walkers import COLORS, Walk

RATE = 5.0
"""Frames a second."""
BORDER_TAN = 0.69
"""Tangent of the picture's side, from its middle."""
DEPTHS = (0.8, 1.7)
"""Metres from the camera to the people who come close."""
SPEEDS = (0.5, 0.9)
"""Metres a second."""
GAP_SECONDS = (1.0, 3.0)
"""Seconds between one person's leaving and the next one's coming."""
SHADES = ("#b8402f", "#a8452f", "#3f6b4a", "#47704a", "#6a5a8c", "#62568a")
"""Shirts, in pairs that look alike."""
RETURNING = 1 / 3
"""Share of the recordings in which the first person comes back."""
REACH_M = 0.7
"""Metres beside the border at which nothing of a person is seen."""
PART_M = (0.2, 0.35)
"""Metres beside the border at which a small part of a person is seen."""
OUT_M = (0.45, 0.8)
"""Metres beside the border to which a person steps out."""
OUT_SECONDS = (0.0, 0.4)
"""Seconds for which they stay there."""


@dataclass(frozen=True, slots=True, eq=False)
class Passage:
    """A way from ``start`` to ``end`` (x, z; metres), walked at ``speed`` m/s from ``time`` on."""

    start: Array
    end: Array
    time: float
    speed: float
    sway: Array

    @property
    def seconds(self) -> float:
        """Return the seconds from start to end."""
        return float(norms((self.end - self.start)[None])[0]) / self.speed

    def place(self, t: float) -> Array:
        """(3,) where the person is on the floor; they wait at both ends."""
        share = min(max((t - self.time) / self.seconds, 0.0), 1.0)
        x, z = self.start + share * (self.end - self.start)
        return vec(x, 0, z + 0.04 * wobble(t, self.sway, (4.1, 6.7)))


@dataclass(frozen=True, slots=True, eq=False)
class Return:
    """A way ``out`` of the picture, and another one ``back`` into it."""

    out: Passage
    back: Passage

    def place(self, t: float) -> Array:
        """(3,) where the person is on the floor."""
        return (self.out if t < self.back.time else self.back).place(t)


class EnteringScene(LivingRoom):
    """See ``recording.Scene``."""

    def __init__(self, seed: int, seconds: float, kind: str = "entering") -> None:
        rng = np.random.default_rng([seed, 41])
        super().__init__(seed, tripod(HEIGHT, PITCH))
        looks, ways = _looks(rng), _ways(rng)
        self._walks = [
            Walk(look, way, seconds, 1.0, rng)  # type: ignore[arg-type]
            for look, way in zip(looks, ways, strict=True)
        ]
        if kind == "entering-part":
            ways = [_further_out(ways[0], rng), *ways[1:]]
            self._walks[0] = Walk(looks[0], ways[0], seconds, 1.0, rng)  # type: ignore[arg-type]
        if kind == "stepping-out":
            out = _stepping_out(ways[0], rng)
            after = ways[1].time - ways[0].seconds
            later = replace(ways[1], time=out.back.time + out.back.seconds + after)
            self._walks[:2] = [
                Walk(look, way, seconds, 1.0, rng)  # type: ignore[arg-type]
                for look, way in ((looks[0], out), (looks[1], later))
            ]
        elif rng.random() < RETURNING:
            again = Return(ways[0], ways[1])
            self._walks[0] = Walk(looks[0], again, seconds, 1.0, rng)  # type: ignore[arg-type]
            del self._walks[1]

    @property
    def labels(self) -> list[LabelInfo]:
        """See Scene."""
        count = len(self._walks)
        return [LabelInfo(p + 1, f"person {p + 1}", "person", COLORS[p]) for p in range(count)]

    def at(self, t: float) -> Moment:
        """See Scene."""
        solids, balls = [], []
        for label, walk in enumerate(self._walks, start=1):
            posture = walk.posture(t)
            solids += body(walk.look, posture, label)
            balls += shadow_balls(posture)
        return Moment(solids, balls, {})


def _looks(rng: np.random.Generator) -> Sequence[Look]:
    """Draw the looks of two people in similar shirts, and of a third."""
    pair = 2 * int(rng.integers(len(SHADES) // 2))
    order = rng.permutation(len(CROWD_LOOKS))
    first = replace(CROWD_LOOKS[order[0]], shirt=SHADES[pair], pattern="plain")
    trousers = first.trousers if rng.random() < 0.5 else "#30343e"
    second = replace(
        CROWD_LOOKS[order[1]], shirt=SHADES[pair + 1], pattern="plain", trousers=trousers
    )
    return first, second, CROWD_LOOKS[order[2]]


def _ways(rng: np.random.Generator) -> Sequence[Passage]:
    """Draw the ways of the first person, of the one after them and of the one behind."""
    side = 1.0 if rng.random() < 0.5 else -1.0
    depth = rng.uniform(*DEPTHS)
    edge = BORDER_TAN * depth
    speed = rng.uniform(*SPEEDS)
    far = edge + REACH_M
    first = Passage(
        np.array([side * (edge - rng.uniform(-0.1, 0.12)), -depth]),
        np.array([-side * far, -depth - rng.uniform(-0.1, 0.4)]),
        0.0,
        speed,
        rng.uniform(0, 2 * math.pi, 2),
    )
    again = side if rng.random() < 0.5 else -side
    second_depth = rng.uniform(*DEPTHS)
    far = BORDER_TAN * second_depth + REACH_M
    second = Passage(
        np.array([again * far, -second_depth]),
        np.array([-again * far, -second_depth - rng.uniform(-0.1, 0.4)]),
        first.seconds + rng.uniform(*GAP_SECONDS),
        rng.uniform(*SPEEDS),
        rng.uniform(0, 2 * math.pi, 2),
    )
    back = rng.uniform(2.4, 3.2)
    turn = 1.0 if rng.random() < 0.5 else -1.0
    third = Passage(
        np.array([turn * 0.45 * back, -back]),
        np.array([-turn * 0.5 * back, -back]),
        0.0,
        rng.uniform(0.3, 0.6),
        rng.uniform(0, 2 * math.pi, 2),
    )
    return first, second, third


def _stepping_out(way: Passage, rng: np.random.Generator) -> Return:
    """Draw a way out of the picture, at the side where ``way`` starts, and back to its end."""
    side, edge = np.sign(way.start[0]), BORDER_TAN * -way.start[1]
    start, out = (
        np.array([side * (edge + away), way.start[1]])
        for away in (-rng.uniform(0.3, 0.7), rng.uniform(*OUT_M))
    )
    first = replace(way, start=start, end=out)
    return Return(first, replace(way, start=out, time=first.seconds + rng.uniform(*OUT_SECONDS)))


def _further_out(way: Passage, rng: np.random.Generator) -> Passage:
    """Draw a start of a way at which a small part of a person is seen."""
    x, z = way.start
    return replace(way, start=np.array([np.sign(x) * (BORDER_TAN * -z + rng.uniform(*PART_M)), z]))


def entering(seed: int, frames: int, kind: str = "entering") -> Recording:
    """Prepare a recording of ``frames`` frames."""
    scene = EnteringScene(seed, frames / RATE, kind)
    return Recording("Entering", scene, frames, seed, RATE)
