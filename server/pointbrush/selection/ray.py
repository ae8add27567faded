"""The ray brush: a ball around the first hit of each ray, or a tube along the ray.

Shapes that take the region around each hit use the same hits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.points import NOTHING, Alive, Points
from pointbrush.selection.shape import FLAG, RADIUS, Parameter, Parts, Selecting, Shape
from pointbrush.selection.sphere import balls, swept_ball

RUN = 16
"""Number of rays of a batch: neighbouring rays intersect the same blocks."""
AT_ONCE = 1 << 16
"""Number of points compared with a batch of rays at once."""
MARGIN, MARGIN_SQUARED = 1e-6, 1e-12
"""Shares of the squared radius and of the maximum squared distance, above rounding of float64."""
Region = Callable[[Points, NDArray[np.float64], float, Alive | None], Parts]
"""Function of points, a place (3,) in local metres, radius and alive: numbers of the region."""


def ray_balls(at: Selecting) -> Iterator[NDArray[np.int64]]:
    """Yield numbers of the points within the radius of rays' first hits, in sorted parts."""
    for run in runs(len(at.origins)):
        hits = places_met(at, run)
        yield from balls(at.points, hits[np.isfinite(hits[:, 0])], at.radius)


def places_met(at: Selecting, run: slice) -> NDArray[np.float64]:
    """Return the hits (n, 3) of rays on the surface, in local metres; NaN: none."""
    if at.met is not None:
        return at.met[run]
    return first_hits(at.points, at.origins[run], at.directions[run], at.radius, at.alive)


def ray_tubes(
    points: Points,
    origins: NDArray[np.float64],
    directions: NDArray[np.float64],
    radius: float,
) -> Iterator[NDArray[np.int64]]:
    """Yield numbers of the points within ``radius`` of a half-line, in sorted parts."""
    for origin, direction in zip(origins, directions, strict=True):
        for blocks in points.groups(_blocks_on_ray(points, origin, direction, radius)):
            numbers = points.numbers(blocks)
            along, off = _along_and_off(points.xyz[numbers], origin, direction)
            yield numbers[(along >= 0) & (off <= radius)]


def first_hits(
    points: Points,
    origins: NDArray[np.float64],
    directions: NDArray[np.float64],
    radius: float,
    alive: Alive | None = None,
) -> NDArray[np.float64]:
    """Return the first hits (S, 3) of rays on the surface, in local metres; NaN: none.

    A cloud has holes between its points.  A point counts as hit if the ray passes within about the
    local spacing of the cloud, limited to ``radius``.
    """
    along = np.empty(len(origins))
    # Rays from extremely distant origins have no hit: overflows to inf and NaN are correct.
    with np.errstate(over="ignore", invalid="ignore"):
        for run in runs(len(origins)):
            along[run] = _first_along(points, origins[run], directions[run], radius, alive)
    hits = np.full((len(origins), 3), np.nan)
    met = np.isfinite(along)
    hits[met] = origins[met] + along[met, None] * directions[met]
    return hits


def runs(samples: int) -> Iterator[slice]:
    """Yield batches of samples."""
    return (slice(start, start + RUN) for start in range(0, samples, RUN))


def _first_along(
    points: Points,
    origins: NDArray[np.float64],
    directions: NDArray[np.float64],
    radius: float,
    alive: Alive | None,
) -> NDArray[np.float64]:
    """Return the distances (S,) along rays to the surface; inf without a hit."""
    first_near, first_met = np.full((2, len(origins)), np.inf)
    for blocks in points.groups(_blocks_on_rays(points, origins, directions, radius)):
        numbers = points.numbers(blocks)
        reach = np.clip(points.spacings(blocks, numbers), 0.05 * radius, radius)
        for start in range(0, len(numbers), AT_ONCE):
            part = slice(start, start + AT_ONCE)
            for k, near in _near_rays(points.xyz[numbers[part]], origins, directions, radius):
                found = numbers[part][near]
                along, off = _along_and_off(points.xyz[found], origins[k], directions[k])
                met = (along > 0) & (off <= radius)
                if alive is not None:
                    met[met] = alive(found[met])
                first_met[k] = min(first_met[k], along[met].min(initial=np.inf))
                met &= off <= reach[part][near]
                first_near[k] = min(first_near[k], along[met].min(initial=np.inf))
    # Sparse clouds: without a point within the spacing, the radius of the brush counts.
    return np.where(np.isfinite(first_near), first_near, first_met)


def _near_rays(
    xyz: NDArray[np.float32],
    origins: NDArray[np.float64],
    directions: NDArray[np.float64],
    radius: float,
) -> Iterator[tuple[int, NDArray[np.intp]]]:
    """Yield the numbers of each ray and of points that may be within ``radius`` of it.

    Matrix products for all rays have larger rounding errors than exact distances; a margin makes
    sure that no point is missed.
    """
    middle = xyz.mean(axis=0, dtype=np.float64)
    local = xyz - middle
    start = origins - middle
    along = local @ directions.T - np.einsum("ij,ij->i", start, directions)
    squares = np.einsum("ij,ij->i", local, local)[:, None] - 2.0 * (local @ start.T)
    squares += np.einsum("ij,ij->i", start, start)
    scale = max(
        float(np.abs(local).max(initial=0.0)), float(np.abs(start).max(initial=0.0)), radius
    )
    near = (
        squares - along * along <= (1.0 + MARGIN) * radius * radius + MARGIN_SQUARED * scale * scale
    )
    for k in np.flatnonzero(near.any(axis=0)).tolist():
        yield k, np.flatnonzero(near[:, k])


def _blocks_on_rays(
    points: Points, origins: NDArray[np.float64], directions: NDArray[np.float64], radius: float
) -> NDArray[np.int64]:
    """Return the blocks with boxes, grown by ``radius``, that one of the rays enters."""
    each = [
        _blocks_on_ray(points, origin, direction, radius)
        for origin, direction in zip(origins, directions, strict=True)
    ]
    return np.unique(np.concatenate(each)) if len(each) > 1 else each[0]


def _blocks_on_ray(
    points: Points, origin: NDArray[np.float64], direction: NDArray[np.float64], radius: float
) -> NDArray[np.int64]:
    """Return the blocks with boxes, grown by ``radius``, that the ray enters (slab method)."""
    with np.errstate(divide="ignore", over="ignore"):
        inverse = 1.0 / direction

    def touches(lo: NDArray[np.float32], hi: NDArray[np.float32]) -> NDArray[np.bool_]:
        with np.errstate(invalid="ignore", over="ignore"):
            a = (lo - radius - origin) * inverse
            b = (hi + radius - origin) * inverse
        # 0 * inf: the ray runs inside a slab's border plane, which the grown box includes.
        enter = np.nan_to_num(np.minimum(a, b), nan=-np.inf, posinf=np.inf, neginf=-np.inf)
        leave = np.nan_to_num(np.maximum(a, b), nan=np.inf, posinf=np.inf, neginf=-np.inf)
        first, last = enter.max(axis=1), leave.min(axis=1)
        return np.asarray((last >= first) & (last >= 0))

    return points.blocks_where(touches)


def _along_and_off(
    xyz: NDArray[np.float32], origin: NDArray[np.float64], direction: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the distance of each point along the ray and from it, in metres."""
    offset = xyz.astype(np.float64) - origin
    along = offset @ direction
    off = offset - along[:, None] * direction
    return along, np.sqrt(np.einsum("ij,ij->i", off, off))


def _take(at: Selecting) -> Parts:
    if at.values["through"]:
        return ray_tubes(at.points, at.origins, at.directions, at.radius)
    return ray_balls(at)


RAY = Shape(
    "ray",
    "A ball round the first surface that each ray meets, or all along the ray.",
    (
        RADIUS,
        Parameter(
            "through", FLAG, False, "take all points along the ray, not only the first surface"
        ),
    ),
    take=_take,
    meets=lambda values: not values["through"],
)


def region_shape(name: str, about: str, region: Region) -> Shape:
    """Return the shape that takes a region around each hit."""

    def take(at: Selecting) -> Parts:
        points, radius = at.points, at.radius
        for run in runs(len(at.origins)):
            hits = places_met(at, run)
            for hit in hits[np.isfinite(hits[:, 0])]:
                near = swept_ball(points, hit[None], radius)
                # Dragging over a filled region must not fill it again.
                if len(near) and not at.taken.has_any(near):
                    yield from region(points, hit, radius, at.alive)
            yield NOTHING

    return Shape(name, about, (RADIUS,), take=take, fills=True, meets=lambda _values: True)
