"""Frames as a small Kinect sees a room."""

from __future__ import annotations

import io
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pointbrush.formats.cameras.pictures import Camera, Picture, PictureSource
from pointbrush.frame import PointFrame

WIDTH, HEIGHT = 128, 106
FOCAL = 91


def depth_camera(seed: int) -> PointFrame:
    """A room as a Kinect sees it, its noise in depth and colours included."""
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH].reshape(2, -1)
    depth = 2.5 + 0.4 * np.sin(u / 15 + seed) + np.where(v > 60, -0.8, 0.3 * np.cos(v / 11))
    depth += rng.normal(0, 0.0015, len(u)) * depth**2
    xyz = np.column_stack([(u - 64) * depth / FOCAL, (v - 53) * depth / FOCAL, depth])
    shade = 120 + 60 * np.sin(u / 10) + 40 * np.cos(v / 7)
    light = (shade + rng.normal(0, 6, len(u)))[:, None]
    rgb = light + [20, 0, -20] + rng.normal(0, 2, (len(u), 3))
    return PointFrame(xyz.astype(np.float32), rgb.clip(0, 255).astype(np.uint8))


def grey_pictures(
    frames: int, size: tuple[int, int], cameras: Mapping[str, NDArray[np.float64] | None]
) -> PictureSource:
    """Grey pictures of cameras at the place of the sensor, by their name and K."""
    content = io.BytesIO()
    Image.new("L", size, 128).save(content, "PNG")
    known = tuple(Camera(name, K, np.eye(4)) for name, K in cameras.items())
    made = [
        Picture(i, each, content.getvalue(), ".png", *size) for i in range(frames) for each in known
    ]
    return PictureSource(known, lambda: iter(made))
