"""Where a thing cannot be: places beside it through which the sensor has looked before.

A finger on a handle moves as the handle does, and may look like it.  But while the thing turned
in the air the sensor looked past it on every side, and where it saw what lies beyond, the thing
is not.  Source: space carving, Kutulakos and Seitz 2000, with depth in place of colour.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import minimum_filter

from pointbrush.compiled import compiled
from pointbrush.tracking.geometry.registration import carried, inverse, transform
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.options import LensOptions
from pointbrush.tracking.sensor.lens import Lens, Pixels, pixel
from pointbrush.tracking.sensor.view import View


@dataclass(frozen=True, slots=True, eq=False)
class Glimpse:
    """How deep the sensor saw around a thing in one frame.

    ``pose`` (4, 4) of the thing, ``T_world_lens`` (4, 4) or None; ``depth`` (H, W) the least
    of each pixel and its neighbours, 0 where one measured nothing; ``corner`` its first row
    and column in the image of ``lens``.
    """

    pose: F64
    T_world_lens: F64 | None
    lens: Lens
    corner: tuple[int, int]
    depth: F32

    def through(self, xyz: F64, beyond: float, options: LensOptions) -> Mask:
        """Whether points (M, 3) of the thing's own coordinates were looked through."""
        T = self.pose if self.T_world_lens is None else inverse(self.T_world_lens) @ self.pose
        return _through(
            self.lens.pixels, T, self.corner, self.depth, xyz, beyond, options.nearest_m
        )


@compiled
def _through(
    lens: Pixels,
    T: F64,
    corner: tuple[int, int],
    image: F32,
    xyz: F64,
    beyond: float,
    nearest_m: float,
) -> Mask:
    result = np.zeros(len(xyz), np.bool_)
    height, width = image.shape
    for i in range(len(xyz)):
        cell, depth = pixel(lens, carried(T, xyz[i, 0], xyz[i, 1], xyz[i, 2]), nearest_m)
        row, column = cell // lens.width - corner[0], cell % lens.width - corner[1]
        if cell >= 0 and 0 <= row < height and 0 <= column < width:
            result[i] = image[row, column] > depth + beyond
    return result


def glimpse(view: View, pose: F64, world: F64) -> Glimpse | None:
    """What ``view`` shows around a thing whose surface is at ``world`` (M, 3)."""
    options = view.options.surface
    if view.lens is None:
        return None
    cell = view.project(world).cell
    cell = cell[cell >= 0]
    if not len(cell):
        return None
    height, width = view.lens.shape
    row, column = np.divmod(cell, width)
    top, left = (
        max(int(row.min()) - options.carve_margin_px, 0),
        max(int(column.min()) - options.carve_margin_px, 0),
    )
    image = view.depth[:-1].reshape(height, width)
    part = image[
        top : int(row.max()) + options.carve_margin_px + 1,
        left : int(column.max()) + options.carve_margin_px + 1,
    ]
    part = np.nan_to_num(part, nan=0.0)
    least = minimum_filter(part, 3, mode="constant")
    return Glimpse(pose, view.T_world_lens, view.lens, (top, left), least)


def remember(glimpses: list[Glimpse], view: View, pose: F64, world: F64) -> None:
    """Add a glimpse where it shows the thing from another side; the oldest leaves."""
    # The thing hardly leaves its place in front of the sensor: what turns is the thing.
    options = view.options.surface
    turns = [float((earlier.pose[:3, :3] * pose[:3, :3]).sum() - 1.0) / 2.0 for earlier in glimpses]
    if turns and max(turns) > np.cos(np.radians(options.carve_turn_deg)):
        return
    new = glimpse(view, pose, world)
    if new is not None:
        glimpses.append(new)
        del glimpses[: -options.carve_views]


def carved(glimpses: list[Glimpse], view: View, pose: F64, points: I64, unit: float) -> Mask:
    """Which ``points`` (M,) lie where a thing at ``pose`` cannot be."""
    options = view.options
    votes = np.zeros(len(points), np.int64)
    if len(glimpses) >= options.surface.carve_min_views and len(points):
        own = transform(inverse(pose), view.xyz[points].astype(np.float64))
        for earlier in glimpses:
            votes += earlier.through(own, options.surface.carve_units * unit, options=options.lens)
    return np.asarray(votes >= options.surface.carve_min_views)
