"""The table-top scene: a person sits at a table and moves things with both hands.

Things are household things: each a few solids that move as one; a thing's own frame has its
origin at the middle of its base, y up.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.samples.geometry import UP, Array, axis_angle, rigid, smoothstep, vec, wobble, yaw
from pointbrush.samples.lighting import Lamp, Lights
from pointbrush.samples.people import body
from pointbrush.samples.posture import LOOKS, Foot, Posture
from pointbrush.samples.recording import LabelInfo, Moment
from pointbrush.samples.render import Solid, block, disc, egg, rod
from pointbrush.samples.reproducible import cos, inner, matmul, norm, sin
from pointbrush.samples.sensor import tripod
from pointbrush.samples.shapes import Lathe
from pointbrush.samples.textures import (
    Material,
    banded,
    cloth,
    linear,
    matte,
    planks,
    poster,
    shiny,
    striped,
    wallpaper,
    wood,
)

TABLE = 0.72
NEAR, FAR, REACH = -0.86, -1.13, 0.42
"""Range of places for things: z from FAR to NEAR, x from -REACH to REACH."""


@dataclass(frozen=True, slots=True, eq=False)
class Thing:
    """Solids in the thing's own frame, and where a hand takes it: radius and height, metres."""

    name: str
    color: str
    solids: tuple[Solid, ...]
    radius: float
    height: float

    def placed(self, T_room_thing: Array, label: int) -> list[Solid]:
        """Return its solids in the room."""
        return [replace(s, pose=matmul(T_room_thing, s.pose), label=label) for s in self.solids]


def _turned(heights: list[float], radii: list[float], material: Material) -> Solid:
    return Solid(Lathe(heights, radii), np.eye(4), material)


def _mug() -> Thing:
    glaze = shiny("#c23b36", gloss=0.7)
    handle = [
        vec(0.036 + 0.028 * sin(a), 0.048 - 0.03 * cos(a), 0)
        for a in np.linspace(0.15, math.pi - 0.15, 6)
    ]
    ring = [rod(a, b, (0.0065, 0.0065), glaze) for a, b in pairwise(handle)]
    cup = _turned([0, 0.004, 0.09, 0.096, 0.097], [0.032, 0.037, 0.039, 0.039, 0.034], glaze)
    return Thing("mug", "#c23b36", (cup, *ring), 0.04, 0.09)


def _carton() -> Thing:
    print_ = Material(partial(poster, seed=7.0, half=(0.07, 0.3), size=0.09), 0.6)
    return Thing(
        "carton", "#e0a23a", (block((-0.07, 0, -0.026), (0.07, 0.19, 0.026), print_),), 0.05, 0.16
    )


def _ball() -> Thing:
    skin = Material(
        partial(striped, color=linear("#f2e6c9"), second=linear("#2f6fbf"), width=0.03), 0.6, 0.3
    )
    return Thing("ball", "#2f6fbf", (egg(vec(0, 0.042, 0), (0.042,) * 3, skin),), 0.04, 0.06)


def _bottle() -> Thing:
    glass = shiny("#2e7d4f", gloss=0.9, infrared=0.35)
    paper = matte("#e9e2c8", infrared=0.6)
    heights = [0, 0.006, 0.12, 0.155, 0.175, 0.215, 0.23]
    bottle = _turned(heights, [0.028, 0.033, 0.033, 0.026, 0.014, 0.013, 0.011], glass)
    return Thing(
        "bottle", "#2e7d4f", (bottle, disc((0, 0.035, 0), 0.0338, 0.065, paper)), 0.033, 0.14
    )


def _can() -> Thing:
    steel, red, white = linear("#b9bcc0"), linear("#d9772b"), linear("#f2f0ea")
    bands = ((-0.05, steel), (-0.012, red), (0.012, white), (0.05, red), (1.0, steel))
    material = Material(partial(banded, bands=bands), 0.45, 0.6)
    return Thing("can", "#d9772b", (disc((0, 0, 0), 0.033, 0.115, material),), 0.033, 0.09)


def _brick() -> Thing:
    timber = Material(partial(wood, color=linear("#d2a56a")), 0.65)
    return Thing(
        "wooden block",
        "#d2a56a",
        (
            block((-0.05, 0, -0.03), (0.05, 0.05, 0.03), timber),
            block((-0.025, 0.05, -0.03), (0.025, 0.085, 0.03), matte("#4a8c5c")),
        ),
        0.045,
        0.06,
    )


def _car() -> Thing:
    paint, tyre = shiny("#7a3fb0", gloss=0.6), matte("#1d1d1f", infrared=0.25)
    wheels = tuple(
        Solid(d.shape, rigid(axis_angle(vec(1, 0, 0), math.pi / 2), vec(x, 0.02, z)), tyre, d.scale)
        for x in (-0.045, 0.045)
        for z in (-0.032, 0.032)
        for d in (disc((0, 0, 0), 0.02, 0.014, tyre),)
    )
    shell = (
        block((-0.075, 0.018, -0.032), (0.075, 0.05, 0.032), paint),
        block((-0.035, 0.05, -0.028), (0.04, 0.078, 0.028), shiny("#cfd8de", gloss=0.8)),
    )
    return Thing("toy car", "#7a3fb0", (*shell, *wheels), 0.045, 0.06)


def _bowl() -> Thing:
    glaze = shiny("#2a9d96", gloss=0.6)
    heights, radii = [0, 0.004, 0.03, 0.058, 0.06], [0.03, 0.034, 0.06, 0.073, 0.066]
    return Thing("bowl", "#2a9d96", (_turned(heights, radii, glaze),), 0.07, 0.05)


THINGS: tuple[Callable[[], Thing], ...] = (
    _mug,
    _carton,
    _ball,
    _bottle,
    _car,
    _can,
    _brick,
    _bowl,
)
"""Makers of all things."""


@dataclass(frozen=True, slots=True)
class TabletopOptions:
    """Options of a table-top recording.

    ``things`` 1 to 8; ``label_people``: whether the person is a label too.
    """

    things: int = 6
    label_people: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """A hand takes a thing somewhere: reach until ``grasp``, carry until ``release``."""

    thing: int
    begin: float
    grasp: float
    release: float
    start: Array
    end: Array
    turn0: float
    turn1: float
    lift: float
    tilt: float

    def pose(self, t: float) -> Array:
        """(4, 4) ``T_room_thing`` between grasp and release."""
        s = min(max((t - self.grasp) / (self.release - self.grasp), 0.0), 1.0)
        e = smoothstep(s)
        arch = sin(math.pi * s) * sin(math.pi * s)
        place = self.start + (self.end - self.start) * e + UP * (self.lift * arch)
        R = yaw(self.turn0 + (self.turn1 - self.turn0) * e)
        return rigid(matmul(R, axis_angle(vec(1, 0, 0), self.tilt * arch)), place)


class Script:
    """Timetable of places: moves of both hands, without collisions of resting places."""

    def __init__(self, things: list[Thing], seconds: float, rng: np.random.Generator) -> None:
        self._things = things
        self.places: list[Array] = []
        self.turns = [float(rng.uniform(-math.pi, math.pi)) for _ in things]
        for k in range(len(things)):
            self.places.append(self._free(k, rng, None))
        self.moves: tuple[list[Move], list[Move]] = ([], [])
        self._first = (list(self.places), list(self.turns))
        clock = [0.15, 0.55]
        while min(clock) < seconds + 1:
            which = int(np.argmin(clock))
            clock[which] = self._plan(which, clock[which], rng)

    def _free(self, k: int, rng: np.random.Generator, side: float | None) -> Array:
        """Return a place for thing ``k``, apart from all others; ``side``: on this side only."""
        best, clearance = vec(0, TABLE, FAR), -1.0
        for _ in range(60):
            x = rng.uniform(0.02, REACH) * side if side else rng.uniform(-REACH, REACH)
            place = vec(x, TABLE, rng.uniform(FAR, NEAR))
            gaps = [
                norm(place - other) - self._things[k].radius - thing.radius
                for n, (other, thing) in enumerate(zip(self.places, self._things, strict=False))
                if n != k
            ]
            room = min(gaps, default=1.0)
            if room > clearance:
                best, clearance = place, room
            if clearance > 0.05:
                break
        return best

    def _plan(self, which: int, now: float, rng: np.random.Generator) -> float:
        """Plan the next move of a hand (0 left, at positive x); return when it is over."""
        side = 1.0 if which == 0 else -1.0
        other = self.moves[1 - which]
        busy = other[-1].thing if other and other[-1].release > now else -1
        within = [k for k, p in enumerate(self.places) if p[0] * side > -0.08 and k != busy]
        if not within:
            return now + 0.4
        last = self.moves[which][-1].thing if self.moves[which] else -1
        fresh = [k for k in within if k != last] or within
        k = int(rng.choice(fresh))
        grasp = now + rng.uniform(0.4, 0.65)
        release = grasp + rng.uniform(0.7, 1.3)
        end, turn = self._free(k, rng, side), self.turns[k] + rng.uniform(-2.2, 2.2)
        lift = float(rng.uniform(0.05, 0.18))
        if rng.random() < 0.35:
            lift = 0.0 if self._clear(k, end) else 0.22
        tilt = float(rng.uniform(-0.5, 0.5)) if lift > 0.1 else 0.0
        self.moves[which].append(
            Move(k, now, grasp, release, self.places[k], end, self.turns[k], turn, lift, tilt)
        )
        self.places[k], self.turns[k] = end, turn
        return release + rng.uniform(0.1, 0.35)

    def _clear(self, k: int, end: Array) -> bool:
        """Whether thing ``k`` can slide straight to ``end`` without touching another."""
        way = end - self.places[k]
        for n, other in enumerate(self.places):
            if n != k:
                along = inner(other - self.places[k], way) / max(inner(way, way), 1e-9)
                share = min(max(along, 0.0), 1.0)
                gap = norm(self.places[k] + share * way - other)
                if gap < self._things[k].radius + self._things[n].radius + 0.02:
                    return False
        return True

    def pose(self, k: int, t: float) -> Array:
        """(4, 4) ``T_room_thing`` of thing ``k``."""
        done = [m for moves in self.moves for m in moves if m.thing == k and m.grasp <= t]
        if done:
            return max(done, key=lambda m: m.grasp).pose(t)
        return rigid(yaw(self._first[1][k]), self._first[0][k])

    def hand(self, which: int, t: float) -> Array:
        """(3,) where a hand is: at the thing it carries, or on its way."""
        side = 1.0 if which == 0 else -1.0
        rest = vec(side * 0.3, TABLE + 0.05, FAR - 0.08)
        moves = self.moves[which]
        before = [m for m in moves if m.begin <= t]
        if not before:
            return rest
        move = before[-1]
        if t >= move.grasp:
            held = self._grip(move, side, t)
            progress = smoothstep((t - move.release) / 0.4)
            return np.asarray(held + (rest - held) * 0.5 * progress)
        start = rest
        if len(before) > 1:
            start = self.hand(which, before[-1].begin - 1e-6)
        s = smoothstep((t - move.begin) / (move.grasp - move.begin))
        above = UP * (0.10 * sin(math.pi * s))
        return np.asarray(start + (self._grip(move, side, t) - start) * s + above)

    def _grip(self, move: Move, side: float, t: float) -> Array:
        thing = self._things[move.thing]
        place = self.pose(move.thing, min(max(t, move.grasp), move.release))[:3, 3]
        back = vec(side * 0.55, 0, -0.85) * (thing.radius + 0.022)
        return np.asarray(place + back + UP * (thing.height * 0.75))


class TabletopScene:
    """See ``recording.Scene``."""

    def __init__(self, seed: int, seconds: float, options: TabletopOptions) -> None:
        if not 1 <= options.things <= len(THINGS):
            raise BadInputError(f"things: expected 1 to {len(THINGS)}, got {options.things}")
        rng = np.random.default_rng([seed, 21])
        order = rng.permutation(len(THINGS)) if seed else np.arange(len(THINGS))
        self._things = [THINGS[int(k)]() for k in order[: options.things]]
        self._script = Script(self._things, seconds, rng)
        self._look = LOOKS[int(rng.integers(len(LOOKS)))]
        self._person = len(self._things) + 1 if options.label_people else 0
        self._phases = rng.uniform(0, 2 * math.pi, 4)

    @property
    def labels(self) -> list[LabelInfo]:
        result = [
            LabelInfo(k + 1, thing.name, "thing", thing.color)
            for k, thing in enumerate(self._things)
        ]
        if self._person:
            result.append(LabelInfo(self._person, "person 1", "person", "#4e79ff"))
        return result

    @property
    def camera_pose(self) -> Array:
        return tripod(1.32, 28.0)

    @property
    def lights(self) -> Lights:
        return Lights(
            (
                Lamp(vec(-1.6, 1.9, -0.4), (2.4, 2.35, 2.3), 2.0, 0.4),
                Lamp(vec(0.5, 2.2, -1.2), (0.9, 0.72, 0.5), 1.6, 0.15),
            )
        )

    def still(self) -> list[Solid]:
        oak = Material(partial(wood, color=linear("#a9764a")), 0.6, 0.15)
        floor = Material(partial(planks, color=linear("#8f6a48")), 0.5)
        wall = Material(partial(wallpaper, color=linear("#aab6b4")), 0.65)
        mat_ = Material(partial(cloth, color=linear("#4d5a52"), fold=0.2), 0.5)
        parts = [
            block((-3, -0.1, -3.4), (3, 0, 1), floor),
            block((-3, 0, -3.5), (3, 2.6, -3.4), wall),
            block((-0.72, TABLE - 0.03, -1.34), (0.72, TABLE, -0.62), oak),
            block((-0.24, TABLE, -1.12), (0.24, TABLE + 0.003, -0.8), mat_),
            block((-1.6, 0, -3.4), (-0.7, 0.8, -2.95), matte("#d8d2c4")),
            block((-1.5, 0.8, -3.3), (-1.1, 1.1, -3.05), matte("#6b4a3a")),
            disc((0.95, 0, -3.0), 0.22, 0.5, matte("#55645a")),
        ]
        parts += [
            block((x - 0.03, 0, z - 0.03), (x + 0.03, TABLE - 0.03, z + 0.03), oak)
            for x in (-0.67, 0.67)
            for z in (-1.3, -0.67)
        ]
        return parts

    def at(self, t: float) -> Moment:
        poses = {k + 1: self._script.pose(k, t) for k in range(len(self._things))}
        posture = self._posture(t)
        solids = body(self._look, posture, self._person)
        balls = [(hand + UP * 0.01, 0.05) for hand in posture.hands]
        for label, pose in poses.items():
            thing = self._things[label - 1]
            solids += thing.placed(pose, label)
            balls.append((pose[:3, 3] + pose[:3, 1] * thing.height * 0.5, thing.radius * 1.1))
        return Moment(solids, balls, poses)

    def _posture(self, t: float) -> Posture:
        """Return the person at the far side of the table, facing the camera."""
        hands = (self._script.hand(0, t), self._script.hand(1, t))
        ahead = float(hands[0][2] + hands[1][2]) / 2 - FAR
        sway = 0.02 * wobble(t, self._phases[:2], (2.6, 4.1))
        pelvis = vec(sway, 0.50, -1.56)
        feet = (Foot(vec(0.16, 0.085, -1.15), 0.1), Foot(vec(-0.16, 0.085, -1.18), -0.1))
        return Posture(
            pelvis,
            0.0,
            feet,
            hands,
            lean=0.22 + 0.5 * max(0.0, ahead),
            twist=0.6 * float(hands[1][2] - hands[0][2]),
            gaze=(hands[0] + hands[1]) / 2,
            breath=sin(2 * math.pi * t / 3.6),
            elbows=vec(0.8, -0.5, -0.3),
        )
