"""A person with a preview, simulated: clicks in the middle of what is wrong, strokes, levels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

Mask = NDArray[np.bool_]
MOST_TRIED, MOST_AROUND = 150, 3000
"""Points of a region, and of what surrounds it, that are looked at to find its middle."""
LEAST_POINTS = {"lidar": 50, "camera": 100, "room": 100}
"""Points of the smallest objects that count."""
MOST_OBJECTS = 30
"""Objects of a frame that are clicked, evenly chosen."""


def iou(one: Mask, other: Mask) -> float:
    """Intersection over union of two masks (N,)."""
    both = np.count_nonzero(one & other)
    return both / max(np.count_nonzero(one) + np.count_nonzero(other) - both, 1)


def as_mask(indices: NDArray[np.int64], count: int) -> Mask:
    """Mask (count,) of point numbers."""
    mask = np.zeros(count, np.bool_)
    mask[indices] = True
    return mask


def objects(instance: NDArray[np.int64], least: int) -> list[int]:
    """Instances of enough points."""
    numbers, counts = np.unique(instance[instance > 0], return_counts=True)
    found = numbers[counts >= least].tolist()
    return found[:: -(-len(found) // MOST_OBJECTS)] if found else []


def middle(xyz: NDArray[np.floating], region: Mask) -> NDArray[np.float64]:
    """Point (3,) of a region that is farthest from everything outside."""
    inside = np.flatnonzero(region)
    tried = inside[:: -(-len(inside) // MOST_TRIED)]
    low, high = xyz[inside].min(axis=0), xyz[inside].max(axis=0)
    margin = 0.25 * float((high - low).max()) + 0.05
    near = ((xyz > low - margin) & (xyz < high + margin)).all(axis=1) & ~region
    around = np.flatnonzero(near)
    if len(around) == 0:
        return np.asarray(xyz[tried[len(tried) // 2]], np.float64)
    around = around[:: -(-len(around) // MOST_AROUND)]
    away = cdist(xyz[tried], xyz[around]).min(axis=1)
    # Density thins far out: the middle of the region decides between equals.
    away -= 0.1 * np.linalg.norm(xyz[tried] - np.median(xyz[tried], axis=0), axis=1)
    return np.asarray(xyz[tried[int(away.argmax())]], np.float64)


def next_click(
    xyz: NDArray[np.floating], truth: Mask, mask: Mask | None
) -> tuple[NDArray[np.float64], bool] | None:
    """Click in the middle of the larger error, and whether it adds; None when all is right."""
    if mask is None:
        return middle(xyz, truth), True
    missing, surplus = truth & ~mask, mask & ~truth
    adds = bool(np.count_nonzero(missing) >= np.count_nonzero(surplus))
    region = missing if adds else surplus
    return (middle(xyz, region), adds) if region.any() else None


def stroke(
    xyz: NDArray[np.floating], truth: Mask, points: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Points (points, 3) along a stroke over the object: its middle and points about it, spread
    along its longest direction."""
    inside = xyz[truth].astype(np.float64)
    centre = inside.mean(axis=0)
    axis = np.linalg.svd(inside[:: max(1, len(inside) // 500)] - centre, full_matrices=False)[2][0]
    along = (inside - centre) @ axis
    marks = np.quantile(along, np.linspace(0.15, 0.85, points))
    aside = np.linalg.norm(inside - centre - along[:, None] * axis, axis=1)
    spread = aside.mean() + 1e-9
    picked = [
        int((np.abs(along - mark) / (along.std() + 1e-9) + 0.3 * aside / spread
             + 0.05 * rng.random(len(along))).argmin())
        for mark in marks
    ]  # fmt: skip
    return inside[picked]
