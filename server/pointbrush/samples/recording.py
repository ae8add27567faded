"""A generated recording: frames made on demand, each with its truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Generic, NamedTuple, Protocol, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from pointbrush.cache import Cache
from pointbrush.errors import NotFoundError
from pointbrush.frame import DepthCamera, PointFrame
from pointbrush.samples.geometry import Array, Field, dot3, inverse, norm3, vec, wobble
from pointbrush.samples.lighting import Ball, Lights, LitRoom, light_moving
from pointbrush.samples.render import Caster, Solid
from pointbrush.samples.reproducible import matmul
from pointbrush.samples.sensor import FPS, KINECT, Sensor, develop, measure, pixel_rays

T = TypeVar("T")


class LabelInfo(NamedTuple):
    """A palette entry of the truth: ``color`` "#rrggbb"."""

    id: int
    name: str
    category: str
    color: str


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """Moving parts at one time: solids, their shadows' balls, and true poses of rigid labels."""

    solids: list[Solid]
    balls: list[Ball]
    poses: Mapping[int, Array]
    """label -> ``T_room_object``"""


class Scene(Protocol):
    """Interface of a kind of recording; times in seconds from the first frame."""

    @property
    def labels(self) -> list[LabelInfo]:
        """Return the palette."""

    @property
    def camera_pose(self) -> Array:
        """Return ``T_room_camera``."""

    @property
    def lights(self) -> Lights:
        """Return the light."""

    def still(self) -> list[Solid]:
        """List the solids that never move."""

    def at(self, t: float) -> Moment:
        """Place the moving solids at time ``t``."""


class Lazy(Sequence[T], Generic[T]):
    """A sequence with items that are made on access."""

    def __init__(self, count: int, make: Callable[[int], T]) -> None:
        self._count, self._make = count, make

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, i: int) -> T: ...
    @overload
    def __getitem__(self, i: slice) -> Sequence[T]: ...
    def __getitem__(self, i: int | slice) -> T | Sequence[T]:
        if isinstance(i, slice):
            numbers = range(self._count)[i]
            return Lazy(len(numbers), lambda k: self._make(numbers[k]))
        if not 0 <= i < self._count:
            raise IndexError(f"expected a frame 0..{self._count - 1}, got {i}")
        return self._make(i)

    def __iter__(self) -> Iterator[T]:
        return (self._make(i) for i in range(self._count))


class _Made(NamedTuple):
    frame: PointFrame
    truth: NDArray[np.uint16]


@dataclass(eq=False)
class Recording:
    """A Kinect 2 recording with exact truth.

    ``frames[i]``        PointFrame in camera coordinates (x right, y down, z forward, metres).
    ``truth[i]``         (N,) uint16 label of each point, source order; 0 is the room.
    ``poses[label][i]``  (4, 4) true ``T_world_object`` of a rigid label; the world is the camera.
    Frames depend on the seed and their number only, so any one can be made alone.
    """

    name: str
    scene: Scene
    count: int
    seed: int
    fps: float = FPS
    sensor: Sensor = field(default_factory=Sensor)
    camera: DepthCamera = KINECT
    keep: int = 3
    """Number of cached frames."""

    def __post_init__(self) -> None:
        self._made: Cache[int, _Made] = Cache(self.keep)

    def __len__(self) -> int:
        return self.count

    @property
    def labels(self) -> list[LabelInfo]:
        """(id, name, category, color) of every label."""
        return self.scene.labels

    @property
    def frames(self) -> Sequence[PointFrame]:
        """All frames, made one at a time."""
        return Lazy(self.count, self.frame)

    @property
    def truth(self) -> Sequence[NDArray[np.uint16]]:
        """The label of every point of every frame."""
        return Lazy(self.count, lambda i: self._make(i).truth)

    @cached_property
    def poses(self) -> dict[int, list[Array]]:
        """True poses of the rigid labels in every frame."""
        T_camera_room = inverse(self.scene.camera_pose)
        result: dict[int, list[Array]] = {}
        for i in range(self.count):
            for label, T_room_object in self.scene.at(i / self.fps).poses.items():
                result.setdefault(label, []).append(matmul(T_camera_room, T_room_object))
        return result

    def frame(self, i: int) -> PointFrame:
        """Make frame ``i``; raises NotFoundError out of range."""
        return self._make(i).frame

    @cached_property
    def _room(self) -> LitRoom:
        caster = Caster(self.camera, self.scene.camera_pose, pixel_rays(self.camera))
        return LitRoom(caster, self.scene.still(), self.scene.lights)

    def _make(self, i: int) -> _Made:
        if not 0 <= i < self.count:
            raise NotFoundError(f"expected a frame 0..{self.count - 1}, got {i}")
        return self._made.get(i, lambda: self._render(i))

    def _render(self, i: int) -> _Made:
        """Cast the moving solids into the still room, light it, and simulate the sensor."""
        room, camera, t = self._room, self.camera, i / self.fps
        moment = self.scene.at(t)
        seen = room.surface.copy()
        first = len(room.solids)
        room.caster.cast(moment.solids, seen, first)
        s = room.caster.shade(moment.solids, seen, first)
        light = room.lit(moment.balls)
        light[:, s.pixel] = light_moving(room, s, seen.depth, moment.balls)
        normal, infrared, label = room.normal.copy(), room.infrared.copy(), room.label.copy()
        normal[:, s.pixel], infrared[s.pixel], label[s.pixel] = s.normal, s.infrared, s.label
        amplitude = infrared * _facing(room.caster, normal)
        rng = np.random.default_rng([self.seed, 77, i])
        shape = (camera.height, camera.width)
        scan = measure(
            self.sensor,
            seen.depth.reshape(shape),
            label.reshape(shape),
            amplitude.reshape(shape),
            rng,
        )
        gain = 1 + 0.02 * wobble(t, vec(self.seed, 1.0), (2.9, 0.73))
        picture = develop(self.sensor, light.reshape(3, *shape), rng, gain)
        pixel = np.flatnonzero(scan.depth > 0)
        xyz = (room.caster.rays[:, pixel] * scan.depth.ravel()[pixel]).T
        frame = PointFrame(
            xyz=np.ascontiguousarray(xyz, np.float32),
            rgb=picture.reshape(-1, 3)[pixel],
            viewpoint=np.zeros(3),
            timestamp=t,
            dropped=int(scan.depth.size - pixel.size),
            camera=camera,
            pixel=pixel.astype(np.uint32),
        )
        return _Made(frame, scan.label.ravel()[pixel])


def _facing(caster: Caster, normal: Field) -> Field:
    """(H*W,) cosine between the surfaces' normals and the view."""
    rays = caster.room_rays
    return np.asarray(np.maximum(-dot3(normal, rays) / norm3(rays), 0), np.float32)
