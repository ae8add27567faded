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
    coordinates, y up from the floor.
    """

    rgb: NDArray[np.uint8]
    seen: NDArray[np.bool_]
    xyz: Floats
    depth: Floats
    room: Floats
    step: int


def depth_picture(
    number: NDArray[np.int32], xyz: Floats, rgb: NDArray[np.uint8], eye: NDArray[np.float64],
    T_room_local: NDArray[np.float64], columns: int,
) -> DepthPicture:  # fmt: skip
    """Return the picture of points (N, 3) with colours (N, 3), seen from ``eye`` (3,).

    ``number`` (H, W) is the point of each pixel, -1 without one; ``columns``: about its width.
    """
    step = max(1, round(number.shape[1] / columns))
    thinned = number[::step, ::step]
    seen = thinned >= 0
    point = np.maximum(thinned, 0)
    places = np.where(seen[..., None], xyz[point], np.float32(0))
    depth = np.linalg.norm(places - eye.astype(np.float32), axis=2)
    T = T_room_local.astype(np.float32)
    room = places @ T[:3, :3].T + T[:3, 3]
    return DepthPicture(filled(rgb[point], seen), seen, places, depth, room, step)


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
    row, column = row + top, column + left
    nearest, inside = np.full(len(point), np.inf, np.float32), np.zeros(len(point), np.bool_)
    for down in (0, 1):
        for right in (0, 1):
            r = np.minimum(row // step + down, tall - 1)
            c = np.minimum(column // step + right, wide - 1)
            apart = np.linalg.norm(xyz[point] - picture.xyz[r, c], axis=1)
            closer = picture.seen[r, c] & (apart < nearest)
            nearest[closer], inside[closer] = apart[closer], mask[r, c][closer]
    return np.sort(point[inside]).astype(np.int64)
