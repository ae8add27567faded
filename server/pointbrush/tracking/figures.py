"""Large things that bend, people above all: what hangs together in the foreground is theirs.

The moving points of a frame become a graph of small cells.  Cells that a model claims are where
each figure certainly is; the others go to the figure from which the way through the foreground is
shortest, and a change of colour makes a way longer.  So limbs that moved far are found again, and
two people who touch part where their clothes meet.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from pointbrush.tracking.assign import Claim
from pointbrush.tracking.background import Background
from pointbrush.tracking.grid import cells_of, perhaps_near
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.place import Place
from pointbrush.tracking.registration import transform
from pointbrush.tracking.thing import HARDLY, Rivals, Thing
from pointbrush.tracking.view import View

CELL, TOUCH = 3.0, 1.7
"""Size of a cell in units; distance of cells that touch, in cells."""
THIN = 0.15
"""Cells with less than this share of the usual number of points lead nowhere: flying pixels."""
UNLIKE = 0.08
"""Colour difference, in the units of ``View.colour``, that makes a way twice as long."""
FINE = 0.045
"""A cell is at least this share of the figure's radius."""
BRIDGE = 0.25
"""What lies apart is a figure's within this share of the longest way."""
ALIKE = 0.7
"""Share of a figure's colours that show that it is the same."""
DISPUTED = 0.3
"""Share of the smaller claim from which two things want the same body."""
OTHER = -1
SMALLEST = 4
"""Cells of a part that lies apart."""
FEWEST = 5
"""Points of a claim from which it counts."""
FAR = 0.6
"""A way ends at this share of the figure's radius."""


@dataclass(eq=False)
class Foreground:
    """Cells of the points ``indices`` (M,): ``cell`` (M,) of each, ``middle`` and ``colour``."""

    indices: I64
    cell: I64
    count: I64
    middle: F64
    colour: F32

    @staticmethod
    def of(view: View, indices: I64, size: float) -> Foreground:
        """The cells, ``size`` metres, of some points of a frame."""
        xyz = view.xyz[indices].astype(np.float64)
        cell = cells_of(xyz, size)
        count = np.bincount(cell)
        mean = [
            np.stack([np.bincount(cell, weights=v[:, a]) for a in range(3)], axis=1)
            / count[:, None]
            for v in (xyz, view.colour(indices))
        ]
        return Foreground(indices, cell, count, mean[0], mean[1].astype(np.float32))

    def spread(
        self,
        cores: Mapping[int, Mask],
        outside: Mask,
        other: Mask,
        certain: Mask,
        size: float,
        far: Mapping[int, float],
    ) -> I64:
        """(M,) label of each point, 0 for none, OTHER for other moving things.

        ``cores`` label → (M,) points that are certainly its; ``outside`` (M,) points that are
        certainly nobody's, which spread too, but not over ``certain`` foreground; ``other`` (M,)
        points of other moving things, which spread anywhere; ``size`` metres of a cell; ``far``
        label → metres of the longest way.
        """
        labels = np.array([0, *cores])
        total = len(self.count)
        solid = self.count >= THIN * np.median(self.count)
        ways = self._ways(size, solid)
        still = np.bincount(self.cell, weights=outside, minlength=total) > 0.5 * self.count
        rival = np.bincount(self.cell, weights=other, minlength=total) > 0.5 * self.count
        bare = still | rival
        sure = np.bincount(self.cell, weights=certain, minlength=total) > 0.5 * self.count
        votes = np.stack(
            [np.bincount(self.cell, weights=c, minlength=total) for c in cores.values()]
        )
        votes[:, bare] = 0
        off, _ = _reach(ways, np.flatnonzero(rival), np.ones(total, np.bool_))
        away = np.minimum(_reach(ways, np.flatnonzero(still), ~sure)[0], off)
        way, origin = _reach(ways, np.flatnonzero(votes.max(axis=0) > 0), ~bare)
        first = votes.argmax(axis=0) + 1
        limit = np.array([0.0, *[far[n] for n in cores]])
        owner = np.where(np.isfinite(way), first[origin], 0)
        owner[(way > limit[owner]) | (away < way)] = 0
        apart = np.flatnonzero(~np.isfinite(way) & ~np.isfinite(away) & solid & sure)
        self._join_apart(owner, apart, ways, BRIDGE * limit)
        owner[~solid] = 0
        result: I64 = labels[owner][self.cell]
        result[((owner == 0) & (off < way))[self.cell] | other] = OTHER
        result[outside] = 0
        for label, core in cores.items():
            result[core] = label
        return result

    def _join_apart(self, owner: I64, apart: I64, ways: csr_matrix, most: F64) -> None:
        """Give what nothing reached to the figure beside it, where it wears its colours.

        A leg behind the other one hangs together with nothing that the sensor sees.
        """
        count, part = connected_components(ways[apart][:, apart], directed=False)
        for label in np.unique(owner[owner > 0]).tolist():
            own = np.flatnonzero(owner == label)
            gap, _ = cKDTree(self.middle[own]).query(
                self.middle[apart], distance_upper_bound=most[label]
            )
            beside = np.bincount(part[np.isfinite(gap)], minlength=count) > 0
            if not beside.any():
                continue
            tone, _ = cKDTree(self.colour[own]).query(self.colour[apart])
            alike = np.bincount(part, weights=tone < UNLIKE / 2, minlength=count)
            whole = np.bincount(part, minlength=count)
            beside &= (alike > 0.6 * whole) & (whole >= SMALLEST)
            owner[apart[beside[part]]] = label

    def _ways(self, size: float, solid: Mask) -> csr_matrix:
        pairs = cKDTree(self.middle).query_pairs(TOUCH * size, output_type="ndarray")
        both = np.concatenate([pairs, pairs[:, ::-1]])
        both = both[solid[both[:, 0]]]
        a, b = both.T
        unlike = np.linalg.norm(self.colour[a] - self.colour[b], axis=1)
        length = np.linalg.norm(self.middle[a] - self.middle[b], axis=1) + 1e-6
        length *= 1 + unlike / UNLIKE
        count = len(self.count)
        return coo_matrix((length, (a, b)), shape=(count, count)).tocsr()


def _reach(ways: csr_matrix, source: I64, allowed: Mask) -> tuple[F64, I64]:
    """Length of the way from the nearest source (inf for none), and that source."""
    count = len(allowed)
    way, origin = np.full(count, np.inf), np.zeros(count, np.int64)
    allowed = allowed.copy()
    allowed[source] = True
    inside = np.flatnonzero(allowed)
    place = np.cumsum(allowed) - 1
    if len(source):
        found, _, start = dijkstra(
            ways[inside][:, inside], indices=place[source], min_only=True, return_predecessors=True
        )
        way[inside] = found
        origin[inside] = inside[np.maximum(start, 0)]
    return way, origin


def undisputed(claims: Mapping[int, Claim], things: Mapping[int, Thing]) -> dict[int, Claim]:
    """The claims, where two large things want the same body given to the likelier one, whole.

    Point by point the two would share it: who is hidden would take part of who hides him.
    """
    result = dict(claims)
    large = [n for n in claims if things[n].large]
    for one, other in combinations(large, 2):
        a, b = result[one], result[other]
        _, i, j = np.intersect1d(a.indices, b.indices, assume_unique=True, return_indices=True)
        if len(i) <= DISPUTED * min(len(a.indices), len(b.indices)):
            continue
        cost = float(a.cost[i].mean()) / things[one].reach
        against = float(b.cost[j].mean()) / things[other].reach
        label, lost = (other, j) if cost <= against else (one, i)
        keep = np.ones(len(result[label].indices), np.bool_)
        keep[lost] = False
        result[label] = result[label].pick(keep)
    return result


def hang_together(
    view: View,
    things: Mapping[int, Thing],
    places: Mapping[int, Place],
    claims: Mapping[int, Claim],
    taken: Mask,
    background: Background,
) -> dict[int, I64]:
    """New surface of large things ``places``: what hangs together with their claims.

    What stood still, and what is where something unlabelled was, is the outside and spreads too:
    floor that a foot has just uncovered hangs together with the floor around it.  ``background``
    knows what lies before a scene that has been seen.
    """
    cores = {n: claims[n].indices for n in places if len(claims[n].indices) >= FEWEST}
    if not cores:
        return {}
    inside, outside = np.zeros(len(view.xyz), np.bool_), np.zeros(len(view.xyz), np.bool_)
    for label in cores:
        place = places[label]
        outside[place.around] = True
        inside[place.moving] = True
    inside[taken] = False
    for core in cores.values():
        inside[core] = True
    outside &= ~inside & ~taken
    size = float(np.median([max(CELL * things[n].unit, FINE * things[n].span) for n in cores]))
    ground = _beside(view, np.flatnonzero(outside), np.flatnonzero(inside), size)
    other = np.zeros(len(view.xyz), np.bool_)
    rest = np.flatnonzero(inside & ~taken)
    scenery = ground[background.static(view, ground)[0]]
    scene = cKDTree(view.xyz[scenery], balanced_tree=False, compact_nodes=False)
    for label in cores:
        moved = _movers(things[label].rivals, scene, 1.5 * size)
        other[rest[_was_there(things[label], moved, view, places[label], rest)]] = True
    either = inside.copy()
    either[ground] = True
    every = np.flatnonzero(either)
    foreground = Foreground.of(view, every, size)
    far = {n: FAR * things[n].span for n in cores}
    seeds = {}
    for label, core in cores.items():
        mask = np.zeros(len(view.xyz), np.bool_)
        mask[core] = True
        seeds[label] = mask[every]
    sure = background.certain(view, every) & inside[every]
    found = foreground.spread(seeds, outside[every], other[every], sure, size, far)
    other_moving = np.zeros(len(view.xyz), np.bool_)
    other_moving[every[found == OTHER]] = True
    for label in cores:
        moving = places[label].moving
        places[label].beside = moving[other_moving[moving]]
    return {label: every[(found == label) & ~seed] for label, seed in seeds.items()}


def emerged(view: View, thing: Thing, moving: I64) -> I64:
    """The points of a large thing that comes out from behind another; none where none are like it.

    ``moving`` are points before the background that nothing else explains.  Of what hangs
    together there, it is the part nearest to where the thing should be that wears its colours,
    or of whose colours the thing showed some.
    """
    if len(moving) < FEWEST:
        return moving[:0]
    size = max(CELL * thing.unit, FINE * thing.span)
    foreground = Foreground.of(view, moving, size)
    solid = foreground.count >= THIN * np.median(foreground.count)
    ways = foreground._ways(size, solid)
    count, part = connected_components(ways, directed=False)
    cells = np.bincount(part, weights=solid, minlength=count)
    guess = transform(thing.motion.predictions()[0], thing.model.xyz)
    away, _ = cKDTree(guess).query(foreground.middle)
    known = cKDTree(thing.model.colour)
    best, found = np.inf, moving[:0]
    reach = thing.span * (0.5 + 0.25 * min(thing.missing, 8))
    for number in np.flatnonzero(cells >= 2 * SMALLEST):
        here = part == number
        gap = float(np.asarray(away)[here].min())
        points = moving[here[foreground.cell]]
        if gap > min(best, reach) or len(points) < HARDLY / 4 * thing.size:
            continue
        colour = view.colour(points[:: max(1, len(points) // 500)])
        worn, _ = known.query(colour)
        shown, _ = cKDTree(colour).query(thing.model.colour[:: max(1, len(thing.model.xyz) // 500)])
        if max(_share(worn), _share(shown)) > ALIKE:
            best, found = gap, points
    return found


def _share(unlike: object) -> float:
    """Share of the colour differences that are none to the eye."""
    return float((np.asarray(unlike) < UNLIKE / 2).mean())


def _beside(view: View, still: I64, moving: I64, size: float) -> I64:
    """Those of the points ``still`` that touch the moving ones."""
    some = moving[:: max(1, len(moving) // 4000)]
    if not len(some) or not len(still):
        return still[:0]
    still = still[perhaps_near(view.xyz[still], view.xyz[some], 2 * size)]
    tree = cKDTree(view.xyz[some], balanced_tree=False)
    distance, _ = tree.query(view.xyz[still], distance_upper_bound=2 * size)
    beside: I64 = still[np.isfinite(np.asarray(distance))]
    return beside


def _movers(rivals: Rivals, scene: cKDTree, apart: float) -> Rivals:
    """Those of the unlabelled points that are not part of the scene that stands still."""
    if not len(rivals.xyz) or not scene.n:
        return rivals
    distance, _ = scene.query(rivals.xyz, distance_upper_bound=apart)
    away = ~np.isfinite(np.asarray(distance))
    return Rivals(rivals.xyz[away], rivals.colour[away], rivals.weight)


def _was_there(thing: Thing, rivals: Rivals, view: View, place: Place, rest: I64) -> Mask:
    """Which points are where something unlabelled was, or where it went along with the thing."""
    step = place.pose @ np.linalg.inv(thing.motion.poses[-1])
    reach = np.full(len(rest), 3 * thing.unit)
    return rivals.explain(view.xyz[rest].astype(np.float64), view.colour(rest), reach, step)
