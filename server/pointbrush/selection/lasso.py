"""The lasso: every point that a camera sees inside a polygon."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.points import Points
from pointbrush.selection.rigid import inverse
from pointbrush.selection.shape import Numbers, Parameter, Parts, Selecting, Shape, Values, Vertices


def lasso(
    points: Points, polygon: NDArray[np.float64], matrix: NDArray[np.float64]
) -> Iterator[NDArray[np.int64]]:
    """Yield sorted numbers of the points with a projection inside ``polygon``, in parts.

    ``polygon`` (V, 2) in normalised device coordinates, even-odd rule; ``matrix`` (4, 4)
    ``clip_from_local``.  Points behind the camera's near plane are never taken.
    """
    lo, hi = polygon.min(axis=0), polygon.max(axis=0)

    def touches(low: NDArray[np.float32], high: NDArray[np.float32]) -> NDArray[np.bool_]:
        corners = np.stack([low, high])
        pick = np.array(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij")).reshape(3, -1)
        boxes = corners[pick, :, np.arange(3)[:, None]].transpose(2, 1, 0)
        x, y, _, w = np.moveaxis(_project(boxes.reshape(-1, 3), matrix).reshape(-1, 8, 4), 2, 0)
        # A box is outside only when all its corners are on the outer side of one plane.
        outside = (x > hi[0] * w).all(1) | (x < lo[0] * w).all(1)
        outside |= (y > hi[1] * w).all(1) | (y < lo[1] * w).all(1) | (w <= 0).all(1)
        return np.asarray(~outside)

    for blocks in points.groups(points.blocks_where(touches)):
        numbers = points.numbers(blocks)
        x, y, z, w = _project(points.xyz[numbers], matrix).T
        seen = (w > 0) & (z >= -w)
        numbers, x, y = numbers[seen], x[seen] / w[seen], y[seen] / w[seen]
        boxed = (x >= lo[0]) & (x <= hi[0]) & (y >= lo[1]) & (y <= hi[1])
        numbers, x, y = numbers[boxed], x[boxed], y[boxed]
        yield numbers[inside_polygon(x, y, polygon)]


def inside_polygon(
    x: NDArray[np.float64], y: NDArray[np.float64], polygon: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Return a mask of points inside a polygon by the even-odd rule.

    An edge counts if the horizontal line to the right crosses it.
    """
    inside = np.zeros(len(x), np.bool_)
    for (x0, y0), (x1, y1) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if y0 == y1:
            continue
        crosses = (y0 > y) != (y1 > y)
        inside ^= crosses & (x < (x1 - x0) * ((y - y0) / (y1 - y0)) + x0)
    return inside


def _project(xyz: NDArray[np.float32], matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    return xyz.astype(np.float64) @ matrix[:, :3].T + matrix[:, 3]


def _take(at: Selecting) -> Parts:
    return lasso(at.points, at.values["polygon"], at.values["matrix"])


def _placed(values: Values, T_new_old: NDArray[np.float64]) -> Values:
    return {**values, "matrix": values["matrix"] @ inverse(T_new_old)}


LASSO = Shape(
    "lasso",
    "Points that a camera sees inside an outline.",
    (
        Parameter(
            "polygon",
            Vertices(3, 4096),
            None,
            "vertices in normalised device coordinates, x right and y up, -1..1",
        ),
        Parameter(
            "matrix",
            Numbers(4, 4),
            None,
            "`clip_from_source`, the camera's projection times view, row-major",
        ),
    ),
    take=_take,
    sampled=False,
    placed=_placed,
)
