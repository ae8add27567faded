"""Recordings by the name of their kind: generated from a seed, and written to disk.

On disk a recording is one .npz per frame with its truth, and a JSON file with common data.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pointbrush.errors import BadInputError
from pointbrush.frame import DepthCamera, PointFrame
from pointbrush.samples.aerial import CLASSES, aerial_tile
from pointbrush.samples.crowd import CrowdOptions, CrowdScene
from pointbrush.samples.jugglers import JugglingOptions, JugglingScene
from pointbrush.samples.recording import LabelInfo, Lazy, Recording, Scene
from pointbrush.samples.sensor import FPS, Sensor
from pointbrush.samples.stage import Stage, StageOptions
from pointbrush.samples.tabletop import TabletopOptions, TabletopScene
from pointbrush.samples.walkers import WalkingOptions, WalkingScene

ARRAYS = ("xyz", "rgb", "pixel", "viewpoint", "timestamp")
MOST_TILES = 4
"""Limit of the number of tiles of land in an aerial sample."""


KINDS: dict[str, tuple[Callable[..., Scene], Callable[..., object]]] = {
    "crowd": (CrowdScene, CrowdOptions),
    "juggling": (JugglingScene, JugglingOptions),
    "tabletop": (TabletopScene, TabletopOptions),
    "walking": (WalkingScene, WalkingOptions),
}
"""Kind -> its scene and the options of the scene."""


def generate(
    kind: str = "juggling",
    seed: int = 0,
    frames: int = 90,
    *,
    noise: float = 1.0,
    rate: float = FPS,
    **options: Any,
) -> Recording:
    """Return a recording with frames that are made on access.

    ``noise`` multiplies the sensor's errors (0: none); ``rate`` frames a second.  ``options``:
    options of the kind.
    Raises BadInputError for an unknown kind or option and for values out of range.
    """
    if kind not in KINDS:
        raise BadInputError(f"kind: expected one of {', '.join(KINDS)}, got {kind!r}")
    if frames < 1:
        raise BadInputError(f"frames: expected 1 or more, got {frames}")
    if seed < 0:
        raise BadInputError(f"seed: expected 0 or more, got {seed}")
    if not 0 <= noise <= 10:
        raise BadInputError(f"noise: expected 0 to 10, got {noise}")
    if not 1 <= rate <= FPS:
        raise BadInputError(f"rate: expected 1 to {FPS:.0f}, got {rate}")
    make, choose = KINDS[kind]
    try:
        scene = make(seed, frames / rate, choose(**options))
    except TypeError as error:
        raise BadInputError(f"options of {kind}: {error}") from None
    name = kind.capitalize() + (f" {seed}" if seed else "")
    return Recording(name, scene, frames, seed, rate, Sensor(noise=noise))


@dataclass(frozen=True, slots=True)
class Aerial:
    """Tiles of land, one a frame, side by side."""

    seed: int
    count: int
    name: str = "Aerial"
    fps: float = 1.0
    labels: Sequence[LabelInfo] = CLASSES

    @property
    def frames(self) -> Sequence[PointFrame]:
        """The tiles, without their classes."""
        return Lazy(self.count, lambda i: replace(aerial_tile(self.seed + i), label=None))


def sample(kind: str, seed: int, frames: int) -> Recording | Aerial | Stage:
    """Return a sample of a kind; raises BadInputError for an unknown one.

    ``frames``: number of frames, or of tiles of land, at most four.
    """
    if kind == "aerial":
        return Aerial(seed, min(frames, MOST_TILES))
    if kind == "stage":
        return Stage(seed, frames, StageOptions())
    return generate(kind, seed=seed, frames=frames)


def write(
    recording: Recording,
    folder: Path,
    *,
    step: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> list[Path]:
    """Write ``0000.npz``, ``0001.npz``, … and ``recording.json`` into ``folder``.

    Arrays of a frame: ``xyz`` (N, 3) float32, ``rgb`` (N, 3) uint8, ``pixel`` (N,) uint32
    row-major, ``viewpoint`` (3,), ``timestamp``, and ``truth`` (N,) uint16.  ``truth`` is not
    ``label``: importing the folder gives unlabelled points.  ``recording.json`` holds the palette,
    the rate, the camera and the true poses.  ``step`` keeps every so many rows and columns.
    Raises BadInputError when the folder already holds frames.
    """
    if step < 1:
        raise BadInputError(f"step: expected 1 or more, got {step}")
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.glob("*.npz")):
        raise BadInputError(f"{folder}: expected a folder without .npz files")
    paths = []
    for i in range(len(recording)):
        frame, truth = decimate(recording.frame(i), recording.truth[i], step)
        path = folder / f"{i:04}.npz"
        arrays = {name: np.asarray(getattr(frame, name)) for name in ARRAYS}
        np.savez_compressed(path, truth=truth, **arrays)  # type: ignore[arg-type]
        paths.append(path)
        if progress is not None:
            progress(i + 1, len(recording))
    (folder / "recording.json").write_text(_description(recording, step) + "\n")
    return paths


def picture(frame: PointFrame) -> Image.Image:
    """Return the colours of an organised frame as a picture; missing pixels are black.

    Raises BadInputError for a frame without camera, pixels or colours.
    """
    if frame.camera is None or frame.pixel is None or frame.rgb is None:
        raise BadInputError("picture: expected a frame with camera, pixel and rgb")
    grid = np.zeros((frame.camera.height * frame.camera.width, 3), np.uint8)
    grid[frame.pixel] = frame.rgb
    return Image.fromarray(grid.reshape(frame.camera.height, frame.camera.width, 3))


def decimate(
    frame: PointFrame, truth: NDArray[np.uint16], step: int
) -> tuple[PointFrame, NDArray[np.uint16]]:
    """Keep every ``step``-th row and column of an organised frame, and their truth."""
    camera, pixel = frame.camera, frame.pixel
    if step == 1:
        return frame, truth
    if camera is None or pixel is None:
        raise BadInputError("decimate: expected a frame with camera and pixel, got none")
    row, column = pixel // camera.width, pixel % camera.width
    kept = np.flatnonzero((row % step == 0) & (column % step == 0))
    small = small_camera(camera, step)
    numbers = row[kept] // step * small.width + column[kept] // step
    thinned = PointFrame(
        xyz=frame.xyz[kept],
        rgb=None if frame.rgb is None else frame.rgb[kept],
        viewpoint=frame.viewpoint,
        timestamp=frame.timestamp,
        dropped=small.width * small.height - kept.size,
        camera=small,
        pixel=numbers.astype(np.uint32),
    )
    return thinned, truth[kept]


def small_camera(camera: DepthCamera, step: int) -> DepthCamera:
    """Return the intrinsics of every ``step``-th pixel."""
    return DepthCamera(
        width=-(-camera.width // step),
        height=-(-camera.height // step),
        fx=camera.fx / step,
        fy=camera.fy / step,
        cx=camera.cx / step,
        cy=camera.cy / step,
    )


def _description(recording: Recording, step: int) -> str:
    camera = small_camera(recording.camera, step)
    return json.dumps(
        {
            "name": recording.name,
            "fps": recording.fps,
            "frames": len(recording),
            "labels": [label._asdict() for label in recording.labels],
            "camera": {
                key: getattr(camera, key) for key in ("width", "height", "fx", "fy", "cx", "cy")
            },
            "poses": {
                str(label): [np.round(T, 6).tolist() for T in poses]
                for label, poses in recording.poses.items()
            },
        }
    )
