"""Whose each cell before a known scene is, by where everybody is expected and by what they wear."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.tracking.geometry.components import parts
from pointbrush.tracking.geometry.mean_field import agreed
from pointbrush.tracking.interface import F64, I64
from pointbrush.tracking.people.observation import Observation
from pointbrush.tracking.people.person import FEWEST, Person

LIMBS, SWING, SLOWEST, MOST = 0.06, 0.4, 0.02, 0.3
"""Metres by which limbs move anyhow, and share of the fastest step, of so many metres at least and
at most."""
UNSEEN, LONG = 0.04, 8
"""Metres more a frame unseen, of so many frames at most."""
SHADE = 0.06
"""Difference of colour that counts as much as that distance."""
CAP = 4.0
"""Cost of a cell that is nowhere near a person."""
WORN, LESS, RARE = 0.35, 0.5, 4.0
"""Weight of clothes, how much rarer colours may be than usual ones, and what counts at most."""
HIDDEN = 1.0
"""What it costs to be somebody's who was hidden."""
ROUND, BEYOND, REACH = 0.25, 0.2, 2.0
"""Metres from his middle, along the ground, that hold a body; deviation beyond; cost at most."""
ROUNDS, SETTLED, DOUBT = 3, 0.02, 0.15
"""Most times that strides are mended, metres up to which once is enough, and the visible share at
which they are believed half."""
SHOWN, MET = 0.03, 2.5
"""Share of his cells that somebody has to have, and times that limbs swing within which cells meet
his surface, for his stride to be mended."""
FITS, FITTING = 0.8, 0.2
"""Share of the cap that fits, and of its cells that must fit for a body to be anybody's."""
SURE = 0.9
"""Probability from which an outline far from everybody is somebody's."""
APART, PART = 0.35, 0.5
"""Metres that nothing lies from the rest of somebody, if it has less than this share of it."""
KNOWN, BESIDE, HALF = 0.15, 0.5, 0.5
"""Metres from his surface, and from his middle, within which at least so much of it may lie all the
same."""
CLOSE = 1.0
"""Cost less than another's by which a cell is disputed."""


@dataclass(eq=False)
class Shares:
    """``stride`` (K, 3) metres of each person; ``cost`` (N, K) of a cell to be his, ``chance``."""

    stride: F64
    cost: F64
    chance: F64

    def disputed(self, cells: I64, who: int) -> float:
        """Share of somebody's cells that hardly less are another's."""
        others = np.delete(self.cost[cells], who, axis=1)
        if not others.shape[1] or not len(cells):
            return 0.0
        return float((others.min(axis=1) < self.cost[cells, who] + CLOSE).mean())


def shared_out(sight: Observation, people: Sequence[Person], stride: F64) -> Shares:
    """Give the cells in ``sight`` owners, mending the strides (K, 3) by who has what."""
    clothes = _clothes(sight, people)
    steps = [float(np.linalg.norm(f.step)) for f in people if not f.missing]
    swing = LIMBS + SWING * min(max([SLOWEST, *steps]), MOST)
    stride = stride.copy()
    surfaces = [_Surface.of(f, swing, coloured=sight.tints is not None) for f in people]
    for _ in range(ROUNDS):
        cost = np.full((len(sight.owner), len(people)), CAP)
        near = []
        for k, surface in enumerate(surfaces):
            cost[:, k], nearest = _place(sight, surface, stride[k])
            near.append(nearest)
        cost += clothes
        chance = agreed(cost, sight.links)
        who = chance.argmax(axis=1)
        mended = np.zeros_like(stride)
        for k, person in enumerate(people):
            his = np.where(who == k, near[k], -1)
            mended[k] = _mended(sight, person, stride[k], chance[:, k], his, swing)
        stride += mended
        if np.linalg.norm(mended, axis=1).max() < SETTLED:
            break
    sight.owner = np.array([f.label for f in people], np.int64)[who]
    _leave(sight, cost.min(axis=1), chance.max(axis=1))
    for k, person in enumerate(people):
        _drop(sight, person, stride[k])
    return Shares(stride, cost, chance)


def _clothes(sight: Observation, people: Sequence[Person]) -> F64:
    """(N, K) what the colours of each cell cost."""
    cost = np.zeros((len(sight.owner), len(people)))
    for k, person in enumerate(people):
        if sight.tints is not None and person.identity.worn is not None:
            rare = person.identity.worn.usual - LESS - person.identity.worn.each(sight.tints)
            cost[:, k] = WORN * sight.mean(np.clip(rare, 0.0, RARE))
    return cost


@dataclass(frozen=True, eq=False)
class _Surface:
    """Somebody's surface of the last frame, to be searched in units of ``within`` metres."""

    person: Person
    within: float
    own: F64
    tree: cKDTree

    @staticmethod
    def of(person: Person, swing: float, *, coloured: bool) -> _Surface:
        within = swing + UNSEEN * min(person.missing, LONG)
        own = person.xyz / within
        if coloured:
            own = np.hstack([own, person.colour / SHADE])
        return _Surface(person, within, own, cKDTree(own))


def _place(sight: Observation, surface: _Surface, stride: F64) -> tuple[F64, I64]:
    """(N,) what it costs each cell to be his there, and his cell next to it, -1 for none."""
    own, person = surface.own, surface.person
    seen = (sight.cells.middle - stride) / surface.within
    if own.shape[1] > seen.shape[1]:
        seen = np.hstack([seen, sight.cells.colour / SHADE])
    reach = np.sqrt(2 * CAP)
    close = np.all((seen > own.min(axis=0) - reach) & (seen < own.max(axis=0) + reach), axis=1)
    gap, near = np.full(len(seen), np.inf), np.full(len(seen), -1)
    gap[close], near[close] = surface.tree.query(seen[close], distance_upper_bound=reach)
    cost = np.where(np.isfinite(gap), 0.5 * np.minimum(gap, CAP) ** 2, CAP)
    middle = np.median((person.xyz + stride) @ sight.flat, axis=0)
    away = np.linalg.norm(sight.ground - middle, axis=1)
    cost += np.minimum(REACH, 0.5 * (np.maximum(0.0, away - ROUND) / BEYOND) ** 2)
    cost += HIDDEN * (person.missing > 0)
    return cost, np.where(np.isfinite(gap), near, -1).astype(np.int64)


def _mended(
    sight: Observation,
    person: Person,
    stride: F64,
    chance: F64,
    near: I64,
    swing: float,
) -> F64:
    """(3,) how far off a stride is, by the cells he has and by the surface he should show.

    ``near`` (N,) number of the point of his surface that each cell is nearest to, -1 for those
    that he has not; ``chance`` (N,) of each to be his; ``swing`` metres by which limbs move.
    """
    cells = np.flatnonzero((near >= 0) & sight.cells.solid)
    if len(cells) < max(FEWEST, SHOWN * person.size):
        return np.zeros(3)
    there = person.xyz + stride
    seen = sight.cells.middle[cells]
    weight = chance[cells] * np.sqrt(sight.cells.count[cells])
    off = ((seen - there[near[cells]]) * weight[:, None]).sum(axis=0) / weight.sum()
    shown = sight.shows(there)
    gap, nearest = map(np.asarray, cKDTree(seen).query(there[shown], 1, 0, 2, MET * swing))
    met = np.isfinite(gap)
    if np.count_nonzero(met) > FEWEST:
        off = (off + (seen[nearest[met]] - there[shown][met]).mean(axis=0)) / 2
    share = float(shown.mean())
    return np.asarray(off * share / (share + DOUBT))


def _leave(sight: Observation, cost: F64, chance: F64) -> None:
    """What hangs together and hardly fits anybody is nobody's yet."""
    inside = sight.bodies >= 0
    fits = cost < FITS * CAP
    if inside.any():
        body = sight.bodies[inside]
        bad = np.bincount(body, weights=fits[inside]) < FITTING * np.bincount(body)
        sight.owner[inside] = np.where(bad[body], 0, sight.owner[inside])
    sight.owner[~inside & ~fits & (chance <= SURE)] = 0


def _drop(sight: Observation, person: Person, stride: F64) -> None:
    """Take from a person what lies apart from the rest of it, and not where he should be."""
    cells = np.flatnonzero(sight.owner == person.label)
    if len(cells) < FEWEST:
        return
    some = np.zeros(len(sight.owner), np.bool_)
    some[cells] = True
    part = parts(sight.cells.touching, some)[cells]
    count = np.bincount(part)
    if len(count) < 2:
        return
    rest = np.flatnonzero(count[part] < PART * count.max())
    if not len(rest):
        return
    there, middles = person.xyz + stride, sight.cells.middle[cells]
    gap = np.asarray(cKDTree(middles[part == count.argmax()]).query(middles[rest])[0])
    known = np.asarray(cKDTree(there).query(middles[rest])[0] < KNOWN)
    middle = np.median(there @ sight.flat, axis=0)
    known &= np.linalg.norm(sight.ground[cells[rest]] - middle, axis=1) < BESIDE
    for number in np.unique(part[rest]).tolist():
        piece = part[rest] == number
        if gap[piece].min() > APART and known[piece].mean() < HALF:
            sight.owner[cells[rest[piece]]] = 0
