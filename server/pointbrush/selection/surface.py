"""Connected part of a plane, found in several passes over the points near it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.points import Points
from pointbrush.selection.ray import Alive

Vector = NDArray[np.float64]
Keys = NDArray[np.int64]

BESIDE = 4.0
"""Thicknesses of a surface within which objects that stand on it show."""


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """``normal`` (3,) of length 1; ``normal · p = height``; points within ``thick`` are on it."""

    normal: Vector
    height: float
    thick: float

    def off(self, xyz: NDArray[np.floating]) -> Vector:
        """Signed distances of points (n, 3) from the plane, metres."""
        return np.asarray(xyz, np.float64) @ self.normal - self.height


@dataclass(frozen=True, slots=True, eq=False)
class _Near:
    """Points near a plane: ``numbers`` (n,), ``off`` (n,) metres from it, ``flat`` (n, 2) in it."""

    numbers: NDArray[np.int64]
    off: Vector
    flat: Vector


class Surface:
    """The points on a plane that hang together with ``hit`` (3,) local metres."""

    def __init__(
        self, points: Points, found: Plane, hit: Vector, radius: float, alive: Alive | None = None
    ) -> None:
        self._points, self._found, self._hit, self._alive = points, found, hit, alive
        self._beside = BESIDE * found.thick
        self._cell, self._square = radius / 2, 2 * radius
        self._blocks = self._blocks_near()
        self._kept: _Near | None = None
        self._bare = self._bare_cells()
        self._joined = self._joined_squares()
        self.count = sum(len(numbers) for numbers in self.parts())

    def parts(self) -> Iterator[NDArray[np.int64]]:
        """Their numbers, ascending."""
        for near in self._near():
            on = self._on(near)
            yield near.numbers[on][_among(_keys(near.flat[on], self._square), self._joined)]

    def thinned(self, most: int) -> Vector:
        """An even share of their coordinates (n, 3), at most ``most``."""
        step, seen = max(1, -(-self.count // most)), 0
        chosen = []
        for numbers in self.parts():
            chosen.append(self._points.xyz[numbers[-seen % step :: step]])
            seen += len(numbers)
        return np.concatenate(chosen).astype(np.float64)

    def _blocks_near(self) -> NDArray[np.int64]:
        """Blocks whose boxes come near enough to the plane."""
        found, beside = self._found, self._beside

        def touches(lo: NDArray[np.float32], hi: NDArray[np.float32]) -> NDArray[np.bool_]:
            half = (hi.astype(np.float64) - lo) / 2
            return np.asarray(np.abs(found.off(lo + half)) <= half @ np.abs(found.normal) + beside)

        return self._points.blocks_where(touches)

    def _near(self) -> Iterator[_Near]:
        """Points near the plane; gathered anew in each pass where they are many."""
        if self._kept is not None:
            yield self._kept
            return
        for blocks in self._points.groups(self._blocks):
            near = self._gather(blocks)
            if len(blocks) == len(self._blocks):
                self._kept = near
            yield near

    def _gather(self, blocks: NDArray[np.int64]) -> _Near:
        numbers = self._points.numbers(blocks)
        xyz = self._points.xyz[numbers]
        off = np.abs(self._found.off(xyz))
        near = off <= self._beside
        numbers, off, xyz = numbers[near], off[near], xyz[near]
        if self._alive is not None:
            living = self._alive(numbers)
            numbers, off, xyz = numbers[living], off[living], xyz[living]
        return _Near(numbers, off, self._flat(xyz))

    def _flat(self, xyz: NDArray[np.float32]) -> Vector:
        """Coordinates (n, 2) in the plane, with the hit at zero."""
        normal = self._found.normal
        aside = np.cross(normal, np.eye(3)[int(np.abs(normal).argmin())])
        aside /= np.linalg.norm(aside)
        axes = np.stack([aside, np.cross(normal, aside)], axis=1)
        return np.asarray((xyz - self._hit) @ axes)

    def _on(self, near: _Near) -> NDArray[np.bool_]:
        """Return the points on the plane where nothing stands on it, as a mask."""
        on = near.off <= self._found.thick
        on[on] = _among(_keys(near.flat[on], self._cell), self._bare)
        return on

    def _bare_cells(self) -> Keys:
        """Cells where no more points lie beside the surface than on it: nothing stands there."""
        keys, on, beside = [np.empty(0, np.int64)], [np.empty(0, np.intp)], [np.empty(0, np.intp)]
        for near in self._near():
            cells, cell = np.unique(_keys(near.flat, self._cell), return_inverse=True)
            here = near.off <= self._found.thick
            keys.append(cells)
            on.append(np.bincount(cell[here], minlength=len(cells)))
            beside.append(np.bincount(cell[~here], minlength=len(cells)))
        cells, cell = np.unique(np.concatenate(keys), return_inverse=True)
        n = len(cells)
        counts = [np.bincount(cell, np.concatenate(part), n) for part in (on, beside)]
        return np.asarray(cells[counts[0] >= counts[1]])

    def _joined_squares(self) -> Keys:
        """Squares that join, corner to corner, with the one nearest to the hit."""
        found, nearest, start = [np.empty(0, np.int64)], np.inf, 0
        for near in self._near():
            flat = near.flat[self._on(near)]
            if len(flat) == 0:
                continue
            keys, away = _keys(flat, self._square), (flat**2).sum(axis=1)
            found.append(np.unique(keys))
            closest = int(away.argmin())
            if away[closest] < nearest:
                nearest, start = float(away[closest]), int(keys[closest])
        squares = np.unique(np.concatenate(found))
        return squares[_joined_with(squares, start)]


def _keys(flat: Vector, size: float) -> Keys:
    """One number for each square of ``size`` metres."""
    column = np.floor(flat / size).astype(np.int64)
    return np.asarray(column[:, 0] * 2**31 + column[:, 1])


def _among(keys: Keys, those: Keys) -> NDArray[np.bool_]:
    """Return the keys (n,) that are among sorted ``those``, as a mask."""
    if len(those) == 0:
        return np.zeros(len(keys), np.bool_)
    at = np.minimum(np.searchsorted(those, keys), len(those) - 1)
    return np.asarray(those[at] == keys)


def _joined_with(squares: Keys, start: int) -> NDArray[np.bool_]:
    """Return the sorted squares that are connected with the square ``start``, as a mask."""
    if len(squares) == 0:
        return np.empty(0, np.bool_)
    links = []
    for step in (1, 2**31 - 1, 2**31, 2**31 + 1):
        at = np.minimum(np.searchsorted(squares, squares + step), len(squares) - 1)
        joined = np.flatnonzero(squares[at] == squares + step)
        links.append(np.stack([joined, at[joined]]))
    one, other = np.concatenate(links, axis=1)
    ones = np.ones(len(one), np.bool_)
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    _, part = connected_components(coo_array((ones, (one, other)), shape=(len(squares),) * 2))
    return np.asarray(part == part[np.searchsorted(squares, start)])
