"""A frame's points as a picture: colours, places and heights of a thinned pixel lattice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

Floats = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class DepthPicture:
    """Points of a depth camera in a lattice of every ``step``-th row and column.

    ``rgb`` (h, w, 3) without holes; ``seen`` (h, w) pixels with a point; ``xyz`` (h, w, 3) local
    metres, 0 without a point; ``depth`` (h, w) distance from the sensor; ``room`` (h, w, 3) room
    coordinates, y up from the floor; ``pitch`` width of a pixel at a depth of 1 m, metres.
    """

    rgb: NDArray[np.uint8]
    seen: NDArray[np.bool_]
    xyz: Floats
    depth: Floats
    room: Floats
    pitch: float
    step: int


def depth_picture(
    number: NDArray[np.int32], xyz: Floats, rgb: NDArray[np.uint8], eye: NDArray[np.float64],
    T_room_local: NDArray[np.float64], pitch: float, columns: int,
) -> DepthPicture:  # fmt: skip
    """Return the picture of points (N, 3) with colours (N, 3), seen from ``eye`` (3,).

    ``number`` (H, W) is the point of each pixel, -1 without one; ``pitch``: width of a pixel
    at a depth of 1 m; ``columns``: about the width of the picture.
    """
    step = max(1, round(number.shape[1] / columns))
    thinned = number[::step, ::step]
    seen = thinned >= 0
    point = np.maximum(thinned, 0)
    places = np.where(seen[..., None], xyz[point], np.float32(0))
    depth = np.linalg.norm(places - eye.astype(np.float32), axis=2)
    T = T_room_local.astype(np.float32)
    room = places @ T[:3, :3].T + T[:3, 3]
    return DepthPicture(filled(rgb[point], seen), seen, places, depth, room, pitch * step, step)


def filled(rgb: NDArray[np.uint8], seen: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Return a picture (h, w, 3) in which pixels without a colour have the nearest one's."""
    if seen.all() or not seen.any():
        return rgb
    row, column = distance_transform_edt(~seen, return_distances=False, return_indices=True)
    return np.asarray(rgb[row, column])


def points_of(
    mask: NDArray[np.bool_], picture: DepthPicture, number: NDArray[np.int32], xyz: Floats
) -> NDArray[np.int64]:
    """Return the points (n,) of a mask (h, w) of the thinned picture, ascending.

    A point between pixels of the thinned picture belongs to the nearest of them in space.
    """
    height, width = number.shape
    rows, columns = np.nonzero(mask)
    step, tall, wide = picture.step, *mask.shape
    top, stop = max(rows.min() - 1, 0) * step, min((rows.max() + 2) * step, height)
    left, end = max(columns.min() - 1, 0) * step, min((columns.max() + 2) * step, width)
    part = number[top:stop, left:end]
    row, column = np.nonzero(part >= 0)
    point = part[row, column]
    row, column = (row + top) // step, (column + left) // step
    below, beside = np.minimum(row + 1, tall - 1), np.minimum(column + 1, wide - 1)
    around = [(row, column), (row, beside), (below, column), (below, beside)]
    votes = sum(mask[place].astype(np.int8) for place in around)
    edge = np.flatnonzero((votes > 0) & (votes < len(around)))
    nearest, inside = np.full(len(edge), np.inf, np.float32), np.zeros(len(edge), np.bool_)
    for rows, columns in around:
        place = rows[edge], columns[edge]
        step_to = xyz[point[edge]] - picture.xyz[place]
        apart = np.einsum("ij,ij->i", step_to, step_to)
        closer = picture.seen[place] & (apart < nearest)
        nearest[closer], inside[closer] = apart[closer], mask[place][closer]
    found = np.concatenate([point[votes == len(around)], point[edge[inside]]])
    return np.sort(found).astype(np.int64)
