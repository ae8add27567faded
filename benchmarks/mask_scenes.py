"""Pictures with true masks of generated recordings, and of recorded lidar beside the checkout."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.frame import DepthCamera
from pointbrush.masks import View
from pointbrush.samples import generate
from pointbrush.samples.geometry import inverse
from pointbrush.samples.render import Caster
from pointbrush.samples.sensor import pixel_rays

Floats = NDArray[np.floating[Any]]
COLOUR = DepthCamera(960, 540, 540.0, 540.0, 479.5, 269.5)
"""A colour camera beside the generated depth camera."""
BASELINE = 0.05
"""Metres from the depth camera to it, to the right."""
SAME = 0.03
"""Metres between a point and the surface that the colour camera sees there, if it sees the point:
noise of the sensor, and half a pixel on a slanted surface."""
KINDS: dict[str, dict[str, Any]] = {"juggling": {}, "walking": {}, "tabletop": {}}


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """A calibrated camera, as a recording stores it."""

    name: str
    width: int
    height: int
    K: Floats
    T_camera_frame: Floats
    distortion: tuple[float, ...] = ()
    model: str = "plumb_bob"

    def off(self, pixels: float, metres: float, seed: int) -> Camera:
        """Return the camera with errors of its calibration, in random directions."""
        rng = np.random.default_rng(seed)
        K, T = self.K.copy(), self.T_camera_frame.copy()
        angle = rng.uniform(0, 2 * np.pi)
        K[:2, 2] += pixels * np.array([np.cos(angle), np.sin(angle)])
        away = rng.normal(size=3)
        T[:3, 3] += metres * away / np.linalg.norm(away)
        return replace(self, K=K, T_camera_frame=T)


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Points (N, 3) with true labels (N,), and the true mask of a camera.

    ``seen`` (N,): True for points that the camera sees.  ``lattice``: size and pixels of the depth
    image that the points are.
    """

    name: str
    camera: Camera
    mask: NDArray[np.uint16]
    xyz: Floats
    truth: NDArray[np.uint16]
    seen: NDArray[np.bool_]
    lattice: View | None = field(default=None)


def generated(seeds: tuple[int, ...], frames: int) -> Iterator[Scene]:
    """Yield scenes of the samples, with a colour camera beside the depth camera."""
    for kind, options in KINDS.items():
        for seed in seeds:
            recording = generate(kind, seed, frames, **options)
            for i in range(0, frames, max(1, frames // 3)):
                yield _generated(f"{kind} {seed}", recording, i)


def _generated(name: str, recording: Any, i: int) -> Scene:
    scene, depth_camera = recording.scene, recording.camera
    T_depth_colour = np.eye(4)
    T_depth_colour[0, 3] = BASELINE
    place = scene.camera_pose @ T_depth_colour
    caster = Caster(COLOUR, place, pixel_rays(COLOUR))
    solids = [*scene.still(), *scene.at(i / recording.fps).solids]
    surface = caster.empty()
    caster.cast(solids, surface)
    labels = np.array([*(solid.label for solid in solids), 0], np.uint16)
    frame, truth = recording.frame(i), recording.truth[i]
    K = np.array([[COLOUR.fx, 0, COLOUR.cx], [0, COLOUR.fy, COLOUR.cy], [0, 0, 1]])
    camera = Camera("colour", COLOUR.width, COLOUR.height, K, inverse(T_depth_colour))
    view = View.of_camera(camera, frame.xyz)
    inside = view.pixel >= 0
    seen = inside & (np.abs(surface.depth[view.pixel] - view.depth) < SAME)
    size = (depth_camera.width, depth_camera.height)
    lattice = View.of_lattice("depth", size, frame.pixel, frame.xyz[:, 2])
    shape = (COLOUR.height, COLOUR.width)
    mask = labels[surface.owner].reshape(shape)
    return Scene(name, camera, mask, frame.xyz, truth, seen, lattice)
