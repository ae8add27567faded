"""Moving cells in front of a known scene, with features to distinguish people."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pointbrush.tracking.compute.graph import Paths, parts, paths_into
from pointbrush.tracking.interface import F32, F64, I64, USUAL_FPS, Mask
from pointbrush.tracking.model.appearance import ColourHistogram
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.people.foreground import Foreground
from pointbrush.tracking.scene.depth import NEVER, PictureBackground
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import flying


@dataclass(eq=False)
class PersonObservation:
    """The moving ``cells`` of a frame and their owners.

    ``flat`` (3, 2) and ``up`` (3,): axes along and off the ground; ``owner`` (N,): a label, below
    0 for unlabelled people, 0 for none; ``flying`` (F,): unassigned flying pixels outside all
    cells; ``fps``: frames per second.
    """

    view: View
    cells: Foreground
    flat: F64
    up: F64
    flying: I64
    fps: float = USUAL_FPS
    owner: I64 = field(init=False)

    @property
    def options(self) -> TrackerOptions:
        """The options of the run."""
        return self.view.options

    def __post_init__(self) -> None:
        """Start with cells without an owner."""
        self.owner = np.zeros(len(self.cells.count), np.int64)

    @staticmethod
    def of(
        view: View,
        background: PictureBackground,
        free: Mask,
        size: float,
        unit: float,
        flat: F64,
        up: F64,
        fps: float,
    ) -> PersonObservation:
        """Return cells of ``size`` metres from the ``free`` foreground points (N,)."""
        some = np.flatnonzero(free)
        some = some[~background.furniture(view, some)]
        moving = ~background.scenery(view, some, NEVER) | (
            background.reappearing_labels(view, some) != 0
        )
        some = some[moving]
        loose = flying(view, some, unit)
        return PersonObservation(
            view, Foreground.of(view, some[~loose], size), flat, up, some[loose], fps
        )

    def points_of(self, label: int) -> I64:
        """Return the points of an owner."""
        return np.asarray(self.cells.indices[self.owner[self.cells.cell] == label])

    def take_flying(self, points: I64) -> I64:
        """Return the flying pixels (B,) at the outline of ``points`` (M,), and remove them."""
        beside = self.view.around(points)[self.view.cells.cell[self.flying]]
        taken, self.flying = self.flying[beside], self.flying[~beside]
        return taken

    @cached_property
    def tints(self) -> F32 | None:
        """(M, 3) colour of each point; None if the recording has none."""
        return None if self.view.frame.rgb is None else self.view.colour(self.cells.indices)

    @cached_property
    def ground(self) -> F64:
        """(N, 2) position of each cell on the ground."""
        return np.asarray(self.cells.middle @ self.flat)

    @cached_property
    def bodies(self) -> I64:
        """(N,) connected component of each solid cell, -1 for other cells."""
        return np.asarray(parts(self.cells.touching, self.cells.solid))

    @cached_property
    def links(self) -> Paths:
        """Links from each cell to touching solid cells, weighted by the similarity of colours."""
        one, other = self.cells.touching.T
        change = np.linalg.norm(self.cells.colour[one] - self.cells.colour[other], axis=1)
        agree = np.exp(-change / self.options.body.colour_change).astype(np.float64)
        return paths_into(self.cells.touching, agree, self.cells.solid)

    def cells_of(self, label: int) -> I64:
        """Return the solid cells of an owner."""
        return np.flatnonzero((self.owner == label) & self.cells.solid)

    def touching_others(self, cells: I64, label: int) -> float:
        """Return the share of an owner's ``cells`` (C,) that touch cells of other people."""
        one, other = self.cells.touching.T
        owners = self.owner[one], self.owner[other]
        apart = (owners[0] != owners[1]) & (owners[0] != 0) & (owners[1] != 0)
        mine = [side[apart & (of == label)] for side, of in zip((one, other), owners, strict=True)]
        touches = np.zeros(len(self.owner), np.bool_)
        touches[np.concatenate(mine)] = True
        return float(touches[cells].mean())

    def at_side(self, cells: I64) -> bool:
        """Test whether the ``cells`` (C,) touch the left or the right edge of the picture.

        The edges are the outermost measured columns; the grid of pixels has a margin around them.
        """
        options, (column, first, last) = self.options.arrivals, self._columns
        own = np.zeros(len(self.owner), np.bool_)
        own[cells] = True
        column = column[self.cells.indices[own[self.cells.cell]]]
        beside = np.minimum(column - first, last - column) < options.side_px
        return bool(np.count_nonzero(beside) >= options.side_points)

    @cached_property
    def _columns(self) -> tuple[I64, int, int]:
        """Columns (N,) of the points in the grid of pixels; the first and the last measured one."""
        down, across = self.view.image_shape
        cell = self.view.cells.cell.astype(np.int64)
        column = cell % across
        seen = column[cell < down * across]
        return column, int(seen.min(initial=across)), int(seen.max(initial=0))

    def spread(self, cells: I64) -> float:
        """Standard deviation (m) of the ``cells`` (C,) along the ground, both ways together."""
        return float(np.linalg.norm(np.std(self.ground[cells], axis=0)))

    def area(self, cells: I64) -> float:
        """Return the visible surface of the ``cells`` (C,), in pixels at a distance of 1 m."""
        return float(self.areas[cells].sum())

    @cached_property
    def areas(self) -> F64:
        """(N,) visible surface of each cell; see ``area``."""
        depth = self.view.range_to(self.cells.middle)
        return np.asarray(self.cells.count * depth**2)

    def unlike(self, appearance: ColourHistogram) -> F64:
        """Return (N,) by how much a cell's mean log likelihood of clothes is below the usual one.

        It is 0 if the recording has no colours.
        """
        if self.tints is None:
            return np.zeros(len(self.owner))
        return self.mean(appearance.usual - appearance.each(self.tints))

    def mean(self, each: F32 | F64) -> F64:
        """Return (N,) the mean of values (M,) over the points of each cell."""
        sums = np.bincount(self.cells.cell, weights=each, minlength=len(self.owner))
        return np.asarray(sums / self.cells.count)

    def shows(self, world: F64) -> Mask:
        """Return a mask of the positions (M, 3) inside the picture that are not occluded."""
        return self.view.sees_through(world, -self.options.body.before_m)

    def smooth(self, each: F64) -> F64:
        """Return (N,) the mean of ``each`` cell's value and its neighbours' values."""
        one, other = self.cells.touching.T
        sums = each.copy()
        np.add.at(sums, one, each[other])
        np.add.at(sums, other, each[one])
        return np.asarray(
            sums / (1 + np.bincount(self.cells.touching.ravel(), minlength=len(each)))
        )

    def some(self, cells: I64) -> F32 | None:
        """Return colours (S, 3) of a sample of the points of the ``cells`` (C,)."""
        if self.tints is None:
            return None
        mask = np.zeros(len(self.owner), np.bool_)
        mask[cells] = True
        tints = self.tints[mask[self.cells.cell]]
        return tints[:: max(1, len(tints) // self.options.body.colour_points)]
