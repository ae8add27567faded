"""The ray brush: a ball round the first surface that each ray meets, or all along the ray."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.points import Points
from pointbrush.selection.sphere import swept_parts

Alive = Callable[[NDArray[np.int64]], NDArray[np.bool_]]
"""Says of point numbers whether each can be hit (a deleted point cannot)."""


def ray_balls(
    points: Points,
    origins: NDArray[np.float64],
    directions: NDArray[np.float64],
    radius: float,
    alive: Alive | None = None,
) -> Iterator[NDArray[np.int64]]:
    """Numbers of the points within ``radius`` of the first hit of a ray; parts, each sorted."""
    hits = first_hits(points, origins, directions, radius, alive)
    for hit in hits[np.isfinite(hits[:, 0])]:
        yield from swept_parts(points, hit[None], radius)


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
    """Where each ray first meets the surface: (S, 3) local metres, NaN where it meets nothing.

    A cloud has holes between its points, so a point counts as surface met when the ray passes it
    within about the cloud's own spacing there, and never farther than ``radius``.
    """
    hits = np.full((len(origins), 3), np.nan)
    for k, (origin, direction) in enumerate(zip(origins, directions, strict=True)):
        along = _first_along(points, origin, direction, radius, alive)
        if np.isfinite(along):
            hits[k] = origin + along * direction
    return hits


def _first_along(
    points: Points,
    origin: NDArray[np.float64],
    direction: NDArray[np.float64],
    radius: float,
    alive: Alive | None,
) -> float:
    """How far along a ray the surface is met; infinity when it is not."""
    first_near = first_met = np.inf
    for blocks in points.groups(_blocks_on_ray(points, origin, direction, radius)):
        numbers = points.numbers(blocks)
        counts = points.blocks.first[blocks + 1] - points.blocks.first[blocks]
        reach = np.repeat(np.clip(points.spacing(blocks), 0.05 * radius, radius), counts)
        along, off = _along_and_off(points.xyz[numbers], origin, direction)
        met = (along > 0) & (off <= radius)
        if alive is not None:
            met[met] = alive(numbers[met])
        first_met = min(first_met, along[met].min(initial=np.inf))
        first_near = min(first_near, along[met & (off <= reach)].min(initial=np.inf))
    # Sparse clouds: where nothing lies within the spacing, the brush's own width decides.
    return float(first_near if np.isfinite(first_near) else first_met)


def _blocks_on_ray(
    points: Points, origin: NDArray[np.float64], direction: NDArray[np.float64], radius: float
) -> NDArray[np.int64]:
    """Blocks whose boxes, grown by ``radius``, the ray enters (slab method)."""
    with np.errstate(divide="ignore"):
        inverse = 1.0 / direction

    def touches(lo: NDArray[np.float32], hi: NDArray[np.float32]) -> NDArray[np.bool_]:
        with np.errstate(invalid="ignore"):
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
