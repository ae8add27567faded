"""View of a frame for `auto`: points in the world, colours free of shading, a depth image.

The depth image exists for pinhole-like sensors (``camera.py``).  It distinguishes static, occluded
and seen-through points.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.errors import BadInputError
from pointbrush.sensor_kind import SensorKind
from pointbrush.tracking.compute.grid import Runs, in_box, runs_of, widened
from pointbrush.tracking.compute.rigid import inverse, transform
from pointbrush.tracking.interface import F32, F64, I64, Mask, TrackFrame
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import Lens, Projection
from pointbrush.tracking.sensors.scanner import (
    RangeImage,
    axis_up,
    on_ground,
    range_image_of,
    reach_of,
)

WHITE = 765.0
"""Maximum sum of a colour's channels."""


@dataclass(eq=False)
class View:
    """Frame ``number`` (of the run's order) with ``lens`` or None; arrays in stored order."""

    number: int
    frame: TrackFrame
    lens: Lens | None
    options: TrackerOptions
    T_world_frame: F64 | None = None
    about: F64 | None = None
    """Estimated sensor position (3,), local, for frames without a recorded one."""
    steady: bool = False
    """Whether the lens is fixed in the world, instead of in the frame's coordinates."""
    labels: dict[int, I64] = field(default_factory=dict)
    people: Collection[int] = ()
    """Labels of jointly tracked people."""

    @cached_property
    def xyz(self) -> F32:
        """(N, 3) float32 in the world, in this process's memory.

        Raises BadInputError for positions that are not finite, because compiled loops need it.
        """
        T = self.T_world_frame
        local = np.array(self.frame.xyz, np.float32)
        if not np.isfinite(local).all():
            raise BadInputError(
                f"frame {self.number}: expected finite positions, got some that are not"
            )
        if T is None:
            return local
        return (local @ T[:3, :3].T + T[:3, 3]).astype(np.float32)

    def prepare(self) -> None:
        """Compute the properties shared by several threads."""
        _ = self.xyz, self.frame.rgb
        _ = self.depth if self.lens is not None else (self.shade, self.ground)

    @cached_property
    def eye(self) -> F64 | None:
        """Sensor position (3,) in the world, None if unknown."""
        at = self.frame.viewpoint
        if at is None and self.lens is not None:
            return self.lens.eye.astype(np.float64)
        at = self.about if at is None else at
        if at is None:
            return None
        T = self.T_world_lens
        return np.asarray(at if T is None else T[:3, :3] @ at + T[:3, 3], np.float64)

    def box(self, lo: F64, hi: F64) -> I64:
        """Return sorted indices of the points inside a box of the world."""
        return in_box(self._runs, lo, hi)

    @cached_property
    def _runs(self) -> Runs:
        return runs_of(self.xyz)

    def colour(self, indices: I64) -> F32:
        """Return (M, 3) two channels of hue, free of shading, and one of weak brightness.

        They are zero without colours.
        """
        options = self.options.tint
        if self.frame.rgb is None:
            return np.zeros((len(indices), 3), np.float32)
        return _tints(self._rgb, indices, options.red_weight, options.dark_sum, options.brightness)

    @cached_property
    def _rgb(self) -> NDArray[np.uint8]:
        """(N, 3) colours, cached for frequent indexing."""
        return np.array(self.frame.rgb)

    @property
    def camera(self) -> Lens:
        """The lens of a frame with a depth image.

        Raises RuntimeError if the frame has none.
        """
        if self.lens is None:
            raise RuntimeError(f"frame {self.number}: expected a depth image, its sensor has none")
        return self.lens

    @property
    def T_world_lens(self) -> F64 | None:  # noqa: N802  (named for its direction)
        """(4, 4) from the lens's coordinates, usually the frame's; None if they are the world's."""
        return None if self.steady else self.T_world_frame

    @cached_property
    def T_lens_world(self) -> F64:  # noqa: N802
        """(4, 4) from the world to the lens's coordinates."""
        return np.eye(4) if self.T_world_lens is None else inverse(self.T_world_lens)

    @cached_property
    def T_picture_world(self) -> F64:  # noqa: N802
        """(4, 4) from the world to axes across, down and along the image; needs a camera."""
        return self.camera.T_picture_frame @ self.T_lens_world

    def labelled(self, but: Collection[int] = ()) -> Mask:
        """Return a new mask (N,) of the points of all labels except ``but``."""
        mask = np.zeros(len(self.xyz), np.bool_)
        for label, points in self.labels.items():
            if label not in but:
                mask[points] = True
        return mask

    @cached_property
    def cells(self) -> Projection:
        """Projection of every point (N,) into the depth image; needs a camera."""
        return self.camera.cells(
            self.xyz if self.steady else np.asarray(self.frame.xyz, np.float32),
            options=self.options.lens,
        )

    @cached_property
    def depth(self) -> F32:
        """(cells + 1,) depth image, NaN where unmeasured and in the last entry."""
        height, width = self.camera.shape
        image = np.full(height * width + 1, np.nan, np.float32)
        cell, depth = self.cells
        image[cell] = depth
        image[-1] = np.nan
        return image

    def marked(self, points: I64) -> Mask:
        """Return a mask (cells + 1,) of the pixels of ``points`` (M,)."""
        mask = np.zeros(len(self.depth), np.bool_)
        mask[self.cells.cell[points]] = True
        return mask

    def around(self, points: I64) -> Mask:
        """Return a mask (cells,) of the pixels of ``points`` and of adjacent pixels."""
        return widened(self.marked(points)[:-1].reshape(self.camera.shape), 1).ravel()

    @cached_property
    def shade(self) -> RangeImage | None:
        """Range image in the world, for frames without a depth image."""
        return (
            None if self.eye is None else range_image_of(self.xyz, self.eye, options=self.options)
        )

    @cached_property
    def low(self) -> Mask:
        """(N,) mask of ground points of a moving sensor without a pixel grid."""
        return self.ground if self.roams else np.zeros(len(self.xyz), np.bool_)

    @cached_property
    def ground(self) -> Mask:
        """(N,) mask of ground points in lidar scans; empty for other sensors."""
        xyz = np.asarray(self.frame.xyz, np.float32)
        if not self.scans:
            return np.zeros(len(xyz), np.bool_)
        if self.T_world_frame is None and len(xyz):  # then the frame is not about its sensor
            xyz = xyz - np.median(xyz, axis=0).astype(np.float32)
        return on_ground(xyz, options=self.options)

    @cached_property
    def up(self) -> int:
        """The vertical axis of the world, up or down, in lidar scans."""
        return axis_up(
            self.xyz - (np.median(self.xyz, axis=0) if self.eye is None else self.eye),
            options=self.options.range_image,
        )

    @cached_property
    def roams(self) -> bool:
        """Whether a sensor without a pixel grid moves, or may move, such as a lidar on a car.

        Frames in world coordinates do not have the lidar's position.
        """
        if self.lens is not None:
            return False
        return self.T_world_frame is not None or (
            self.eye is None and self._reach > self.options.range_image.camera_reach_m
        )

    @cached_property
    def kind(self) -> SensorKind:
        """Kind of the sensor.

        One or several lidars move without a pixel grid, look around from one position, or have a
        larger range than depth cameras.
        """
        if self.lens is not None:
            return "camera"
        scans = (
            self.roams
            or self.shade is not None
            or self._reach > self.options.range_image.camera_reach_m
        )
        return "lidar" if scans else "room"

    @property
    def scans(self) -> bool:
        """Whether the frame is a lidar's."""
        return self.kind == "lidar"

    @property
    def _reach(self) -> float:
        return reach_of(self.xyz, options=self.options.range_image)

    def firm(self, indices: I64, step: float) -> Mask:
        """Mark the points (M,) on a surface, with no depth jump of ``step`` metres beside them.

        Points between two surfaces at an outline belong to neither.
        """
        if self.lens is None:
            return np.ones(len(indices), np.bool_)
        cell, depth = self.cells.pick(indices)
        firm = np.ones(len(indices), np.bool_)
        width = self.lens.shape[1]
        for beside in (-width, -1, 1, width):
            other = self.depth[np.clip(cell + beside, 0, len(self.depth) - 1)]
            with np.errstate(invalid="ignore"):
                firm &= ~(np.abs(other - depth) > step)
        return firm

    def project(self, world: F64) -> Projection:
        """Project points (M, 3) of the world into the depth image; needs a camera."""
        local = world if self.T_world_lens is None else transform(self.T_lens_world, world)
        return self.camera.cells(local.astype(np.float32), options=self.options.lens)

    def hides(self, world: F64, margin: float) -> Mask:
        """Mark the positions (M, 3) outside the picture, or more than ``margin`` metres behind its
        depth; needs a camera."""
        cell, depth = self.project(world)
        with np.errstate(invalid="ignore"):
            return np.asarray((self.depth[cell] < depth - margin) | (cell < 0))

    def sees_through(self, world: F64, margin: float) -> Mask:
        """Mark the positions (M, 3) more than ``margin`` metres in front of the picture's depth."""
        cell, depth = self.project(world)
        with np.errstate(invalid="ignore"):
            return np.asarray(self.depth[cell] > depth + margin)


@compiled
def _tints(
    rgb: NDArray[np.uint8], indices: I64, red_weight: float, dark_sum: float, brightness: float
) -> F32:
    """Return (M, 3) chromaticities, red against green and blue against both, and brightness."""
    result = np.empty((len(indices), 3), np.float32)
    for i in range(len(indices)):
        at = indices[i]
        red, green, blue = float(rgb[at, 0]), float(rgb[at, 1]), float(rgb[at, 2])
        total = red + green + blue
        result[i, 0] = red_weight * (red - green) / (total + dark_sum)
        result[i, 1] = (2.0 * blue - red - green) / (total + dark_sum)
        result[i, 2] = total * (brightness / WHITE)
    return result
