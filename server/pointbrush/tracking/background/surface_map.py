"""A chart of the scene that a depth camera on the move sees: small pieces of its surfaces.

Each frame's scene is drawn from the chart as its sensor would see it from where it is then.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.geometry.registration import transform
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.sensor.lens import Pixels
from pointbrush.tracking.sensor.view import View


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceMap:
    """Pieces of surfaces ``at`` (M, 3) in the world, with ``normal`` (M, 3) of any length."""

    at: F64
    normal: F64

    @staticmethod
    def of(view: View, depth: F32) -> SurfaceMap:
        """All that a depth image (cells + 1,) shows of what a frame's sensor sees."""
        at, normal = _pieces(
            depth,
            np.flatnonzero(np.isfinite(depth)),
            view.camera.pixels,
            view.options.mapping.outline_share,
        )
        T = view.T_picture_world
        return SurfaceMap(transform(np.linalg.inv(T), at), normal @ T[:3, :3])

    def drawn(self, view: View) -> F32:
        """(cells + 1,) the scene's depth as a frame's sensor would see it, NaN where unknown."""
        options = view.options.mapping
        image = _drawn(
            view.T_picture_world,
            self.at,
            self.normal,
            view.camera.pixels,
            options.closest_m,
            options.steep_share,
        )
        height, width = view.camera.shape
        _fill(image, height, width, options.filled_beside)
        return image

    def pick(self, keep: Mask) -> SurfaceMap:
        """Some of the pieces."""
        return SurfaceMap(self.at[keep], self.normal[keep])

    def __add__(self, other: SurfaceMap) -> SurfaceMap:
        """The pieces of both."""
        return SurfaceMap(np.vstack([self.at, other.at]), np.vstack([self.normal, other.normal]))


@compiled
def _pieces(depth: F32, cells: I64, lens: Pixels, outline_share: float) -> tuple[F64, F64]:
    """Places and normals, across, down and along, of the surface in some cells."""
    at, normal = np.empty((len(cells), 3)), np.empty((len(cells), 3))
    steps = (1, lens.width)
    for i in range(len(cells)):
        cell = cells[i]
        row, column = cell // lens.width, cell % lens.width
        z = float(depth[cell])
        x = lens.least[0] + lens.pitch[0] * column
        y = lens.least[1] + lens.pitch[1] * row
        slope = [0.0, 0.0]
        for axis in range(2):
            ends = (column, lens.width) if axis == 0 else (row, lens.height)
            if ends[0] == 0 or ends[0] == ends[1] - 1:
                continue
            before, after = float(depth[cell - steps[axis]]), float(depth[cell + steps[axis]])
            if abs(before - z) < outline_share * z and abs(after - z) < outline_share * z:
                slope[axis] = (1 / after - 1 / before) / (2 * lens.pitch[axis])
        at[i, 0], at[i, 1], at[i, 2] = x * z, y * z, z
        normal[i, 0], normal[i, 1] = slope[0], slope[1]
        normal[i, 2] = 1 / z - slope[0] * x - slope[1] * y
    return at, normal


@compiled
def _drawn(T: F64, at: F64, normal: F64, lens: Pixels, closest_m: float, steep_share: float) -> F32:
    """(cells + 1,) the nearest piece's depth at the middle of each cell."""
    image = np.full(lens.width * lens.height + 1, np.nan, np.float32)
    for i in range(len(at)):
        a, n = at[i], normal[i]
        z = T[2, 0] * a[0] + T[2, 1] * a[1] + T[2, 2] * a[2] + T[2, 3]
        if not z > closest_m:
            continue
        x = T[0, 0] * a[0] + T[0, 1] * a[1] + T[0, 2] * a[2] + T[0, 3]
        y = T[1, 0] * a[0] + T[1, 1] * a[1] + T[1, 2] * a[2] + T[1, 3]
        u = (x / z - lens.least[0]) / lens.pitch[0] + 0.5
        v = (y / z - lens.least[1]) / lens.pitch[1] + 0.5
        if not (u >= 0 and u < lens.width and v >= 0 and v < lens.height):
            continue
        p = T[0, 0] * n[0] + T[0, 1] * n[1] + T[0, 2] * n[2]
        q = T[1, 0] * n[0] + T[1, 1] * n[1] + T[1, 2] * n[2]
        r = T[2, 0] * n[0] + T[2, 1] * n[1] + T[2, 2] * n[2]
        across = p * (lens.least[0] + lens.pitch[0] * int(u))
        down = q * (lens.least[1] + lens.pitch[1] * int(v))
        middle = (p * x + q * y + r * z) / (across + down + r)
        if abs(middle - z) < steep_share * z:
            z = middle
        cell = int(v) * lens.width + int(u)
        if not image[cell] <= z:
            image[cell] = z
    return image


@compiled
def _fill(image: F32, height: int, width: int, filled_beside: int) -> None:
    """Close holes between pieces that lie farther apart than the pixels."""
    before = image.copy()
    for row in range(1, height - 1):
        for column in range(1, width - 1):
            cell = row * width + column
            if not np.isnan(before[cell]):
                continue
            count, total = 0, 0.0
            for down in (-width, 0, width):
                for along in (-1, 0, 1):
                    depth = before[cell + down + along]
                    if not np.isnan(depth):
                        count += 1
                        total += 1 / depth
            if count >= filled_beside:
                image[cell] = count / total
