"""The crowd: people enter and leave a room at the picture's edges, with a bag and a ball."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations, pairwise

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.samples.geometry import UP, Array, rigid, vec, yaw
from pointbrush.samples.people import body, shadow_balls
from pointbrush.samples.posture import LOOKS, Look
from pointbrush.samples.recording import LabelInfo, Moment
from pointbrush.samples.render import block, egg, rod
from pointbrush.samples.reproducible import cos, norm, norms, sin
from pointbrush.samples.room import LivingRoom
from pointbrush.samples.sensor import tripod
from pointbrush.samples.tabletop import Thing
from pointbrush.samples.textures import Material, cloth, linear, striped
from pointbrush.samples.walkers import COLORS, Loop, Walk

HEIGHT = 1.9
"""Metres of the camera above the floor."""
PITCH = 14.0
"""Degrees of the camera below the horizon; near people are visible from the head down."""
WAYS = (
    (0.0, -2.0, 1.9, 0.12, 0.0),
    (0.4, -1.4, 1.9, 0.3, 80.0),
    (0.1, -2.75, 2.1, 0.12, 0.0),
    (0.0, -1.15, 1.5, 0.2, 0.0),
    (-0.1, -3.45, 1.3, 0.25, 0.0),
)
"""Loops of the people: x and z of the middle, half length and width (metres), degrees off x."""
CROWD_LOOKS = (
    *LOOKS,
    Look("#c9a227", "#5a4a2a", "stripes", "#3c4a3a", "#b07c5c", "#1b1714", "#5a3b2a", 1.73, 1.04),
)
BALL_RADIUS = 0.06
"""Metres."""
BALL_Z = -2.375
BALL_XS = (-0.9, -0.7, -0.5, -0.3, 0.95)
"""Metres; places of the ball that lie between the loops."""
TRIES = 300
"""Number of random timetables, of which the best has visible people and no collisions."""
EYE_LEVEL = 1.5
"""Metres above the floor; a person visible there shows at least head and shoulders."""
BAG_LEVEL = 0.5
"""Metres above the floor at which a bag is carried."""
EDGE_TAN = 0.68
LOWER_EDGE_TAN = 0.58
"""Tangents of the picture's side edges and its lower one, from its middle."""
RIM = 0.12
"""Distance from an edge, as a tangent, within which a person counts as at the edge."""


@dataclass(frozen=True, slots=True)
class CrowdOptions:
    """Options of a crowded room."""

    people: int = 4
    """Number of people, 3 to 5; one is at the edge of the picture at first."""
    things: bool = True
    """A bag, carried by a person, and a ball on the floor are labels too."""


class CrowdScene(LivingRoom):
    """See ``recording.Scene``."""

    def __init__(self, seed: int, seconds: float, options: CrowdOptions) -> None:
        if not 3 <= options.people <= len(WAYS):
            raise BadInputError(f"people: expected 3 to {len(WAYS)}, got {options.people}")
        rng = np.random.default_rng([seed, 31])
        super().__init__(seed, tripod(HEIGHT, PITCH))
        self._things = options.things
        order = rng.permutation(len(CROWD_LOOKS))[: options.people]
        loops = _timetable(options.people, seconds, rng)
        self._walks = [
            Walk(CROWD_LOOKS[int(k)], loop, seconds, 1.0, rng)
            for k, loop in zip(order, loops, strict=True)
        ]
        self._bearer = _carrier(self._walks)
        self._ball_place = _open_place([walk.place(0.0) for walk in self._walks])

    @property
    def labels(self) -> list[LabelInfo]:
        count = len(self._walks)
        colors = (*COLORS, "#d9c23f")
        found = [LabelInfo(p + 1, f"person {p + 1}", "person", colors[p]) for p in range(count)]
        if self._things:
            for k, thing in enumerate((_bag(), _ball())):
                found.append(LabelInfo(count + 1 + k, thing.name, "thing", thing.color))
        return found

    def at(self, t: float) -> Moment:
        solids, balls = [], []
        postures = [walk.posture(t) for walk in self._walks]
        for p, (walk, posture) in enumerate(zip(self._walks, postures, strict=True)):
            solids += body(walk.look, posture, p + 1)
            balls += shadow_balls(posture)
        if not self._things:
            return Moment(solids, balls, {})
        bearer, hand = self._bearer
        carrier = postures[bearer]
        bag, ball = len(postures) + 1, len(postures) + 2
        poses = {
            bag: rigid(yaw(carrier.facing), carrier.hands[hand] - UP * 0.3),
            ball: rigid(np.eye(3), self._ball_place),
        }
        solids += [*_bag().placed(poses[bag], bag), *_ball().placed(poses[ball], ball)]
        balls += [(poses[bag][:3, 3], 0.13), (self._ball_place, BALL_RADIUS)]
        return Moment(solids, balls, poses)


def _timetable(people: int, seconds: float, rng: np.random.Generator) -> list[Loop]:
    """Draw loops of people: all visible at first, one at the edge, without collisions."""
    best: tuple[float, list[Loop]] = (-np.inf, [])
    times = np.arange(0, seconds, 0.1)
    for _ in range(TRIES):
        loops = [
            Loop.drawn(x, z, half, width, math.radians(turn), 1.0, rng)
            for x, z, half, width, turn in WAYS[:people]
        ]
        inside = [_inside(loop.place(0.0), EYE_LEVEL) for loop in loops]
        shows = min(inside) > 0.0 and min(inside) < RIM
        clearance = _clearance(loops, times) if shows else -1.0
        if clearance > best[0]:
            best = (clearance, loops)
    return best[1]


def _inside(place: Array, level: float) -> float:
    """Return a person's distance from the side or lower edge of the picture, as a tangent, at
    ``level`` metres above the floor; negative outside."""
    pitch = math.radians(PITCH)
    local = vec(place[0], level - HEIGHT, place[2])
    depth = -local[2] * cos(pitch) - local[1] * sin(pitch)
    if depth < 0.5:
        return -1.0
    down = -local[1] * cos(pitch) + local[2] * sin(pitch)
    return float(min(EDGE_TAN - abs(local[0]) / depth, LOWER_EDGE_TAN - down / depth))


def _clearance(loops: Sequence[Loop], times: Array) -> float:
    """Least distance (m) between two people at any of the ``times``."""
    ways = [np.array([loop.place(t) for t in times]) for loop in loops]
    return min(float(norms(a - b).min()) for a, b in combinations(ways, 2))


def _carrier(walks: Sequence[Walk]) -> tuple[int, int]:
    """Return person and hand that carry the bag: the nearest person with a visible bag at first."""
    places = [walk.place(0.0) for walk in walks]
    showing = [k for k, place in enumerate(places) if _inside(place, BAG_LEVEL) > RIM]
    bearer = max(showing or range(len(walks)), key=lambda k: places[k][2])
    hands = walks[bearer].posture(0.0).hands
    return bearer, int(norm(hands[1]) < norm(hands[0]))


def _open_place(people: Sequence[Array]) -> Array:
    """Choose the ball's place (3,) that is farthest from being occluded by people at first."""
    ahead = [place[0] / place[2] for place in people if BALL_Z < place[2] < 0]
    gaps = [min((abs(x / BALL_Z - side) for side in ahead), default=1.0) for x in BALL_XS]
    return vec(BALL_XS[int(np.argmax(gaps))], BALL_RADIUS, BALL_Z)


def _bag() -> Thing:
    leather = Material(partial(cloth, color=linear("#8a5a3b"), fold=0.2), 0.5)
    handle = [vec(0, 0.14, -0.08), vec(0, 0.28, -0.03), vec(0, 0.28, 0.03), vec(0, 0.14, 0.08)]
    box = block((-0.05, -0.14, -0.16), (0.05, 0.14, 0.16), leather, roughness=0.1)
    straps = [rod(a, b, (0.011, 0.011), leather) for a, b in pairwise(handle)]
    return Thing("bag", "#8a5a3b", (box, *straps), 0.18, 0.0)


def _ball() -> Thing:
    skin = Material(
        partial(striped, color=linear("#f2e6c9"), second=linear("#2f6fbf"), width=0.04), 0.6, 0.3
    )
    return Thing("ball", "#2f6fbf", (egg(vec(0, 0, 0), (BALL_RADIUS,) * 3, skin),), 0.06, 0.06)
