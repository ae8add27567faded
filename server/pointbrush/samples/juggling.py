"""Jugglers: a timetable of throws, hands that swing, throw and catch, and pins that fly.

A siteswap is a list of throws, one per beat, repeated; hands take turns.  With two jugglers the
hands' order is right, right, left, left of persons 1, 2, 1, 2 ("four-handed siteswap", Boyce and
Simpson), so odd throws are passes.  A throw of as many beats as there are hands stays in the hand.

A pin is held (its grip follows the hand) or flies: its centre of mass falls freely and it turns
at an even rate about the thrower's left-right axis, so that the handle comes into the hand that
catches it.  A pin's own frame has its origin at the centre of mass and y from the knob to the top.
"""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.samples.geometry import (
    GRAVITY,
    UP,
    Array,
    axis_angle,
    from_rotation_vector,
    hermite,
    rigid,
    turn_between,
    unit,
    vec,
    yaw,
)
from pointbrush.samples.render import Solid
from pointbrush.samples.reproducible import atan2, cos, draw_normal, inner, matmul, sin
from pointbrush.samples.shapes import Lathe
from pointbrush.samples.textures import Color, Material, banded, linear

BALANCE = 0.29
"""Height of the centre of mass above the knob's end, metres."""
GRIP = 0.12 - BALANCE
"""Grip of the hand: y in the pin's frame."""

_HEIGHTS = [0.0, 0.006, 0.022, 0.04, 0.06, 0.20, 0.29, 0.37, 0.43, 0.49, 0.512, 0.52]
_RADII = [0.008, 0.017, 0.019, 0.0135, 0.0125, 0.016, 0.033, 0.047, 0.0455, 0.031, 0.022, 0.008]
_SHAPE = Lathe([y - BALANCE for y in _HEIGHTS], _RADII)

COLORS = ("#d8342b", "#1f6fc4", "#f0b51f", "#2f9a4c", "#8a3fa8", "#e8702a", "#17a2a2", "#d14a8b")
"""Band colours of pins 1, 2, …"""
ARM = -GRIP
"""Metres from the grip to the pin's centre of mass."""
RELEASE, CATCH, REST = math.radians(38), math.radians(52), math.radians(48)
TUMBLE = 2.3
"""Turns per second a flight is rounded to."""


@dataclass(frozen=True, slots=True)
class Rhythm:
    """A siteswap, the number of hands, seconds per beat and seconds a pin stays in a hand."""

    throws: tuple[int, ...]
    hands: int
    beat: float
    dwell: float

    @property
    def pins(self) -> int:
        """Number of pins that the siteswap keeps up."""
        return sum(self.throws) // len(self.throws)


@dataclass(frozen=True, slots=True)
class Throw:
    """One flight: pin and hands by number from 0, times in seconds."""

    pin: int
    hand: int
    leave: float
    to_hand: int
    arrive: float


def rhythm(siteswap: str, hands: int, beat: float, dwell: float) -> Rhythm:
    """Parse a siteswap of digits and letters ("774", "b97").

    Raises BadInputError when two throws would land at the same time.
    """
    try:
        throws = tuple(int(c, 36) for c in siteswap)
    except ValueError:
        throws = ()
    n = len(throws)
    if n == 0 or len({(i + t) % n for i, t in enumerate(throws)}) != n:
        raise BadInputError(f"pattern: expected a valid siteswap like '774', got {siteswap!r}")
    if any(0 < t != hands and t * beat <= dwell + 0.1 for t in throws):
        raise BadInputError(f"pattern: expected throws with time to fly, got {siteswap!r}")
    return Rhythm(throws, hands, beat, dwell)


def schedule(rhythm: Rhythm, start: float, stop: float) -> list[Throw]:
    """Return all throws that overlap start..stop, in order of release."""
    longest = max(rhythm.throws)
    first = int(start / rhythm.beat) - 3 * longest - rhythm.hands
    last = int(stop / rhythm.beat) + 2 * longest + rhythm.hands
    first -= first % (len(rhythm.throws) * rhythm.hands)
    landing: dict[int, int] = {}
    throws: list[Throw] = []
    pins = 0
    for beat in range(first, last):
        height = rhythm.throws[beat % len(rhythm.throws)]
        if height == 0:
            continue
        pin = landing.pop(beat, None)
        if pin is None:
            pin, pins = pins, pins + 1
        landing[beat + height] = pin
        hand, to_hand = beat % rhythm.hands, (beat + height) % rhythm.hands
        if height != rhythm.hands:
            arrive = (beat + height) * rhythm.beat - rhythm.dwell
            throws.append(Throw(pin, hand, beat * rhythm.beat, to_hand, arrive))
    return throws


def paint(color: str, body: str = "#f1efe8") -> Material:
    """Return a pin's paint: dark knob, coloured handle, pale body with coloured bands."""
    tint, pale = linear(color), linear(body)
    black: Color = (0.03, 0.03, 0.035)
    limits: tuple[tuple[float, Color], ...] = (
        (0.035, black),
        (0.19, tint),
        (0.205, black),
        (0.30, pale),
        (0.345, tint),
        (0.405, pale),
        (0.435, tint),
        (0.50, pale),
        (0.53, black),
    )
    return Material(
        partial(banded, bands=tuple((y - BALANCE, c) for y, c in limits)), infrared=0.7, gloss=0.35
    )


def pin(material: Material, T_room_pin: Array, label: int) -> Solid:
    """Return a pin in place."""
    return Solid(_SHAPE, T_room_pin, material, label=label)


@dataclass(frozen=True, slots=True, eq=False)
class Stand:
    """Stand of a juggler: a place on the floor, a heading, body size."""

    place: Array
    facing: float
    size: float = 1.0

    def at(self, left: float, up: float, forward: float) -> Array:
        """Return a place given in the body's axes."""
        return np.asarray(self.place + matmul(yaw(self.facing), vec(left, up, forward) * self.size))


@dataclass(frozen=True, slots=True, eq=False)
class Hand:
    """One hand of a juggler; ``side`` +1 left, -1 right."""

    stand: Stand
    side: float

    @property
    def right(self) -> Array:
        """The axis a pin turns about: the body's right."""
        return np.asarray(-yaw(self.stand.facing)[:, 0])

    def axis(self, angle: float) -> Array:
        """Return the direction of a held pin with its body ``angle`` above forward."""
        return unit(matmul(yaw(self.stand.facing), vec(self.side * 0.14, sin(angle), cos(angle))))

    def place(self, phase: str) -> Array:
        """Place of the hand as it throws, catches or rests."""
        left, up, forward = {
            "throw": (0.16, 1.03, 0.40),
            "catch": (0.29, 1.10, 0.38),
            "rest": (0.24, 1.00, 0.36),
        }[phase]
        return self.stand.at(self.side * left, up, forward)


@dataclass(frozen=True, slots=True, eq=False)
class Knot:
    """A hand at one time: grip position and velocity, pin angle and its rate."""

    time: float
    position: Array
    velocity: Array
    angle: float
    rate: float


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """A pin in the air, from ``leave`` to ``arrive``."""

    throw: Throw
    start: Array
    velocity: Array
    axis0: Array
    spin_axis: Array
    spin: float
    fix: Array
    """Rotation vector that, spread over the flight, brings the axis into the catching hand."""

    @property
    def duration(self) -> float:
        """Seconds in the air."""
        return self.throw.arrive - self.throw.leave

    def centre(self, t: float) -> Array:
        """Centre of mass at time ``t``."""
        dt = t - self.throw.leave
        return np.asarray(self.start + self.velocity * dt - UP * (GRAVITY / 2 * dt * dt))

    def turn(self, t: float) -> Array:
        """(3, 3) rotation since the release."""
        s = (t - self.throw.leave) / self.duration
        return matmul(from_rotation_vector(self.fix * s), axis_angle(self.spin_axis, self.spin * s))


class Juggle:
    """The motion of hands and pins over a stretch of time, at any moment of it.

    ``hand(h, t)`` -> grip position; ``pin(k, t)`` -> ``T_room_pin``; ``flying(k, t)``.
    """

    def __init__(
        self, rhythm: Rhythm, hands: list[Hand], stop: float, rng: np.random.Generator
    ) -> None:
        self.hands = hands
        throws = schedule(rhythm, -0.5, stop + 0.5)
        self.pins = rhythm.pins
        self._flights = [self._fly(throw, rng) for throw in throws]
        self._knots = [self._path(h) for h in range(len(hands))]
        self._times = [[knot.time for knot in knots] for knots in self._knots]
        self._stories = [self._story(k) for k in range(self.pins)]

    def _fly(self, throw: Throw, rng: np.random.Generator) -> Flight:
        """Work out the flight between two hands, with a juggler's small errors."""
        giver, taker = self.hands[throw.hand], self.hands[throw.to_hand]
        duration = throw.arrive - throw.leave
        release, catch = RELEASE + draw_normal(rng, 0.05), CATCH + draw_normal(rng, 0.07)
        a0, a1 = giver.axis(release), taker.axis(catch)
        start = giver.place("throw") + draw_normal(rng, 0.012, 3) + ARM * a0
        end = taker.place("catch") + draw_normal(rng, 0.03, 3) + ARM * a1
        velocity = (end - start) / duration + UP * (GRAVITY / 2 * duration)
        forward = yaw(giver.stand.facing)[:, 2]
        base = atan2(inner(a1, UP), inner(a1, forward)) - release
        turns = max(0, round(TUMBLE * duration - base / (2 * math.pi)))
        spin = base + 2 * math.pi * turns
        fix = turn_between(matmul(axis_angle(giver.right, spin), a0), a1)
        return Flight(throw, start, velocity, a0, giver.right, spin, fix)

    def _path(self, h: int) -> list[Knot]:
        """Return the hand's knots: a catch or a throw each, and rests in long waits between."""
        hand = self.hands[h]
        knots: list[Knot] = []
        for flight in self._flights:
            if flight.throw.hand == h:
                knots.append(_leaving(flight, hand))
            if flight.throw.to_hand == h:
                knots.append(_arriving(flight, hand))
        knots.sort(key=lambda knot: knot.time)
        rest, still = hand.place("rest"), np.zeros(3)
        full: list[Knot] = []
        for before, after in zip(knots, [*knots[1:], None], strict=True):
            full.append(before)
            if after is not None and after.time - before.time > 0.5:
                full.append(Knot(before.time + 0.2, rest, still, REST, 0.0))
                full.append(Knot(after.time - 0.26, rest, still, REST - 0.25, 0.0))
        return full

    def _knot(self, h: int, t: float) -> tuple[Knot, Knot, float, float]:
        knots = self._knots[h]
        number = min(max(bisect.bisect_right(self._times[h], t), 1), len(knots) - 1)
        a, b = knots[number - 1], knots[number]
        span = b.time - a.time
        return a, b, span, min(max((t - a.time) / span, 0.0), 1.0)

    def hand(self, h: int, t: float) -> Array:
        """(3,) grip position of hand ``h``."""
        a, b, span, s = self._knot(h, t)
        return hermite(s, a.position, b.position, a.velocity * span, b.velocity * span)

    def angle(self, h: int, t: float) -> float:
        """Angle above forward at which hand ``h`` holds a pin."""
        a, b, span, s = self._knot(h, t)
        ends = (vec(a.angle), vec(b.angle), vec(a.rate * span), vec(b.rate * span))
        return float(hermite(s, *ends)[0])

    def _story(self, k: int) -> list[tuple[float, Flight | None, int, float, Array]]:
        """Phases of pin ``k``: (from time, flight or None, hand, angle then, rotation then)."""
        phases: list[tuple[float, Flight | None, int, float, Array]] = []
        R = np.eye(3)
        flights = [f for f in self._flights if f.throw.pin == k]
        for number, flight in enumerate(flights):
            hand = self.hands[flight.throw.hand]
            if number == 0:
                R = from_rotation_vector(turn_between(UP, flight.axis0))
                held = self.angle(flight.throw.hand, flight.throw.leave)
                phases.append((-math.inf, None, flight.throw.hand, held, R))
            else:
                R = self._held(phases[-1], flight.throw.leave)
            R = matmul(from_rotation_vector(turn_between(R[:, 1], flight.axis0)), R)
            phases.append((flight.throw.leave, flight, flight.throw.hand, 0.0, R))
            hand, landed = self.hands[flight.throw.to_hand], flight.throw.arrive
            R = matmul(flight.turn(landed), R)
            angle = self.angle(flight.throw.to_hand, landed)
            R = matmul(from_rotation_vector(turn_between(R[:, 1], hand.axis(angle))), R)
            phases.append((landed, None, flight.throw.to_hand, angle, R))
        return phases

    def _held(self, phase: tuple[float, Flight | None, int, float, Array], t: float) -> Array:
        _, _, h, angle, R = phase
        return matmul(axis_angle(self.hands[h].right, self.angle(h, t) - angle), R)

    def _phase(self, k: int, t: float) -> tuple[float, Flight | None, int, float, Array]:
        story = self._stories[k]
        return story[max(bisect.bisect_right([p[0] for p in story], t) - 1, 0)]

    def flying(self, k: int, t: float) -> bool:
        """Whether pin ``k`` is in the air."""
        return self._phase(k, t)[1] is not None

    def pin(self, k: int, t: float) -> Array:
        """(4, 4) ``T_room_pin``."""
        phase = self._phase(k, t)
        _, flight, h, _, R0 = phase
        if flight is not None:
            return rigid(matmul(flight.turn(t), R0), flight.centre(t))
        R = self._held(phase, t)
        return rigid(R, self.hand(h, t) + ARM * R[:, 1])


def _leaving(flight: Flight, hand: Hand) -> Knot:
    """Return the hand at a release: it moves as the handle does."""
    rate = flight.spin / flight.duration
    swing = np.cross(hand.right, ARM * flight.axis0) * rate
    angle = atan2(inner(flight.axis0, UP), inner(flight.axis0, yaw(hand.stand.facing)[:, 2]))
    position = flight.start - ARM * flight.axis0
    return Knot(flight.throw.leave, position, (flight.velocity - swing) * 0.9, angle, rate * 0.9)


def _arriving(flight: Flight, hand: Hand) -> Knot:
    """Return the hand at a catch: it gives way to the pin."""
    rate = flight.spin / flight.duration
    axis = unit(matmul(flight.turn(flight.throw.arrive), flight.axis0))
    falling = flight.velocity - UP * (GRAVITY * flight.duration)
    forward = yaw(hand.stand.facing)[:, 2]
    same_way = inner(flight.spin_axis, hand.right)
    angle = atan2(inner(axis, UP), inner(axis, forward))
    position = flight.centre(flight.throw.arrive) - ARM * axis
    return Knot(flight.throw.arrive, position, falling * 0.3, angle, rate * same_way * 0.4)
