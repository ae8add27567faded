"""The ray brush: a ball round the first surface that each ray meets, or all along the ray.

Shapes that take the region round each place that a ray meets stand on the same hits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.points import NOTHING, Alive, Points
from pointbrush.selection.shape import RADIUS, Flag, Parameter, Parts, Selecting, Shape
from pointbrush.selection.sphere import balls, swept_ball

RUN = 16
"""Rays that are worked on together: neighbours meet the same blocks."""
AT_ONCE = 1 << 16
"""Points that are compared with a run of rays at once."""
MARGIN, MARGIN_SQUARED = 1e-6, 1e-12
"""Of the squared radius, and of the greatest squared distance: more than float64 rounds."""
Region = Callable[[Points, NDArray[np.float64], float, Alive | None], Parts]
"""Points, a place (3,) local metres, radius, alive → the numbers of the region round the place."""


def ray_balls(at: Selecting) -> Iterator[NDArray[np.int64]]:
    """Numbers of the points within the radius of the first hit of a ray; parts, each sorted."""
    for run in runs(len(at.origins)):
        hits = places_met(at, run)
        yield from balls(at.points, hits[np.isfinite(hits[:, 0])], at.radius)


def places_met(at: Selecting, run: slice) -> NDArray[np.float64]:
    """Return the points (n, 3) in which rays meet the surface, local metres; NaN: none."""
    if at.met is not None:
        return at.met[run]
    return first_hits(at.points, at.origins[run], at.directions[run], at.radius, at.alive)


def ray_tubes(
    points: Points,
    origins: NDArray[np.float64],
    directions: NDArray[np.float64],
    radius: float,
) -> Iterator[NDArray[np.int64]]:
    """Numbers of the points within ``radius`` of a half-line; parts, each sorted."""
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
    """Return the points (S, 3) in which rays first meet the surface, local metres; NaN: none.

    A cloud has holes between its points, so a point counts as surface met when the ray passes it
    within about the cloud's own spacing there, and never farther than ``radius``.
    """
    along = np.empty(len(origins))
    # Rays from places as far away as numbers go meet nothing, which infinity and NaN say as well.
    with np.errstate(over="ignore", invalid="ignore"):
        for run in runs(len(origins)):
            along[run] = _first_along(points, origins[run], directions[run], radius, alive)
    hits = np.full((len(origins), 3), np.nan)
    met = np.isfinite(along)
    hits[met] = origins[met] + along[met, None] * directions[met]
    return hits


def runs(samples: int) -> Iterator[slice]:
    """Samples a few at a time: they are worked on together."""
    return (slice(start, start + RUN) for start in range(0, samples, RUN))


def _first_along(
    points: Points,
    origins: NDArray[np.float64],
    directions: NDArray[np.float64],
    radius: float,
    alive: Alive | None,
) -> NDArray[np.float64]:
    """Return the distances (S,) along rays to the surface; infinity where it is not met."""
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
    # Sparse clouds: where nothing lies within the spacing, the brush's own width decides.
    return np.where(np.isfinite(first_near), first_near, first_met)


def _near_rays(
    xyz: NDArray[np.float32],
    origins: NDArray[np.float64],
    directions: NDArray[np.float64],
    radius: float,
) -> Iterator[tuple[int, NDArray[np.intp]]]:
    """For each ray that some points may be within ``radius`` of, its number and theirs.

    All rays at once, by products of matrices, which round more than the exact distance does: what
    is left out is farther by a margin.
    """
    middle = xyz.mean(axis=0, dtype=np.float64)
    local = xyz - middle
    away = origins - middle
    along = local @ directions.T - np.einsum("ij,ij->i", away, directions)
    squares = np.einsum("ij,ij->i", local, local)[:, None] - 2.0 * (local @ away.T)
    squares += np.einsum("ij,ij->i", away, away)
    scale = max(float(np.abs(local).max(initial=0.0)), float(np.abs(away).max(initial=0.0)), radius)
    near = (
        squares - along * along <= (1.0 + MARGIN) * radius * radius + MARGIN_SQUARED * scale * scale
    )
    for k in np.flatnonzero(near.any(axis=0)).tolist():
        yield k, np.flatnonzero(near[:, k])


def _blocks_on_rays(
    points: Points, origins: NDArray[np.float64], directions: NDArray[np.float64], radius: float
) -> NDArray[np.int64]:
    """Blocks whose boxes, grown by ``radius``, one of the rays enters."""
    each = [
        _blocks_on_ray(points, origin, direction, radius)
        for origin, direction in zip(origins, directions, strict=True)
    ]
    return np.unique(np.concatenate(each)) if len(each) > 1 else each[0]


def _blocks_on_ray(
    points: Points, origin: NDArray[np.float64], direction: NDArray[np.float64], radius: float
) -> NDArray[np.int64]:
    """Blocks whose boxes, grown by ``radius``, the ray enters (slab method)."""
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
    """Distance of each point along the ray and off it, metres."""
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
            "through", Flag(), False, "take all points along the ray, not only the first surface"
        ),
    ),
    take=_take,
    meets=lambda values: not values["through"],
)


def region_shape(name: str, about: str, region: Region) -> Shape:
    """Return the shape that takes such a region round each hit."""

    def take(at: Selecting) -> Parts:
        points, radius = at.points, at.radius
        for run in runs(len(at.origins)):
            hits = places_met(at, run)
            for hit in hits[np.isfinite(hits[:, 0])]:
                near = swept_ball(points, hit[None], radius)
                # Dragging over a region that is already filled must not fill it again.
                if len(near) and not at.taken.has_any(near):
                    yield from region(points, hit, radius, at.alive)
            yield NOTHING

    return Shape(name, about, (RADIUS,), take=take, fills=True, meets=lambda _values: True)
