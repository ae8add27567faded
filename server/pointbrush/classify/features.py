"""Frame → cells, and numbers about the surroundings of each that hold at any other place.

Cells are counted once each, so that the density of points does not count; at every scale the
moments of the surroundings of a cell are interpolated between cubes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.bodies import NAMES as BODY
from pointbrush.classify.bodies import describe_bodies
from pointbrush.classify.grid import MOST, find, key_of, means, neighbours, number_cubes
from pointbrush.classify.ground import heights_over_opened
from pointbrush.classify.options import FeatureOptions
from pointbrush.compiled import compiled, innermost
from pointbrush.errors import BadInputError
from pointbrush.selection.objects.cells import height_over_ground, lab_of
from pointbrush.selection.objects.graph import eigenvalues, eigenvector
from pointbrush.selection.objects.options import GroundOptions, ObjectOptions
from pointbrush.selection.objects.preparing import part_frame
from pointbrush.selection.objects.state import ObjectFrame
from pointbrush.sensor_kind import SensorKind

Floats = NDArray[np.float64]
Features = NDArray[np.float32]

SHAPE = (
    "cells", "line", "plane", "ball", "level", "steep", "size", "above", "thick", "aside",
)  # fmt: skip
"""Numbers of a level: how many cells, how they lie, which way, and where the cell is among them."""
COLOUR = ("light", "red", "yellow")
MOMENTS = 10


@dataclass(frozen=True, slots=True, eq=False)
class ExampleFrame:
    """Points of a frame: ``xyz`` (N, 3) metres, z up; the others (N, …) or None.

    ``rgb`` uint8; ``intensity`` in the sensor's unit; ``returns`` (N, 2) number of the return and
    how many its pulse had; ``viewpoint`` (3,) of the ``sensor``, None for many.
    """

    xyz: NDArray[np.floating]
    rgb: NDArray[np.uint8] | None = None
    intensity: NDArray[np.floating] | None = None
    returns: NDArray[np.floating] | None = None
    viewpoint: Floats | None = None
    sensor: SensorKind = "room"

    def check(self) -> None:
        """Raise BadInputError unless arrays fit each other and coordinates are finite."""
        n = len(self.xyz)
        if self.xyz.shape != (n, 3) or not np.isfinite(self.xyz).all():
            raise BadInputError(f"xyz: expected finite coordinates (N, 3), got {self.xyz.shape}")
        for name in ("rgb", "intensity", "returns"):
            column = getattr(self, name)
            if column is not None and len(column) != n:
                raise BadInputError(f"{name}: expected {n} values, got {len(column)}")


@dataclass(frozen=True, slots=True, eq=False)
class Described:
    """C cells of a frame: ``of_point`` (N,) the cell of each point, ``center`` (C, 3) metres,
    ``near`` (C, 26) neighbouring cells or -1, ``features`` (C, F) as ``feature_names`` has them.
    ``piece`` (C,) numbers the surface that each cell lies in, empty in scans of many views.
    """

    size: float
    of_point: NDArray[np.int32]
    center: NDArray[np.float32]
    near: NDArray[np.int32]
    features: Features
    piece: NDArray[np.int32]

    @property
    def nbytes(self) -> int:
        """Bytes of all arrays."""
        every = (self.of_point, self.center, self.near, self.features, self.piece)
        return sum(each.nbytes for each in every)


def feature_names(options: FeatureOptions) -> tuple[str, ...]:
    """Return the names of the columns, in their order."""
    names = [f"{name} {level}" for level in range(options.levels) for name in SHAPE]
    names += [f"over opened {columns}" for columns in options.openings]
    names += [f"over ground {slope}" for slope in options.slopes]
    names += [f"{name} {edge}" for edge in options.bodies for name in BODY]
    names += ["points", *COLOUR, "intensity", "first return", "last return", "single return"]
    for level in options.coloured:
        names += [
            f"{name} {level}" for name in (*COLOUR, "spread", "intensity", "varied", "single")
        ]
    return tuple(names)


def scale_of(xyz: NDArray[np.floating], options: FeatureOptions) -> float:
    """Return the size of a cell, metres, for points (N, 3): a power of the root of two.

    Frames alike have the same.  Raises BadInputError for none.
    """
    if len(xyz) == 0:
        raise BadInputError("xyz: expected at least one point, got none")
    places = np.ascontiguousarray(xyz, np.float64)
    low = places.min(axis=0)
    extent = max(float(np.ptp(places, axis=0).max()), 1e-3)
    exponent = np.ceil(2 * np.log2(extent / 2**9))

    def cubes(exponent: float) -> int:
        return len(number_cubes(places, low, 2.0 ** (exponent / 2))[1])

    fewest = len(places) / options.points_per_cell
    most = min(fewest, options.most_cells)
    while cubes(exponent) > most:
        exponent += 1
    while 2.0 ** ((exponent - 1) / 2) > extent / MOST and cubes(exponent - 1) <= most:
        exponent -= 1
        if cubes(exponent) == len(places):
            break
    return float(2.0 ** (exponent / 2))


def describe(frame: ExampleFrame, size: float, options: FeatureOptions) -> Described:
    """Return a frame's cells of ``size`` metres and their features.  Raises BadInputError."""
    frame.check()
    xyz = np.ascontiguousarray(frame.xyz, np.float64)
    low = xyz.min(axis=0) if len(xyz) else np.zeros(3)
    size = max(size, float(np.ptp(xyz, axis=0).max()) / MOST if len(xyz) else size)
    of_point, keys, slots = number_cubes(xyz, low, size)
    count = len(keys)
    center = means(of_point, xyz - low, count)
    colour, strength, back = _tones(frame, of_point, count)
    tones = np.hstack([colour, strength, back[:, 2:]])
    held = np.bincount(of_point, minlength=count)[:, None]
    heights, floor = _heights(center, size, options), options.floor * size
    columns = [
        *(_shapes(center, size, size * 2.0 ** (level + 1)) for level in range(options.levels)),
        *(height[:, None] for height in heights_over_opened(center, size, options)),
        *(height[:, None] for height in heights),
        *(describe_bodies(center, heights[-1], floor, edge * size) for edge in options.bodies),
        *(np.log(np.maximum(held, 1)), colour, strength, back),
        *(_blurred(center, tones, size * 2.0 ** (level + 1)) for level in options.coloured),
    ]
    features = np.hstack(columns).astype(np.float32)
    near = neighbours(keys, slots)
    piece = np.zeros(0, np.int32)
    if frame.sensor != "room" and count:
        # Scans of many views have none: their pieces are smaller than the votes of neighbours.
        eye = None if frame.viewpoint is None else frame.viewpoint - low
        piece = _pieces(frame, low, eye, of_point, count)
    return Described(size, of_point, (center + low).astype(np.float32), near, features, piece)


def _pieces(
    frame: ExampleFrame, low: Floats, eye: Floats | None, of_point: NDArray[np.int32], count: int
) -> NDArray[np.int32]:
    """Number the object tool's piece of one surface (C,) that each cell lies in."""
    xyz = (frame.xyz - low).astype(np.float32)
    strength = None if frame.intensity is None else np.asarray(frame.intensity, np.float32)
    parts = part_frame(ObjectFrame(xyz, frame.rgb, strength, eye, frame.sensor), ObjectOptions())
    out = np.zeros(count, np.int32)
    out[of_point] = parts.piece[parts.of_point]
    return out


def _heights(center: Floats, size: float, options: FeatureOptions) -> list[Floats]:
    """Measure the heights (C,) over the ground as it may rise, the steepest last."""
    grounds = (
        GroundOptions(options.ground_column * size, slope=slope, fewest_points=2)
        for slope in options.slopes
    )
    return [height_over_ground(center, ground) for ground in grounds]


def _tones(
    frame: ExampleFrame, of_point: NDArray[np.int32], count: int
) -> tuple[Floats, Floats, Floats]:
    """Mean colour (C, 3) as CIE Lab, intensity (C, 1), and shares (C, 3) of kinds of returns."""

    def mean(values: NDArray[np.generic] | None, width: int) -> Floats:
        if values is None or not count:
            return np.zeros((count, width))
        return means(of_point, np.asarray(values, np.float64).reshape(-1, width), count)

    colour = np.zeros((count, 3)) if frame.rgb is None else lab_of(mean(frame.rgb, 3))
    back = None
    if frame.returns is not None:
        number, many = np.asarray(frame.returns).T
        back = np.stack([number <= 1, number >= many, many <= 1], axis=1)
    return colour, mean(frame.intensity, 1), mean(back, 3)


@compiled
def _shapes(center: Floats, cell: float, size: float) -> Floats:
    """Describe how cells lie round each, by the moments of cubes of ``size`` metres."""
    count = len(center)
    cube, keys, slots = number_cubes(center, np.zeros(3), size)
    sums = np.zeros((len(keys), MOMENTS))
    for c in range(count):
        row = sums[cube[c]]
        row[0] += 1
        at = 4
        for k in range(3):
            row[1 + k] += center[c, k]
            for m in range(k, 3):
                row[at] += center[c, k] * center[c, m]
                at += 1
    out = np.zeros((count, 10))
    total = np.zeros(MOMENTS)
    for c in range(count):
        _interpolate(center[c], size, keys, slots, sums, total)
        _shape(total, center[c], cell, size, out[c])
    return out


@innermost
def _interpolate(
    place: Floats, size: float, keys: NDArray[np.int64], slots: NDArray[np.int64],
    sums: Floats, total: Floats,
) -> None:  # fmt: skip
    """Interpolate the sums of the eight cubes around a place into ``total``."""
    total[:] = 0.0
    x, y, z = place[0] / size - 0.5, place[1] / size - 0.5, place[2] / size - 0.5
    i, j, k = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
    for dx in range(2):
        wx = x - i if dx else 1 - (x - i)
        for dy in range(2):
            wy = y - j if dy else 1 - (y - j)
            for dz in range(2):
                cube = find(slots, keys, key_of(i + dx, j + dy, k + dz))
                if cube >= 0:
                    weight = wx * wy * (z - k if dz else 1 - (z - k))
                    for m in range(len(total)):
                        total[m] += weight * sums[cube, m]


@innermost
def _shape(total: Floats, place: Floats, cell: float, size: float, out: Floats) -> None:
    n = total[0]
    if n <= 0:
        return
    mx, my, mz = total[1] / n, total[2] / n, total[3] / n
    xx, xy, xz = total[4] / n - mx * mx, total[5] / n - mx * my, total[6] / n - mx * mz
    yy, yz, zz = total[7] / n - my * my, total[8] / n - my * mz, total[9] / n - mz * mz
    low, middle, high = eigenvalues(xx, xy, xz, yy, yz, zz)
    low, middle, high = max(low, 0.0), max(middle, 0.0), max(high, 0.0)
    # The spread within a cell is unknown: it counts as isotropic and of the size of the cell.
    least = (0.1 * cell) ** 2
    a, b, c = np.sqrt(high + least), np.sqrt(middle + least), np.sqrt(low + least)
    out[0] = np.log1p(n)
    out[1], out[2], out[3] = (a - b) / a, (b - c) / a, c / a
    out[4] = abs(eigenvector(xx, xy, xz, yy, yz, zz, low)[2])
    out[5] = abs(eigenvector(xx, xy, xz, yy, yz, zz, high)[2])
    out[6] = a / size
    out[7] = (place[2] - mz) / size
    out[8] = np.sqrt(max(zz, 0.0)) / size
    dx, dy, dz = place[0] - mx, place[1] - my, place[2] - mz
    out[9] = np.sqrt(dx * dx + dy * dy + dz * dz) / size


@compiled
def _blurred(center: Floats, tones: Floats, size: float) -> Floats:
    """Mean colour (C, 3), its spread, mean intensity, its spread and single returns near a cell."""
    count = len(center)
    cube, keys, slots = number_cubes(center, np.zeros(3), size)
    sums = np.zeros((len(keys), 8))
    for c in range(count):
        row = sums[cube[c]]
        row[0] += 1
        for k in range(4):
            row[1 + k] += tones[c, k]
        row[5] += tones[c, 0] ** 2
        row[6] += tones[c, 3] ** 2
        row[7] += tones[c, 4]
    out, total = np.zeros((count, 7)), np.zeros(8)
    for c in range(count):
        _interpolate(center[c], size, keys, slots, sums, total)
        n = max(total[0], 1e-12)
        for k in range(3):
            out[c, k] = total[1 + k] / n
        out[c, 3] = np.sqrt(max(total[5] / n - (total[1] / n) ** 2, 0.0))
        out[c, 4] = total[4] / n
        out[c, 5] = np.sqrt(max(total[6] / n - (total[4] / n) ** 2, 0.0))
        out[c, 6] = total[7] / n
    return out
