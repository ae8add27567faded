"""Ground and walls: the flat surface that a ray meets, as far as it hangs together.

A plane is fitted round the point that was met by least squares over ever wider surroundings, each
time with the points near the plane found so far (iterative trimming); where the first
surroundings hold an edge, the best of a fixed set of planes through the point begins (the
hypotheses of RANSAC, Fischler and Bolles 1981, without its dice).  Nothing here is random.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.points import NOTHING, Points
from pointbrush.selection.ray import Alive
from pointbrush.selection.regions import region_shape
from pointbrush.selection.sphere import swept_ball
from pointbrush.selection.surface import Plane, Surface

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


def plane(
    points: Points, hit: Vector, radius: float, alive: Alive | None = None
) -> Iterator[NDArray[np.int64]]:
    """Numbers of the points of the flat surface that holds ``hit`` (3,) local metres; in parts.

    The surface is as thick as its noise, at most half of ``radius``.  Gaps up to twice the
    radius are bridged, and what stands on it or passes through it is left out.
    """
    found = fit_plane(points, hit, radius, alive)
    if found is None:
        return
    for _ in range(2):
        # What hangs together decides the plane anew: a floor is known better as a whole.
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


def _thin(xyz: NDArray[np.float32]) -> Vector:
    """An even share of the points, as float64."""
    return xyz[:: -(-len(xyz) // MOST)].astype(np.float64)


PLANE = region_shape("plane", "The flat surface round each place met: ground, a wall.", plane)
