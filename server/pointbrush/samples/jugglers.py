"""The juggling scene: jugglers in a living room."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.samples.geometry import UP, Array, along, vec, wobble, yaw
from pointbrush.samples.juggling import ARM, COLORS, Hand, Juggle, Rhythm, Stand, paint, pin, rhythm
from pointbrush.samples.people import body, shadow_balls
from pointbrush.samples.posture import LOOKS, Look, Posture, standing_feet
from pointbrush.samples.recording import LabelInfo, Moment
from pointbrush.samples.reproducible import inner, matmul, sin
from pointbrush.samples.room import LivingRoom
from pointbrush.samples.sensor import tripod

PASSING = {3: ("3", 0.36), 5: ("744", 0.17), 6: ("774", 0.168), 7: ("7", 0.17)}
ALONE = {3: ("3", 0.34), 4: ("4", 0.29), 5: ("5", 0.26)}
DWELL = 0.32

PEOPLE_COLORS = ("#4e79ff", "#ff9a3c", "#52c46a")


@dataclass(frozen=True, slots=True)
class JugglingOptions:
    """Options of a juggling recording.

    ``people`` 1 or 2.  ``pins`` 3, 5, 6 or 7 when two pass, 3 to 5 for one.  ``passing`` False
    lets person 1 juggle alone while person 2 watches, a pin in each hand for ``held``.
    ``pattern``: another siteswap.  ``like_clothes``: pins painted in the shirts' colours.
    ``label_people``: whether people are labels too.
    """

    people: int = 2
    pins: int = 6
    passing: bool = True
    held: int = 0
    pattern: str | None = None
    like_clothes: bool = False
    label_people: bool = True


class JugglingScene(LivingRoom):
    """See ``recording.Scene``."""

    def __init__(self, seed: int, seconds: float, options: JugglingOptions) -> None:
        if options.people not in (1, 2):
            raise BadInputError(f"people: expected 1 or 2, got {options.people}")
        if options.held not in (0, 1, 2):
            raise BadInputError(f"held: expected 0 to 2, got {options.held}")
        rng = np.random.default_rng([seed, 1])
        super().__init__(seed, tripod(1.28, 4.0))
        self.options = options
        first = int(rng.integers(len(LOOKS)))
        self.looks = (
            [LOOKS[0], LOOKS[1]]
            if seed == 0
            else [LOOKS[(first + k) % len(LOOKS)] for k in range(2)]
        )
        self._phases = rng.uniform(0, 2 * math.pi, (2, 8))
        self.stands = self._places(rng)
        self.start: float = float(rng.uniform(0, 2)) if seed else 0.0
        """Moment of the pattern at which the recording begins, seconds."""
        passing = options.passing and options.people == 2
        jugglers = self.stands if passing else self.stands[:1]
        hands = [Hand(stand, side) for side in (-1.0, 1.0) for stand in jugglers]
        self.juggle = Juggle(_rhythm(options, len(hands)), hands, self.start + seconds, rng)
        self._paints = [paint(*_pin_colors(self, k)) for k in range(self._all_pins)]

    def _places(self, rng: np.random.Generator) -> list[Stand]:
        """Return jugglers face to face, a little turned to the camera."""
        apart = rng.uniform(1.0, 1.1)
        z = rng.uniform(-2.75, -2.6)
        turn = rng.uniform(0.05, 0.16)
        heights = [look.height / 1.75 for look in self.looks]
        if self.options.people == 1:
            return [
                Stand(vec(rng.uniform(-0.3, 0.3), 0, z + 0.3), rng.uniform(-0.5, 0.5), heights[0])
            ]
        return [
            Stand(vec(-apart, 0, z), math.pi / 2 - turn, heights[0]),
            Stand(vec(apart, 0, z - 0.1), -math.pi / 2 + turn, heights[1]),
        ]

    @property
    def _all_pins(self) -> int:
        return self.juggle.pins + self.options.held

    @property
    def labels(self) -> list[LabelInfo]:
        """See Scene: pins first, then people."""
        n = self._all_pins
        result = [
            LabelInfo(k + 1, f"pin {k + 1}", "pin", COLORS[k % len(COLORS)]) for k in range(n)
        ]
        if self.options.label_people:
            result += [
                LabelInfo(n + 1 + p, f"person {p + 1}", "person", PEOPLE_COLORS[p])
                for p in range(self.options.people)
            ]
        return result

    def at(self, t: float) -> Moment:
        poses = {k + 1: self.juggle.pin(k, self.start + t) for k in range(self.juggle.pins)}
        postures = [self._posture(p, t) for p in range(self.options.people)]
        solids, balls = [], []
        for p, posture in enumerate(postures):
            label = self._all_pins + 1 + p if self.options.label_people else 0
            solids += body(self.looks[p], posture, label)
            balls += shadow_balls(posture)
        for k in range(self.options.held):
            poses[self.juggle.pins + 1 + k] = self._carried(postures[-1], k, t)
        for label, T_room_pin in poses.items():
            solids.append(pin(self._paints[label - 1], T_room_pin, label))
            balls += [(T_room_pin[:3, 3] + T_room_pin[:3, 1] * 0.1, 0.045)]
        return Moment(solids, balls, poses)

    def _posture(self, p: int, t: float) -> Posture:
        """Return a juggler's posture: hands follow the pattern, the rest sways and breathes."""
        stand, look, f = self.stands[p], self.looks[p], self._phases[p]
        axes = yaw(stand.facing)
        sway = vec(0.025 * wobble(t, f[:2], (2.3, 3.7)), 0, 0.02 * wobble(t, f[2:4], (1.9, 3.1)))
        hands = self._hands(p, t)
        lift = float(hands[0][1] + hands[1][1]) / 2 - 1.05 * stand.size
        pelvis = stand.place + matmul(axes, sway) + UP * (0.938 * stand.size + 0.05 * lift)
        reach = inner(hands[0] - hands[1], axes[:, 2])
        aim = stand.at(0.15 * wobble(t, f[4:6], (1.3, 2.1)), 1.75, 1.1)
        return Posture(
            pelvis,
            stand.facing,
            standing_feet(stand.place, stand.facing, look.height),
            hands,
            lean=0.02 + 0.015 * wobble(t, f[4:6], (2.7, 1.4)),
            side=0.03 * wobble(t, f[6:8], (2.2, 3.3)),
            twist=-0.35 * reach,
            gaze=aim,
            breath=sin(2 * math.pi * t / 3.4 + f[0]),
        )

    def _hands(self, p: int, t: float) -> tuple[Array, Array]:
        """(left, right) grip positions of person ``p``."""
        jugglers = len(self.juggle.hands) // 2
        if p < jugglers:
            now = self.start + t
            return self.juggle.hand(jugglers + p, now), self.juggle.hand(p, now)
        stand, f = self.stands[p], self._phases[p]
        return (
            stand.at(
                0.24 + 0.04 * wobble(t, f[:2], (1.7, 2.9)),
                1.0 + 0.05 * wobble(t, f[2:4], (2.1, 3.5)),
                0.3,
            ),
            stand.at(
                -0.26 + 0.04 * wobble(t, f[4:6], (1.9, 2.3)),
                0.98 + 0.08 * wobble(t, f[6:8], (1.6, 2.6)),
                0.28,
            ),
        )

    def _carried(self, posture: Posture, k: int, t: float) -> Array:
        """Return a pin held still by the watching person."""
        f = self._phases[1]
        hand = Hand(self.stands[-1], 1.0 if k == 0 else -1.0)
        axis = hand.axis(math.radians(60) + 0.35 * wobble(t, f[k : k + 2], (1.5, 2.4)))
        grip = posture.hands[k]
        T = along(grip, grip + axis, hand.right)
        T[:3, 3] = grip + ARM * axis
        return T


def _rhythm(options: JugglingOptions, hands: int) -> Rhythm:
    known = PASSING if hands == 4 else ALONE
    if options.pattern is not None:
        found = rhythm(options.pattern, hands, 0.17 if hands == 4 else 0.34, DWELL)
        if found.pins != options.pins:
            raise BadInputError(
                f"pattern: expected a siteswap of {options.pins} pins, got {found.pins}"
            )
        return found
    if options.pins not in known:
        raise BadInputError(f"pins: expected one of {sorted(known)}, got {options.pins}")
    siteswap, beat = known[options.pins]
    return rhythm(siteswap, hands, beat, min(DWELL, 1.1 * beat * hands / 2))


def _pin_colors(scene: JugglingScene, k: int) -> tuple[str, str]:
    """Band and body colour of pin ``k``."""
    if not scene.options.like_clothes:
        return COLORS[k % len(COLORS)], "#f1efe8"
    look: Look = scene.looks[k % len(scene.looks)]
    return look.shirt, look.second or replace(look).trousers
