"""Ground and walls: the connected flat surface that a ray hits.

A plane is fitted to the hit's neighbourhood by least squares, with increasing radii and the points
near the current plane (iterative trimming).  If the first neighbourhood has an edge, the fit starts
from the best of a fixed set of planes through the point (hypotheses as in RANSAC, Fischler and
Bolles 1981, but deterministic).
The connected part is found in several passes over the points near the plane.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.points import NOTHING, Alive, Points
from pointbrush.selection.ray import region_shape
from pointbrush.selection.sphere import swept_ball

Vector = NDArray[np.float64]
Keys = NDArray[np.int64]

BESIDE = 4.0
"""Distance, in thicknesses of a surface, within which objects on it are detected."""

HYPOTHESES = 24
"""Number of points around the hit; pairs of them define, with the hit, the first planes."""
WIDENING = (1.0, 2.0, 4.0, 8.0)
"""Neighbourhoods of the fit, in brush radii."""
MOST = 20_000
"""Maximum points of a fit."""
ENOUGH = 30
"""Minimum points of a first plane: with fewer, noise tilts it."""
THINNEST, SEARCHED, THICKEST = 0.02, 0.2, 0.5
"""Half thicknesses of a surface: minimum, of the searched slab, and maximum."""
DEVIATIONS = 3.0
NOISE = 1.4826
"""Ratio of standard deviation to median absolute deviation of normal noise."""


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """``normal`` (3,): unit vector; ``normal · p = height``; points within ``thick`` are on it."""

    normal: Vector
    height: float
    thick: float

    def off(self, xyz: NDArray[np.floating]) -> Vector:
        """Return signed distances of points (n, 3) from the plane, in metres."""
        return np.asarray(xyz, np.float64) @ self.normal - self.height


@dataclass(frozen=True, slots=True, eq=False)
class _Near:
    """Points near a plane: ``numbers`` (n,), distances ``off`` (n,), and ``flat`` (n, 2) in it."""

    numbers: NDArray[np.int64]
    off: Vector
    flat: Vector


class Surface:
    """The points on a plane connected with ``hit`` (3,), in local metres."""

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
        """Yield their numbers, ascending."""
        for near in self._near():
            on = self._on(near)
            yield near.numbers[on][_among(_keys(near.flat[on], self._square), self._joined)]

    def thinned(self, most: int) -> Vector:
        """Return a uniform sample of at most ``most`` of their coordinates (n, 3)."""
        step, seen = max(1, -(-self.count // most)), 0
        chosen = []
        for numbers in self.parts():
            chosen.append(self._points.xyz[numbers[-seen % step :: step]])
            seen += len(numbers)
        return np.concatenate(chosen).astype(np.float64)

    def _blocks_near(self) -> NDArray[np.int64]:
        """Return the blocks with boxes near the plane."""
        found, beside = self._found, self._beside

        def touches(lo: NDArray[np.float32], hi: NDArray[np.float32]) -> NDArray[np.bool_]:
            half = (hi.astype(np.float64) - lo) / 2
            return np.asarray(np.abs(found.off(lo + half)) <= half @ np.abs(found.normal) + beside)

        return self._points.blocks_where(touches)

    def _near(self) -> Iterator[_Near]:
        """Yield points near the plane; many points are gathered again in each pass."""
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
        """Return coordinates (n, 2) in the plane, with the hit at zero."""
        normal = self._found.normal
        aside = np.cross(normal, np.eye(3)[int(np.abs(normal).argmin())])
        aside /= np.linalg.norm(aside)
        axes = np.stack([aside, np.cross(normal, aside)], axis=1)
        return np.asarray((xyz - self._hit) @ axes)

    def _on(self, near: _Near) -> NDArray[np.bool_]:
        """Return a mask of the points on the plane, without places with objects on it."""
        on = near.off <= self._found.thick
        on[on] = _among(_keys(near.flat[on], self._cell), self._bare)
        return on

    def _bare_cells(self) -> Keys:
        """Return cells without objects: at most as many points are beside the surface as on it."""
        keys, on, beside = [np.empty(0, np.int64)], [np.empty(0, np.intp)], [np.empty(0, np.intp)]
        for near in self._near():
            cells, cell = np.unique(_keys(near.flat, self._cell), return_inverse=True)
            on_plane = near.off <= self._found.thick
            keys.append(cells)
            on.append(np.bincount(cell[on_plane], minlength=len(cells)))
            beside.append(np.bincount(cell[~on_plane], minlength=len(cells)))
        cells, cell = np.unique(np.concatenate(keys), return_inverse=True)
        n = len(cells)
        counts = [np.bincount(cell, np.concatenate(part), n) for part in (on, beside)]
        return np.asarray(cells[counts[0] >= counts[1]])

    def _joined_squares(self) -> Keys:
        """Return squares connected, also at corners, with the one nearest to the hit."""
        found, nearest, start = [np.empty(0, np.int64)], np.inf, 0
        for near in self._near():
            flat = near.flat[self._on(near)]
            if len(flat) == 0:
                continue
            keys, square = _keys(flat, self._square), (flat**2).sum(axis=1)
            found.append(np.unique(keys))
            closest = int(square.argmin())
            if square[closest] < nearest:
                nearest, start = float(square[closest]), int(keys[closest])
        squares = np.unique(np.concatenate(found))
        return squares[_joined_with(squares, start)]


def _keys(flat: Vector, size: float) -> Keys:
    """Return a unique number of each square of ``size`` metres."""
    column = np.floor(flat / size).astype(np.int64)
    return np.asarray(column[:, 0] * 2**31 + column[:, 1])


def _among(keys: Keys, present: Keys) -> NDArray[np.bool_]:
    """Return a mask of the keys (n,) that occur in the sorted second array."""
    if len(present) == 0:
        return np.zeros(len(keys), np.bool_)
    at = np.minimum(np.searchsorted(present, keys), len(present) - 1)
    return np.asarray(present[at] == keys)


def _joined_with(squares: Keys, start: int) -> NDArray[np.bool_]:
    """Return a mask of the sorted squares connected with the square ``start``."""
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


def plane(
    points: Points, hit: Vector, radius: float, alive: Alive | None = None
) -> Iterator[NDArray[np.int64]]:
    """Yield numbers of the points of the flat surface at ``hit`` (3,), in local metres, in parts.

    The surface is as thick as its noise, at most half of ``radius``.  Gaps up to twice the radius
    are bridged; objects on the surface or through it are left out.
    """
    found = fit_plane(points, hit, radius, alive)
    if found is None:
        return
    for _ in range(2):
        # The plane is refitted to its connected part, as a whole floor is more accurate.
        surface = Surface(points, found, hit, radius, alive)
        if surface.count < 3:
            yield from surface.parts()
            return
        yield NOTHING
        found = _least_squares(surface.thinned(MOST), found, radius)
    yield NOTHING
    yield from Surface(points, found, hit, radius, alive).parts()


def fit_plane(
    points: Points, hit: Vector, radius: float, alive: Alive | None = None
) -> Plane | None:
    """Return the plane at a place (3,), in local metres; None: fewer than three points are near.

    It is fitted to points within eight times ``radius``.
    """
    found: Plane | None = None
    for wide in WIDENING:
        numbers = swept_ball(points, hit[None], wide * radius)
        if alive is not None:
            numbers = numbers[alive(numbers)]
        if len(numbers) < (3 if wide == WIDENING[-1] else ENOUGH):
            continue
        near = _thin(points.xyz[numbers])
        if found is None:
            found = _best_hypothesis(near, hit, radius)
        found = _least_squares(near, found, radius)
        found = replace(found, thick=max(found.thick, SEARCHED * radius))
    return found


def _best_hypothesis(near: Vector, hit: Vector, radius: float) -> Plane:
    """Return the plane with the most points, of planes through the hit and two points near it."""
    nearest = near[np.argmin(((near - hit) ** 2).sum(axis=1))]
    some = near[np.linspace(0, len(near) - 1, min(len(near), HYPOTHESES)).astype(int)] - nearest
    a, b = np.triu_indices(len(some), 1)
    normals = np.cross(some[a], some[b])
    length = np.linalg.norm(normals, axis=1)
    # Nearly collinear points define no plane.
    good = length > 1e-3 * radius * radius
    if not good.any():
        normals, length, good = np.eye(3)[1:2], np.ones(1), np.ones(1, np.bool_)
    normals = normals[good] / length[good, None]
    thick = SEARCHED * radius
    on = np.abs((near - nearest) @ normals.T) < thick
    normal = normals[int(on.sum(axis=0).argmax())]
    return Plane(normal, float(normal @ nearest), thick)


def _least_squares(near: Vector, before: Plane, radius: float) -> Plane:
    """Return the least-squares plane of the points on ``before``, with their scatter."""
    on = near[np.abs(before.off(near)) <= before.thick]
    if len(on) < 3:
        return before
    middle = on.mean(axis=0)
    normal = np.linalg.eigh((on - middle).T @ (on - middle))[1][:, 0]
    normal = normal if normal @ before.normal > 0 else -normal
    found = replace(before, normal=normal, height=float(normal @ middle))
    # Measured in a slab of twice the thickness, so that it can also become thicker.
    off = np.abs(found.off(near))
    noise = NOISE * float(np.median(off[off <= 2 * before.thick]))
    thick = float(np.clip(DEVIATIONS * noise, THINNEST * radius, THICKEST * radius))
    return replace(found, thick=thick)


def _thin(xyz: NDArray[np.float32]) -> Vector:
    """Return a uniform sample of the points, as float64."""
    return xyz[:: -(-len(xyz) // MOST)].astype(np.float64)


PLANE = region_shape("plane", "The flat surface round each place met: ground, a wall.", plane)
