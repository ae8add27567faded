"""Ground and walls: the flat surface that a ray meets, as far as it hangs together.

A plane is fitted round the point that was met by least squares over ever wider surroundings, each
time with the points near the plane found so far (iterative trimming); where the first
surroundings hold an edge, the best of a fixed set of planes through the point begins (the
hypotheses of RANSAC, Fischler and Bolles 1981, without its dice).  Nothing here is random.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from pointbrush.selection.points import Points
from pointbrush.selection.ray import Alive
from pointbrush.selection.sphere import swept_ball

Vector = NDArray[np.float64]

HYPOTHESES = 24
"""Points round the hit whose pairs, with the hit, are the first planes."""
WIDENING = (1.0, 2.0, 4.0, 8.0)
"""Surroundings of the fit, in brush radii."""
MOST = 20_000
"""Points that a fit looks at."""
ENOUGH = 30
"""Points that a first plane is fitted to: with fewer the noise tilts it."""
THINNEST, SEARCHED, THICKEST = 0.02, 0.2, 0.5
"""Least half thickness of the surface, of the slab it is searched in, and the greatest one."""
DEVIATIONS = 3.0
NOISE = 1.4826
"""Standard deviations for one median absolute deviation, normal noise."""
BESIDE = 4.0
"""What stands on a surface shows within so many of its thicknesses."""


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """``normal`` (3,) of length 1; ``normal · p = height``; points within ``thick`` are on it."""

    normal: Vector
    height: float
    thick: float

    def off(self, xyz: NDArray[np.floating]) -> Vector:
        """Signed distances of points (n, 3) from the plane, metres."""
        return np.asarray(xyz, np.float64) @ self.normal - self.height


def plane(
    points: Points, hit: Vector, radius: float, alive: Alive | None = None
) -> NDArray[np.int64]:
    """Numbers of the points of the flat surface that holds ``hit`` (3,) local metres; sorted.

    The surface is as thick as its noise, at most half of ``radius``.  Gaps up to twice the
    radius are bridged, and what stands on it or passes through it is left out.
    """
    found = fit_plane(points, hit, radius, alive)
    if found is None:
        return np.empty(0, np.int64)
    numbers = np.empty(0, np.int64)
    for _ in range(2):
        # What hangs together decides the plane anew: a floor is known better as a whole.
        numbers = _surface(points, found, hit, radius, alive)
        if len(numbers) < 3:
            return numbers
        found = _least_squares(_thin(points.xyz[numbers]), found, radius)
    return _surface(points, found, hit, radius, alive)


def fit_plane(
    points: Points, hit: Vector, radius: float, alive: Alive | None = None
) -> Plane | None:
    """The plane round a place (3,), local metres; None where fewer than three points are near.

    It is fitted to what lies within eight ``radius`` of the place.
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
    """The plane through the hit and two points near it that most points are on."""
    nearest = near[np.argmin(((near - hit) ** 2).sum(axis=1))]
    some = near[np.linspace(0, len(near) - 1, min(len(near), HYPOTHESES)).astype(int)] - nearest
    a, b = np.triu_indices(len(some), 1)
    normals = np.cross(some[a], some[b])
    length = np.linalg.norm(normals, axis=1)
    # Nearly in line: no plane.
    good = length > 1e-3 * radius * radius
    if not good.any():
        normals, length, good = np.eye(3)[1:2], np.ones(1), np.ones(1, np.bool_)
    normals = normals[good] / length[good, None]
    thick = SEARCHED * radius
    on = np.abs((near - nearest) @ normals.T) < thick
    normal = normals[int(on.sum(axis=0).argmax())]
    return Plane(normal, float(normal @ nearest), thick)


def _least_squares(near: Vector, before: Plane, radius: float) -> Plane:
    """The plane through the points on ``before``, and how far they scatter about it."""
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


def _surface(
    points: Points, found: Plane, hit: Vector, radius: float, alive: Alive | None
) -> NDArray[np.int64]:
    """Numbers of the points on a plane that hang together with ``hit``; sorted."""
    beside = BESIDE * found.thick
    numbers = points.numbers(_blocks_near(points, found, beside))
    xyz = points.xyz[numbers]
    off = np.abs(found.off(xyz))
    near = off <= beside
    numbers, off, flat = numbers[near], off[near], _flat(found, xyz[near], hit)
    if alive is not None:
        living = alive(numbers)
        numbers, off, flat = numbers[living], off[living], flat[living]
    on = off <= found.thick
    # 1. Where more points lie beside the surface than on it, something stands there.
    cells, cell = np.unique(_keys(flat, radius / 2), return_inverse=True)
    bare = np.bincount(cell[on], minlength=len(cells)) >= np.bincount(
        cell[~on], minlength=len(cells)
    )
    on &= bare[cell]
    # 2. What hangs together with the place that was met.
    return np.asarray(numbers[on][_together(flat[on], 2 * radius)])


def _blocks_near(points: Points, found: Plane, beside: float) -> NDArray[np.int64]:
    """Blocks whose boxes come within ``beside`` of the plane."""

    def touches(lo: NDArray[np.float32], hi: NDArray[np.float32]) -> NDArray[np.bool_]:
        half = (hi.astype(np.float64) - lo) / 2
        return np.asarray(np.abs(found.off(lo + half)) <= half @ np.abs(found.normal) + beside)

    return points.blocks_where(touches)


def _flat(found: Plane, xyz: NDArray[np.float32], hit: Vector) -> Vector:
    """Coordinates (n, 2) in the plane, with the hit at zero."""
    aside = np.cross(found.normal, np.eye(3)[int(np.abs(found.normal).argmin())])
    aside /= np.linalg.norm(aside)
    axes = np.stack([aside, np.cross(found.normal, aside)], axis=1)
    return np.asarray((xyz - hit) @ axes)


def _keys(flat: Vector, size: float) -> NDArray[np.int64]:
    """One number for each square of ``size`` metres."""
    column = np.floor(flat / size).astype(np.int64)
    return np.asarray(column[:, 0] * 2**31 + column[:, 1])


def _together(flat: Vector, size: float) -> NDArray[np.bool_]:
    """Which points lie in squares that join, corner to corner, with the one nearest to zero."""
    if len(flat) == 0:
        return np.empty(0, np.bool_)
    squares, square = np.unique(_keys(flat, size), return_inverse=True)
    links = []
    for step in (1, 2**31 - 1, 2**31, 2**31 + 1):
        at = np.minimum(np.searchsorted(squares, squares + step), len(squares) - 1)
        joined = np.flatnonzero(squares[at] == squares + step)
        links.append(np.stack([joined, at[joined]]))
    one, other = np.concatenate(links, axis=1)
    ones = np.ones(len(one), np.bool_)
    _, part = connected_components(coo_array((ones, (one, other)), shape=(len(squares),) * 2))
    start = square[int((flat**2).sum(axis=1).argmin())]
    return np.asarray(part[square] == part[start])


def _thin(xyz: NDArray[np.float32]) -> Vector:
    """An even share of the points, as float64."""
    return xyz[:: -(-len(xyz) // MOST)].astype(np.float64)
