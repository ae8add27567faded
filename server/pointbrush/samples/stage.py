"""The stage: jugglers in a room, seen by two or three depth cameras around them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.frame import DepthCamera, FramePart, PointFrame, Sensor, join_sensors
from pointbrush.samples.geometry import UP, Array, axis_angle, inverse, rigid, unit, vec
from pointbrush.samples.jugglers import JugglingOptions, JugglingScene
from pointbrush.samples.lighting import Lights
from pointbrush.samples.recording import LabelInfo, Lazy, Moment, Recording
from pointbrush.samples.render import Solid
from pointbrush.samples.reproducible import draw_normal, matmul
from pointbrush.samples.sensor import FPS, KINECT
from pointbrush.samples.sensor import Sensor as Measuring

NAMES = ("front", "right", "left")
CORNERS = (vec(2.1, 2.0, -4.0), vec(-2.1, 2.2, -4.0))
"""Places of the second and third camera, metres: the corners of the room behind the jugglers."""
TARGET = vec(0.0, 0.95, -2.55)
"""Place in the room that they look at, metres."""
GRAIN = 1 / 3
"""Ratio of the noise of depths to that of the other samples, which is 3 to 4 times as strong at 2
to 4 m as Fankhauser et al. (Kinect v2 for mobile robot navigation, ICAR 2015) measured."""
SEED_STEP = 10_007
"""Difference of the seeds of two cameras' errors."""


@dataclass(frozen=True, slots=True)
class StageOptions:
    """Options of a stage.

    ``cameras`` 2 or 3.  ``error_metres`` and ``error_degrees``: length and angle by which the
    given mounts of all cameras but the first are wrong, in random directions.  ``grain``: ratio of
    the noise of depths to that of the other samples.
    """

    cameras: int = 3
    error_metres: float = 0.0
    error_degrees: float = 0.0
    grain: float = GRAIN


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    """The scene as another camera sees it; see ``recording.Scene``."""

    scene: JugglingScene
    camera_pose: Array

    @property
    def labels(self) -> list[LabelInfo]:
        return self.scene.labels

    @property
    def lights(self) -> Lights:
        return self.scene.lights

    def still(self) -> list[Solid]:
        return self.scene.still()

    def at(self, t: float) -> Moment:
        return self.scene.at(t)


class Stage:
    """A recording of several depth cameras with exact truth.

    ``frames[i]``        PointFrame of all cameras, in the coordinates of the first one.
    ``truth[i]``         (N,) uint16 label of each point, source order; 0 is the room.
    ``poses[label][i]``  (4, 4) true ``T_world_object``; the world is the first camera.
    ``views[k]``         what camera ``k`` records alone, with its truth.
    ``sensors``          name and type of each camera.
    ``mounts[k]``        ``T_frame_sensor`` as the frames have it; ``true_mounts[k]`` without error.
    """

    name = "Stage"
    fps = FPS

    def __init__(
        self,
        seed: int,
        count: int,
        options: StageOptions,
        juggling: JugglingOptions | None = None,
        *,
        noise: float = 1.0,
        camera: DepthCamera = KINECT,
    ) -> None:
        if options.cameras not in (2, 3):
            raise BadInputError(f"cameras: expected 2 or 3, got {options.cameras}")
        self.seed, self.count = seed, count
        scene = JugglingScene(seed, count / FPS, juggling or JugglingOptions())
        places = [scene.camera_pose, *(_looking(eye) for eye in CORNERS[: options.cameras - 1])]
        self.views = [
            Recording(
                NAMES[k],
                _View(scene, place),
                count,
                seed + SEED_STEP * k,
                sensor=Measuring(noise, grain=options.grain),
                camera=camera,
            )
            for k, place in enumerate(places)
        ]
        self.sensors = tuple(Sensor(NAMES[k], "depth") for k in range(options.cameras))
        T_frame_room = inverse(scene.camera_pose)
        self.true_mounts = [np.eye(4), *(matmul(T_frame_room, place) for place in places[1:])]
        rng = np.random.default_rng([seed, 53])
        errors = [_error(options, rng) for _ in places[1:]]
        wrong = [matmul(T, error) for T, error in zip(self.true_mounts[1:], errors, strict=True)]
        self.mounts = [self.true_mounts[0], *wrong]

    def __len__(self) -> int:
        return self.count

    @property
    def labels(self) -> list[LabelInfo]:
        """(id, name, category, color) of every label."""
        return self.views[0].labels

    @property
    def frames(self) -> Sequence[PointFrame]:
        """All frames, made one at a time."""
        return Lazy(self.count, self.frame)

    @property
    def truth(self) -> Sequence[NDArray[np.uint16]]:
        """The label of every point of every frame."""
        return Lazy(self.count, lambda i: np.concatenate([view.truth[i] for view in self.views]))

    @cached_property
    def poses(self) -> dict[int, list[Array]]:
        """True poses of the rigid labels in every frame."""
        return self.views[0].poses

    def frame(self, i: int) -> PointFrame:
        """Make frame ``i``; raises NotFoundError out of range."""
        given = [
            (FramePart(k, self.mounts[k], i / FPS), view.frame(i))
            for k, view in enumerate(self.views)
        ]
        return join_sensors(self.sensors, given, timestamp=i / FPS)


def _looking(eye: Array) -> Array:
    """Return ``T_room_camera`` of a camera at ``eye`` (3,) that looks at TARGET, level."""
    ahead = unit(TARGET - eye)
    right = unit(np.cross(ahead, UP))
    return rigid(np.column_stack([right, np.cross(ahead, right), ahead]), eye)


def _error(options: StageOptions, rng: np.random.Generator) -> Array:
    """Return a motion (4, 4) of the options' length and angle in random directions."""
    axis, way = unit(draw_normal(rng, 1.0, 3)), unit(draw_normal(rng, 1.0, 3))
    return rigid(axis_angle(axis, math.radians(options.error_degrees)), options.error_metres * way)
