"""Points with true labels and masks, of generated recordings and of recorded lidar."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from tracking_recordings import REAL

from pointbrush.frame import DepthCamera
from pointbrush.geometry.quaternions import rotation_of
from pointbrush.masks import LiftOptions, View
from pointbrush.masks.visibility import visible
from pointbrush.samples import generate
from pointbrush.samples.geometry import inverse
from pointbrush.samples.render import Caster
from pointbrush.samples.sensor import pixel_rays
from pointbrush.values.frames import Camera

Floats = NDArray[np.floating[Any]]
COLOUR = DepthCamera(960, 540, 540.0, 540.0, 479.5, 269.5)
"""Intrinsics of a colour camera beside the generated depth camera."""
BASELINE = 0.05
"""Distance of the colour camera to the right of the depth camera, metres."""
SURFACE_DISTANCE = 0.03
"""Greatest distance of a seen point from the surface that the colour camera sees in its pixel,
metres: noise of the sensor, and half a pixel on a slanted surface."""
Polygon = list[tuple[int, int]]
KITTI_K = np.array([[707.0912, 0, 601.8873], [0, 707.0912, 183.1104], [0, 0, 1]])
KITTI_P = np.array([46.88783, 0.1178601, 0.006203223])
"""Fourth column of P2 of sequence 04."""
KITTI_TR = np.array([
    [-0.001857739385241, -0.999965951351, -0.008039975204516, -0.004784029760483],
    [-0.006481465826011, 0.008051860151134, -0.9999466081774, -0.07337429464231],
    [0.9999773098287, -0.001805528627661, -0.006496203536139, -0.3339968064433],
])  # fmt: skip
"""Tr of sequence 05, which has the same rig; the labels of 04 are published without its own Tr."""
KITTI_OUTLINES: dict[int, Polygon] = {
    1: [(576, 223), (575, 200), (577, 187), (580, 168), (580, 157), (585, 157), (600, 158),
        (612, 157), (625, 157), (625, 167), (628, 180), (630, 195), (630, 222), (628, 224)],
    2: [(284, 236), (283, 217), (286, 212), (290, 204), (296, 198), (305, 192), (310, 189),
        (320, 187), (340, 186), (351, 187), (358, 190), (363, 197), (366, 206), (368, 211),
        (368, 223), (366, 225), (358, 225), (344, 228), (342, 231), (336, 232), (310, 234)],
}  # fmt: skip
"""Outlines of vehicles in image_2/000000.png by instance, drawn by hand without looking at points.

Exception: the outline of the van (1) was drawn again after its points were seen, to include the
roof rack.
"""
DGP_K = np.array([[1062.36486, 0, 939.46978], [0, 1056.76358, 622.4748], [0, 0, 1]])
DGP_QUATERNION = (-0.6745413067735876, 0.22052638633275587, -0.21195036693811412, 0.67189223863801)
DGP_PLACE = (1.6486913210844705, 0.3908388907926792, 1.363451237682959)
"""T_frame_camera of CAMERA_05 of scene_01, from TRI-ML/dgp (MIT), its test data."""
DGP_OUTLINES: dict[int, Polygon] = {
    31: [(734, 666), (752, 654), (809, 641), (831, 627), (881, 627), (909, 638), (934, 641),
         (937, 672), (906, 686), (884, 683), (799, 692), (784, 690), (743, 688)],
}  # fmt: skip
"""Outline of a parked car in 00_CAMERA_05.jpg, by instance.

The other near cars move, and the picture was taken 0.2 s after the scan.
"""
KINDS = ("juggling", "walking", "tabletop")


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Points (N, 3) with true labels (N,), and the true mask of a camera.

    ``seen`` (N,): True for points that the camera sees.  ``lattice``: view of the depth camera that
    measured the points, None for lidar.
    """

    name: str
    camera: Camera
    mask: NDArray[np.uint16]
    xyz: Floats
    truth: NDArray[np.uint16]
    seen: NDArray[np.bool_]
    lattice: View | None = None


def camera_of(name: str, size: tuple[int, int], K: Floats, T_camera_frame: Floats) -> Camera:
    """Return a camera without distortion; ``size``: width and height, pixels."""
    return Camera(name, *size, K, (), "plumb_bob", T_camera_frame)


def with_errors(camera: Camera, pixels: float, metres: float, seed: int) -> Camera:
    """Return a camera with errors of its calibration, in random directions."""
    rng = np.random.default_rng(seed)
    K, T = camera.K.copy(), camera.T_camera_frame.copy()
    angle = rng.uniform(0, 2 * np.pi)
    K[:2, 2] += pixels * np.array([np.cos(angle), np.sin(angle)])
    direction = rng.normal(size=3)
    T[:3, 3] += metres * direction / np.linalg.norm(direction)
    return replace(camera, K=K, T_camera_frame=T)


def generated(seeds: tuple[int, ...], frames: int) -> Iterator[Scene]:
    """Yield scenes of the samples, with a colour camera beside the depth camera."""
    for kind in KINDS:
        for seed in seeds:
            recording = generate(kind, seed, frames)
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
    camera = camera_of("colour", (COLOUR.width, COLOUR.height), K, inverse(T_depth_colour))
    view = View.of_camera(camera, frame.xyz)
    inside = view.pixel >= 0
    seen = inside & (np.abs(surface.depth[view.pixel] - view.depth) < SURFACE_DISTANCE)
    size = (depth_camera.width, depth_camera.height)
    lattice = View.of_lattice("depth", size, frame.pixel, frame.xyz[:, 2])
    shape = (COLOUR.height, COLOUR.width)
    mask = labels[surface.owner].reshape(shape)
    return Scene(name, camera, mask, frame.xyz, truth, seen, lattice)


def recorded() -> Iterator[Scene]:
    """Yield scenes of recorded lidar, with masks of the outlines above."""
    T = np.eye(4)
    T[:3] = KITTI_TR
    T[:3, 3] += np.linalg.inv(KITTI_K) @ KITTI_P
    folder = REAL / "semantickitti_04"
    xyz = np.fromfile(folder / "velodyne/000000.bin", np.float32).reshape(-1, 4)[:, :3]
    instance = np.fromfile(folder / "labels/000000.label", np.uint32) >> 16
    camera = camera_of("image_2", (1226, 370), KITTI_K, T)
    yield _recorded("semantickitti_04", camera, KITTI_OUTLINES, xyz, instance)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation_of(np.array(DGP_QUATERNION)), DGP_PLACE
    stored = np.load(REAL / "dgp_scene_01/npz/0000.npz")
    camera = camera_of("CAMERA_05", (1936, 1216), DGP_K, np.linalg.inv(T))
    yield _recorded("dgp_scene_01", camera, DGP_OUTLINES, stored["xyz"], stored["instance"])


def _recorded(
    name: str, camera: Camera, outlines: dict[int, Polygon], xyz: Floats, truth: NDArray[Any]
) -> Scene:
    image = Image.new("I", (camera.width, camera.height))
    for instance, outline in outlines.items():
        ImageDraw.Draw(image).polygon(outline, fill=instance)
    seen = np.zeros(len(xyz), np.bool_)
    seen[visible(View.of_camera(camera, xyz), LiftOptions().visibility)] = True
    mask = np.asarray(image).astype(np.uint16)
    return Scene(name, camera, mask, xyz, truth.astype(np.uint16), seen)
