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
from pointbrush.tracking.sensors.sights import Lenses, Sight, all_of, any_of

WHITE = 765.0
"""Maximum sum of a colour's channels."""


@dataclass(eq=False)
class View:
    """Frame ``number`` (of the run's order) with ``lens`` or None; arrays in stored order."""

    number: int
    frame: TrackFrame
    lens: Lens | Lenses | None
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
        _ = self.depth if self.lens is not None else (self.sights, self.ground)

    @cached_property
    def eye(self) -> F64 | None:
        """Position (3,) of the only sensor in the world, None if unknown."""
        at = self.frame.viewpoint
        if self.frame.sensor is not None:
            return None
        if at is None and isinstance(self.lens, Lens):
            return self.lens.eye.astype(np.float64)
        at = self.about if at is None else at
        return None if at is None else self._in_world(at)

    def _in_world(self, at: F32 | F64) -> F64:
        T = self.T_world_lens
        return np.asarray(at if T is None else T[:3, :3] @ at + T[:3, 3], np.float64)

    @cached_property
    def sights(self) -> tuple[Sight, ...]:
        """The frame's sensors; of several, the ones with a depth or range image, if any."""
        if self.frame.sensor is None:
            lens = self.lens if isinstance(self.lens, Lens) else None
            return (Sight(self.eye, lens, self.shade if lens is None else None),)
        if isinstance(self.lens, Lenses):
            present = {part.sensor for part in self.frame.parts} & self.lens.of.keys()
            lenses = [self.lens.of[number] for number in sorted(present or self.lens.of)]
            return tuple(Sight(self._in_world(lens.eye), lens) for lens in lenses)
        found = []
        for part in self.frame.parts:
            own, eye = self.frame.sensor == part.sensor, self._in_world(part.T_frame_sensor[:3, 3])
            shade = range_image_of(self.xyz[own], eye, options=self.options)
            if shade is not None:
                found.append(Sight(eye, shade=shade))
        return tuple(found) or (Sight(None),)

    @cached_property
    def points_by_sensor(self) -> list[Mask]:
        """A mask (N,) of the points of each sensor that has some."""
        if self.frame.sensor is None:
            return [np.ones(len(self.xyz), np.bool_)]
        return [self.frame.sensor == number for number in np.unique(self.frame.sensor)]

    def per_sensor(self, count: int) -> int:
        """Return a maximum number of points, given the ``count`` of one sensor.

        The same surface has more points with several sensors; a sample of as few would be sparse.
        """
        return count * max(1, len(self.points_by_sensor))

    def eyes_of(self, points: I64) -> F64 | None:
        """Return positions (1, 3) or (M, 3) of the sensors of some points; None: unknown."""
        if self.frame.sensor is None:
            return None if self.eye is None else self.eye[None]
        eyes = np.zeros((int(self.frame.sensor.max(initial=0)) + 1, 3))
        for part in self.frame.parts:
            eyes[part.sensor] = self._in_world(part.T_frame_sensor[:3, 3])
        return np.asarray(eyes[self.frame.sensor[points]])

    def sensor_distance(self, at: F64) -> float | None:
        """Return metres from a position (3,) to the nearest sensor; None: unknown."""
        eyes = [sight.eye for sight in self.sights if sight.eye is not None]
        return min((float(np.linalg.norm(at - eye)) for eye in eyes), default=None)

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
        """The lens of a frame with a depth image, the first of several.

        Raises RuntimeError if the frame has none.
        """
        if self.lens is None:
            raise RuntimeError(f"frame {self.number}: expected a depth image, its sensor has none")
        return self.lens if isinstance(self.lens, Lens) else next(iter(self.lens.of.values()))

    @property
    def image_shape(self) -> tuple[int, int]:
        """Rows and columns of the depth image, which several cameras share; needs a camera."""
        return self.camera.shape if self.lens is None else self.lens.shape

    @property
    def pictures(self) -> list[slice]:
        """The cells of each camera's rows in the depth image; needs a camera."""
        rows, width = self.image_shape
        if not isinstance(self.lens, Lenses):
            return [slice(0, rows * width)]
        starts = [lens.start for lens in self.lens.of.values()]
        return [slice(a, b) for a, b in zip(starts, [*starts[1:], rows * width], strict=True)]

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
        xyz = self.xyz if self.steady else np.asarray(self.frame.xyz, np.float32)
        if isinstance(self.lens, Lenses):
            return self.lens.cells(xyz, self.frame, options=self.options)
        return self.camera.cells(xyz, options=self.options.lens)

    @cached_property
    def depth(self) -> F32:
        """(cells + 1,) depth image, NaN where unmeasured and in the last entry."""
        height, width = self.image_shape
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
        return widened(self.marked(points)[:-1].reshape(self.image_shape), 1).ravel()

    @cached_property
    def shade(self) -> RangeImage | None:
        """Range image of the only sensor in the world, for frames without a depth image."""
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
            all(sight.eye is None for sight in self.sights)
            and self._reach > self.options.range_image.camera_reach_m
        )

    @cached_property
    def kind(self) -> SensorKind:
        """Kind of the sensor.

        One or several lidars move without a pixel grid, look around from one position, or have a
        larger range than depth cameras.
        """
        if self.lens is not None:
            return "camera"
        scans = self.roams or self.shaded or self._reach > self.options.range_image.camera_reach_m
        return "lidar" if scans else "room"

    @property
    def shaded(self) -> bool:
        """Whether range images show which points are occluded."""
        return any(sight.shade is not None for sight in self.sights)

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

    def project(self, world: F64) -> list[Projection]:
        """Project points (M, 3) of the world into the depth image of each camera; needs one."""
        local = world if self.T_world_lens is None else transform(self.T_lens_world, world)
        xyz, lenses = local.astype(np.float32), (sight.lens for sight in self.sights)
        return [lens.cells(xyz, options=self.options.lens) for lens in lenses if lens is not None]

    def range_to(self, world: F64) -> F32:
        """Return (M,) depths of positions (M, 3) before the nearest camera that shows them."""
        first, *others = self.project(world)
        depth = first.depth
        for cell, farther in others:
            depth = np.where((cell >= 0) & (farther < depth), farther, depth)
        return depth

    def hides(self, world: F64, margin: float) -> Mask:
        """Mark the positions (M, 3) that no camera can see; needs a camera.

        They are outside its picture, or more than ``margin`` metres behind its depth.
        """
        return all_of(self.hidden_from(world, margin))

    def hidden_from(self, world: F64, margin: float) -> list[Mask]:
        """Mark the positions (M, 3) that each camera cannot see; see ``hides``."""
        with np.errstate(invalid="ignore"):
            return [
                np.asarray((self.depth[cell] < depth - margin) | (cell < 0))
                for cell, depth in self.project(world)
            ]

    def sees_through(self, world: F64, margin: float) -> Mask:
        """Mark the positions (M, 3) more than ``margin`` metres in front of a picture's depth."""
        return any_of(self.seen_through_from(world, margin))

    def seen_through_from(self, world: F64, margin: float) -> list[Mask]:
        """Mark the positions (M, 3) that each camera sees through; see ``sees_through``."""
        with np.errstate(invalid="ignore"):
            return [
                np.asarray(self.depth[cell] > depth + margin) for cell, depth in self.project(world)
            ]


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
