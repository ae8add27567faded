"""Points → the pixels of a lattice that they lie on, and the order of its bands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.sequences.depth.codec import Image
from pointbrush.sequences.depth.lattice import FARTHEST, STRIP, Band, Lattice


class Found(NamedTuple):
    """Points in a lattice: ``pixel`` (N,) is each one's, row-major.

    ``number`` (height, width) is each pixel's point, -1 without one, and ``image`` its depth in
    units, 0 without one, with a margin.  ``error`` (3,) metres, the greatest along each axis.
    """

    pixel: NDArray[np.int64]
    number: NDArray[np.int32]
    image: Image
    error: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """A frame's points in a lattice: ``order`` (N,) puts them into the order of the bands.

    ``first`` (C + 1,) are the bands' boundaries in it.
    """

    found: Found
    order: NDArray[np.int64]
    first: NDArray[np.int64]


def empty_image(lattice: Lattice) -> Image:
    """An empty image with a margin, where neighbours beyond its edges are looked for."""
    margin = lattice.first_step
    return np.zeros((lattice.height + margin, lattice.width + margin), np.uint16)


def find(lattice: Lattice, xyz: NDArray[np.float32]) -> Found | None:
    """The pixels and depths of points (N, 3), local metres; None where they are on no lattice.

    Each pixel has one point at most, and no point lies beyond the image or ``FARTHEST``.
    """
    if not len(xyz):
        return None
    pixel, error = np.empty(len(xyz), np.int64), np.zeros(3)
    number = np.full((lattice.height, lattice.width), -1, np.int32)
    image = empty_image(lattice)
    axes = (lattice.axis, *lattice.sides)
    ray = (*lattice.tangent, *lattice.pitch, lattice.sign, lattice.unit)
    found = Found(pixel, number, image, error)
    return found if _find(xyz, axes, np.array(lattice.eye), ray, found) else None


@compiled
def _find(
    xyz: NDArray[np.float32],
    axes: tuple[int, int, int],
    eye: NDArray[np.float64],
    ray: tuple[float, float, float, float, float, float],
    found: Found,
) -> bool:
    """Fill in the arrays of ``found``; return False if a point has no separate pixel."""
    pixel, number, image, error = found
    along, across, down = axes
    left, top, right_step, down_step, sign, unit = ray
    height, width = number.shape
    along_off, across_off, down_off = 0.0, 0.0, 0.0
    for n in range(len(xyz)):
        distance = sign * (xyz[n, along] - eye[along])
        depth = np.rint(distance / unit)
        if not 1 <= depth <= FARTHEST:
            return False
        x, y = xyz[n, across] - eye[across], xyz[n, down] - eye[down]
        column = np.rint((x / distance - left) / right_step)
        row = np.rint((y / distance - top) / down_step)
        if not (0 <= column < width and 0 <= row < height):
            return False
        u, v = np.int64(column), np.int64(row)
        if number[v, u] >= 0:
            return False
        number[v, u], image[v, u] = n, np.int64(depth)
        pixel[n] = v * width + u
        rounded = depth * unit
        along_off = max(along_off, abs(distance - rounded))
        across_off = max(across_off, abs(x - rounded * (left + right_step * column)))
        down_off = max(down_off, abs(y - rounded * (top + down_step * row)))
    error[along], error[across], error[down] = along_off, across_off, down_off
    return True


def place(lattice: Lattice, xyz: NDArray[np.float32], most_error: float) -> Placed | None:
    """Find points (N, 3), local metres, in a lattice; return None if they fit no depth image.

    They fit if each point is within ``most_error`` metres of its pixel and each band has a point.
    """
    found = find(lattice, xyz)
    if found is None or found.error.max() > most_error:
        return None
    order, first = np.empty(len(xyz), np.int64), [0]
    for band in lattice.bands:
        first.append(visit(found.number, band, order, first[-1]))
        if first[-2] == first[-1]:
            return None
    return Placed(found, order, np.array(first, np.int64))


@compiled
def visit(number: NDArray[np.int32], band: Band, out: NDArray[np.int64], at: int) -> int:
    """Write a band's numbers (height, width) that are not negative, in the order of its points.

    They are written to ``out`` from ``at`` on; returns their end.
    """
    width = number.shape[1]
    for strip in range(band.row, band.stop, STRIP * band.down):
        end = min(strip + STRIP * band.down, band.stop)
        for column in range(band.column, width, band.across):
            for row in range(strip, end, band.down):
                if number[row, column] >= 0:
                    out[at] = number[row, column]
                    at += 1
    return at
