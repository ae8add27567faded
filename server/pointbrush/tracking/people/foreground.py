"""The foreground of a frame as a graph of small cells, and its assignment to figures.

Cells that a model claims certainly belong to its figure.  A connected body that is certainly in
front of the scene is assigned as a whole to the figure with claims on it.  With several figures, or
an unknown scene behind, each cell is assigned to the figure with the shortest path through the
foreground; a change of colour makes a path longer.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pointbrush.tracking.compute.columns import pairs
from pointbrush.tracking.compute.graph import Paths, parts, paths_over, shortest_paths
from pointbrush.tracking.compute.grid import cells_of, close_to, means_of
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.model.appearance import ColourHistogram
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.view import View

OTHER = -(2**20)
"""Points of other moving objects, as a label."""


@dataclass(frozen=True, slots=True, eq=False)
class _Figures:
    """K figures that share the foreground.

    ``votes`` (K, cells) points that each claims of a cell; ``far`` (K,) its longest path (m);
    ``clothes`` all histograms of clothes, and ``wears`` (K,) the index of each figure's histogram.
    """

    votes: NDArray[np.number]
    far: F64
    clothes: list[ColourHistogram]
    wears: I64

    @property
    def limit(self) -> F64:
        """(K + 1,) longest path (m): 0 for no figure, then of each figure."""
        return np.concatenate([[0.0], self.far])

    def nearest(self, ways: Paths, untracked: Mask, untracked_path: F64) -> tuple[I64, F64]:
        """Return (cells,) the figure with the shortest path to each cell, from 1, and the path.

        The figure is 0 if the path is too long or longer than ``untracked_path`` (cells,), the
        path to untracked points.  Paths do not cross ``untracked`` cells.
        """
        way, origin = shortest_paths(ways, np.flatnonzero(self.votes.max(axis=0) > 0), ~untracked)
        first = self.votes.argmax(axis=0) + 1
        owner = np.where(np.isfinite(way), first[origin], 0)
        owner[(way > self.limit[owner]) | (untracked_path < way)] = 0
        return owner, way


@dataclass(eq=False)
class Foreground:
    """Cells of the points ``indices`` (M,): ``cell`` (M,) of each.

    For each cell of ``size`` metres: ``count`` of points, of ``firm`` ones that are no outline's,
    ``middle`` and ``colour``.
    """

    options: TrackerOptions
    indices: I64
    cell: I64
    count: I64
    middle: F64
    colour: F32
    size: float
    firm: I64

    @staticmethod
    def of(view: View, indices: I64, size: float) -> Foreground:
        """Return the cells, ``size`` metres, of some points of a frame."""
        firm = view.firm(indices, size)
        xyz = view.xyz[indices].astype(np.float64)
        cell = cells_of(xyz, size)
        count = np.bincount(cell)
        return Foreground(
            view.options,
            indices,
            cell,
            count,
            means_of(xyz, cell),
            means_of(view.colour(indices), cell).astype(np.float32),
            size,
            np.bincount(cell[firm], minlength=len(count)),
        )

    @cached_property
    def solid(self) -> Mask:
        """(cells,) mask of cells with more than outline points."""
        return np.asarray(
            self.firm >= self.options.body.thin_share * np.median(self.count), np.bool_
        )

    @cached_property
    def touching(self) -> I64:
        """(P, 2) pairs of touching cells."""
        return pairs(self.middle, self.options.body.touching_cells * self.size)

    def bodies(self, least: int) -> list[I64]:
        """Return the cells of each connected component of at least ``least`` solid cells."""
        links = self.touching[self.solid[self.touching].any(axis=1)]
        part = parts(links, np.ones(len(self.count), np.bool_))
        cells = np.bincount(part, weights=self.solid)
        return [np.flatnonzero(part == n) for n in np.flatnonzero(cells >= least).tolist()]

    def spread(
        self,
        cores: Mapping[int, Mask],
        outside: Mask,
        other: Mask,
        certain: Mask,
        far: Mapping[int, float],
        clothes: Mapping[int, ColourHistogram],
    ) -> I64:
        """Return (M,) the label of each point, 0 for none, OTHER for other moving objects.

        ``cores`` label → (M,) points that are certainly its; ``outside`` (M,) points that are
        certainly untracked, which spread too, but not over ``certain`` foreground; ``other`` (M,)
        points of other moving objects, which spread anywhere; ``far`` label → longest path (m);
        ``clothes`` label → histogram of its clothes, for all people.
        """
        solid, ways = self.solid, self._ways()
        still, rival, sure = (self._mostly(points) for points in (outside, other, certain))
        untracked = still | rival
        figures = self._figures(cores, untracked, far, clothes)
        off, _ = shortest_paths(ways, np.flatnonzero(rival), np.ones(len(untracked), np.bool_))
        untracked_path = np.minimum(shortest_paths(ways, np.flatnonzero(still), ~sure)[0], off)
        owner, way = figures.nearest(ways, untracked, untracked_path)
        self._whole_bodies(owner, figures, ways, sure & solid & ~untracked & ~(off < way))
        apart = np.flatnonzero((owner == 0) & ~np.isfinite(untracked_path) & solid & sure)
        self._join_apart(owner, apart, self.options.body.bridge_share * figures.limit)
        owner[~solid] = 0
        result: I64 = np.array([0, *cores])[owner][self.cell]
        result[((owner == 0) & (off < way))[self.cell] | other] = OTHER
        result[outside] = 0
        for number, (label, core) in enumerate(cores.items()):
            loose = (owner == 0) | ~solid
            if sure.any():
                loose &= self._beside(owner == number + 1)
            result[core & loose[self.cell]] = label
        return result

    def _mostly(self, points: Mask) -> Mask:
        """Return a mask (cells,) of cells with most of their points in ``points`` (M,)."""
        inside = np.bincount(self.cell, weights=points, minlength=len(self.count))
        return np.asarray(inside > self.options.body.majority_share * self.count)

    def _figures(
        self,
        cores: Mapping[int, Mask],
        untracked: Mask,
        far: Mapping[int, float],
        clothes: Mapping[int, ColourHistogram],
    ) -> _Figures:
        """Return the figures with claims, without ``untracked`` cells (cells,); see ``spread``."""
        total = len(self.count)
        votes = np.stack(
            [np.bincount(self.cell, weights=c, minlength=total) for c in cores.values()]
        )
        votes[:, untracked] = 0
        wears = np.array([list(clothes).index(abs(n)) for n in cores])
        return _Figures(votes, np.array([far[n] for n in cores]), list(clothes.values()), wears)

    def _beside(self, own: Mask) -> Mask:
        """Return a mask of the cells that touch cells of a figure; all cells if it has none."""
        if not own.any():
            return np.ones(len(own), np.bool_)
        return close_to(self.middle, self.middle[own], self.options.body.touching_cells * self.size)

    def _whole_bodies(self, owner: I64, figures: _Figures, ways: Paths, sure: Mask) -> None:
        """Give each connected body before the scene to the figure with claims on it.

        A single claimant gets the whole body; several share it by the shortest path.
        """
        inside = np.flatnonzero(sure)
        if not len(inside):
            return
        part = parts(self.touching, sure)[inside]
        there = self._rights(figures, inside, part)
        owner[inside] = 0
        voters = np.where(there[:, part], figures.votes[:, inside], 0)
        source = np.flatnonzero(voters.max(axis=0) > 0)
        way, origin = shortest_paths(ways, inside[source], sure)
        first = np.zeros(len(sure), np.int64)
        first[inside] = voters.argmax(axis=0) + 1
        reached = np.flatnonzero(np.isfinite(way) & sure)
        owner[reached] = first[origin[reached]]

    def _rights(self, figures: _Figures, inside: I64, part: I64) -> Mask:
        """Return a mask (K, bodies) of the bodies that each figure may have.

        ``part`` (C,) is the body of each cell ``inside`` (C,).  A figure may have its main body,
        and another one if it has most claims on it.  Bodies too far from the main one, or with
        colours of another figure, are excluded.
        """
        options = self.options.body
        votes = figures.votes[:, inside]
        count = part.max() + 1
        claim = np.stack([np.bincount(part, weights=v, minlength=count) for v in votes])
        there = claim > options.majority_share * claim.sum(axis=0)
        there[np.arange(len(claim)), claim.argmax(axis=1)] = True
        there &= claim > options.min_claim_share * np.bincount(
            part, weights=self.count[inside], minlength=count
        )
        sums = [np.bincount(part, weights=v, minlength=count) for v in self.middle[inside].T]
        middle = np.stack(sums, axis=1) / np.bincount(part, minlength=count)[:, None]
        main = middle[claim.argmax(axis=1)]
        spans = figures.far / options.way_radii
        there &= np.linalg.norm(middle - main[:, None], axis=2) < spans[:, None]
        like = np.stack([appearance.each(self.colour[inside]) for appearance in figures.clothes])
        for figure, body in np.argwhere(there).tolist():
            claimed = (part == body) & (votes[figure] > 0)
            if np.count_nonzero(claimed) >= options.clothed_cells:
                mean = like[:, claimed].mean(axis=1)
                there[figure, body] = mean[figures.wears[figure]] > mean.max() - options.clearly_log
        return np.asarray(there)

    def _join_apart(self, owner: I64, apart: I64, most: F64) -> None:
        """Assign parts that no path reached to the adjacent figure, if the colours match.

        A leg behind the other leg is connected to no visible surface.
        """
        options = self.options.body
        if not len(apart):
            return
        some = np.zeros(len(owner), np.bool_)
        some[apart] = True
        part = parts(self.touching, some)[apart]
        count = part.max() + 1
        for label in np.unique(owner[owner > 0]).tolist():
            own = np.flatnonzero(owner == label)
            there = close_to(self.middle[apart], self.middle[own], most[label])
            beside = np.bincount(part[there], minlength=count) > 0
            if not beside.any():
                continue
            tone = close_to(self.colour[apart], self.colour[own], options.colour_change / 2)
            alike = np.bincount(part, weights=tone, minlength=count)
            total = np.bincount(part, minlength=count)
            beside &= (
                (alike > options.alike_cells_share * total)
                & (total >= options.min_part_cells)
                & (total < len(own))
            )
            owner[apart[beside[part]]] = label

    def _ways(self) -> Paths:
        a, b = self.touching.T
        length = _between(self.middle, a, b) + 1e-6
        length *= 1 + _between(self.colour, a, b) / self.options.body.colour_change
        return paths_over(self.touching, length, self.solid)


def _between(values: NDArray[np.floating], a: I64, b: I64) -> F64:
    """Return the distance between rows ``a`` and ``b`` of ``values``."""
    gap = values[a] - values[b]
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", gap, gap)), np.float64)
