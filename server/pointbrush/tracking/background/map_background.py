"""What stood still before a depth camera on the move."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.ndimage import label

from pointbrush.tracking.background.depth_noise import DepthNoise
from pointbrush.tracking.background.pixel_tests import least
from pointbrush.tracking.background.point_background import PointBackground
from pointbrush.tracking.background.scenery import drawn_on
from pointbrush.tracking.background.surface_map import SurfaceMap
from pointbrush.tracking.geometry.near import close_to
from pointbrush.tracking.interface import F32, I64, Mask
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensor.view import View


class MapBackground(PointBackground):
    """The scene as it was charted over the whole run; elsewhere what earlier frames show."""

    def __init__(
        self,
        options: TrackerOptions,
        reach: Callable[[F32], F32],
        waver: DepthNoise,
        chart: SurfaceMap,
    ) -> None:
        """``reach``: see ``PointBackground``."""
        super().__init__(options, reach)
        self.waver, self._chart = waver, chart
        self._drawn: tuple[int, F32, F32] | None = None

    def _scene(self, view: View) -> tuple[F32, F32]:
        """The scene's depth in each cell, and the depth under which something is surely before it.

        What lies behind somebody who never goes away is taken to go on as it does around.
        """
        options = self.options.background
        if self._drawn is None or self._drawn[0] != view.number:
            depth, shape = self._chart.drawn(view), view.camera.shape
            limit = least(depth, shape, self.waver)
            limit -= options.near_sigmas * self.waver(limit)
            hole = _holes(np.isnan(depth[:-1]).reshape(shape)).ravel()
            if hole.any():
                beyond = drawn_on(depth[:-1], shape, np.zeros_like(hole), options=options)
                limit[:-1][hole] = options.same_depth_share * beyond[hole]
            self._drawn = view.number, depth, limit
        return self._drawn[1], self._drawn[2]

    def static(self, view: View, indices: I64) -> tuple[Mask, Mask]:
        """See ``Background``."""
        cell, depth = view.cells.pick(indices)
        scene = self._scene(view)[0][cell]
        far = depth - scene > -self.options.background.near_sigmas * self.waver(depth)
        rest = np.flatnonzero(~far & ~self.certain(view, indices))
        there = np.zeros(len(indices), np.bool_)
        there[rest] = super().static(view, indices[rest])[0]
        known = np.isfinite(scene)
        return far | (there & ~known), there & known

    def scenery(self, view: View, indices: I64, _frames: int) -> Mask:
        """See ``Background``; what has stood still for some ``frames`` is charted."""
        known = np.isfinite(self._scene(view)[0][view.cells.cell[indices]])
        return known & ~self.certain(view, indices)

    def furniture(self, view: View, indices: I64) -> Mask:
        """See ``PictureBackground``.

        So is what comes into the picture where nothing is charted, but beside what had a label.
        """
        stands = self.static(view, indices)[0]
        new = np.flatnonzero(~stands & ~self.certain(view, indices))
        before, labelled = self.past[-1]
        stands[new] = ~close_to(
            view.xyz[indices[new]], before.xyz[labelled], self.options.mapping.beside_m
        )
        return stands

    def left_behind(self, label: int, frames: int, way: float) -> None:
        """See ``PictureBackground``; what stood in most frames is charted."""

    def certain(self, view: View, indices: I64) -> Mask:
        """See ``Background``."""
        cell, depth = view.cells.pick(indices)
        return np.asarray(depth < self._scene(view)[1][cell])


def _holes(unknown: Mask) -> Mask:
    """(H, W) what is unknown, and the scene known all around."""
    part, _ = label(unknown)
    rim = np.concatenate([part[0], part[-1], part[:, 0], part[:, -1]])
    return np.asarray(unknown & ~np.isin(part, rim))
