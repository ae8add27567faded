"""A street with parked cars, seen by a lidar that drives through it, and by its camera."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from pointbrush.formats.cameras.pictures import Camera, Picture, PictureSource
from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames

FRAMES, SHOWN = 5, 2
WIDTH, HEIGHT = 480, 270
K = np.array([[240.0, 0, WIDTH / 2], [0, 240, HEIGHT / 2], [0, 0, 1]])
T_CAMERA_FRAME = np.array([[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0], [0, 0, 0, 1.0]])
"""From the lidar (x ahead, z up) to a camera at its place (z ahead, y down)."""
CAR, GROUND = 600, 4_000
CARS = np.array([[8.0, 3.0], [8.0, -3.0], [13.0, 3.0]])
SENSOR_HEIGHT = 1.8
SKY, ROAD, PAINT = (120, 160, 205), (92, 92, 96), ((190, 60, 50), (60, 110, 190), (220, 200, 90))


def world() -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
    """Points of the ground and of three cars, and their colours."""
    rng = np.random.default_rng(1)
    ground = np.column_stack([rng.uniform(0, 20, GROUND), rng.uniform(-6, 6, GROUND), rng.normal(0, 0.01, GROUND)])  # fmt: skip  # noqa: E501
    parts, colors = [ground], [np.tile(ROAD, (GROUND, 1))]
    for at, color in zip(CARS, PAINT, strict=True):
        side = rng.uniform(-1, 1, (CAR, 3))
        face = rng.integers(0, 3, CAR)
        side[np.arange(CAR), face] = np.sign(side[np.arange(CAR), face])
        parts.append(side * [2.0, 0.9, 0.7] + [*at, 0.9])
        colors.append(np.tile(color, (CAR, 1)))
    shade = rng.integers(-12, 12, (sum(map(len, parts)), 1))
    return np.concatenate(parts), np.clip(np.concatenate(colors) + shade, 0, 255).astype(np.uint8)


WORLD, COLORS = world()
IS_CAR = np.arange(len(WORLD)) >= GROUND
FIRST_CAR = (np.arange(len(WORLD)) >= GROUND) & (np.arange(len(WORLD)) < GROUND + CAR)


def pose(frame: int) -> NDArray[np.float64]:
    """``T_world_frame``."""
    T = np.eye(4)
    T[:3, 3] = [0.8 * frame, 0, SENSOR_HEIGHT]
    return T


def seen(frame: int) -> NDArray[np.float64]:
    """Points of a frame in the lidar's coordinates."""
    return np.asarray(WORLD - pose(frame)[:3, 3])


def pixels(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where points of a frame (N, 3) are in its picture (N, 2)."""
    there = points @ T_CAMERA_FRAME[:3, :3].T
    image = there @ K.T
    return np.asarray(image[:, :2] / image[:, 2:])


def picture(frame: int) -> bytes:
    """What the camera saw: the sky, the road, and each car as its outline."""
    image = Image.new("RGB", (WIDTH, HEIGHT), SKY)
    draw = ImageDraw.Draw(image)
    draw.rectangle([0, HEIGHT / 2, WIDTH, HEIGHT], fill=ROAD)
    for number in np.argsort(-CARS[:, 0]).tolist():
        mine = slice(GROUND + CAR * number, GROUND + CAR * (number + 1))
        at = pixels(seen(frame)[mine])
        low, high = at.min(axis=0).tolist(), at.max(axis=0).tolist()
        draw.rounded_rectangle([*low, *high], radius=8, fill=PAINT[number])
    packed = io.BytesIO()
    image.save(packed, "JPEG", quality=90)
    return packed.getvalue()


CAMERA = Camera("front", K, T_camera_frame=T_CAMERA_FRAME)


def pictures() -> Iterator[Picture]:
    for frame in range(FRAMES):
        yield Picture(frame, CAMERA, picture(frame), ".jpg", WIDTH, HEIGHT)


def make_street(sequences: Path) -> None:
    """Put the recording ``street`` among a workspace's sequences."""
    import_frames(
        (PointFrame(seen(i).astype(np.float32), COLORS, pose=pose(i)) for i in range(FRAMES)),
        sequences / "street",
        RecordingInfo("street", "Street", 5.0),
        pictures=PictureSource((CAMERA,), pictures),
    )


def make_workspace(factory: pytest.TempPathFactory) -> Path:
    """Make a workspace folder with the recording ``street``, to be copied."""
    folder = factory.mktemp("template") / "workspace"
    (folder / "sequences").mkdir(parents=True)
    make_street(folder / "sequences")
    return folder
