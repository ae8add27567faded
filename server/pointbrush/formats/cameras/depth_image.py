"""Points of a depth image, with a colour image of the same moment.

Points are in the depth camera's axes: x right, y down, z forward.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.formats.cameras.depth_camera import (
    COLOR_FILES,
    Intrinsics,
    find_color_intrinsics,
    find_intrinsics,
)
from pointbrush.formats.cameras.images import opened
from pointbrush.formats.options import ReadOptions, read_bytes
from pointbrush.frame import DepthCamera, PointFrame

MAX_PIXELS = 64_000_000
NO_DEPTH = (65535, 2**31 - 1)
"""Values other than 0 that mark pixels without depth: the greatest of their type."""
NO_DEPTH_FROM = 1e9
"""Floats from here on mark pixels without depth: renderers write a number beyond all distances."""
PER_METRE = 1000.0
"""Default of depth values per metre in images of whole numbers."""
LEAST_PER_METRE = 10.0
"""Least depth values per metre in images of whole numbers; fewer do not resolve shapes."""
LEAST_METRES = 0.01
"""Least plausible median of a frame's depths."""
MOST_METRES = 1000.0
"""Greatest plausible median of a frame's depths."""
DEPTH_MODES = ("I;16", "I;16B", "I;16L", "I", "F")
"""Pillow's names of images of one channel with 16 bits or floats."""
SAME_SHAPE = 0.01
"""Relative difference of aspect between a depth image and a colour image of the same view."""


@dataclass(frozen=True, slots=True)
class Cameras:
    """The cameras of a recording: the size of its depth images, and the intrinsics of both.

    ``scale``: depth values per metre of the layout, used if the camera's file does not state them;
    ``color``: None if colours are from the depth camera's own view.
    """

    size: tuple[int, int]
    depth: Intrinsics
    color: Intrinsics | None
    scale: float | None = None


def cameras_of(image: Path, scale: float | None = None) -> Cameras:
    """Find the cameras of a depth image and of the images beside it; raise BadInputError."""
    with opened(image.name, image, "a depth image") as found:
        size = found.size
    return Cameras(size, find_intrinsics(image, *size), find_color_intrinsics(image), scale)


def read_depth(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """Read a single depth image without colour; intrinsics from a file beside it."""
    yield depth_frame(path, None, cameras_of(path), options)


def depth_frame(
    depth_path: Path, color_path: Path | None, cameras: Cameras, options: ReadOptions
) -> PointFrame:
    """Read the pixels of a depth image that have a depth as points.

    Raises BadInputError for damaged images, depth that is not 16 bits or floats, depths of
    kilometres, and a size that is not the cameras'.
    """
    depth = _depth_image(depth_path)
    height, width = depth.shape
    if (width, height) != cameras.size:
        raise BadInputError(
            f"{depth_path.name}: expected a depth image of {cameras.size[0]}x{cameras.size[1]} as "
            f"the first, got {width}x{height}"
        )
    pixel, known = np.flatnonzero(depth), cameras.depth
    z = _metres(depth_path.name, depth.reshape(-1)[pixel], cameras)
    v, u = np.divmod(pixel, width)
    xyz = np.empty((len(pixel), 3), np.float32)
    xyz[:, 0] = (u - known.cx) * z / known.fx
    xyz[:, 1] = (v - known.cy) * z / known.fy
    xyz[:, 2] = z
    return PointFrame(
        xyz=xyz,
        rgb=None if color_path is None else _colors(color_path, xyz, pixel, cameras),
        pose=options.known.pose,
        timestamp=options.known.timestamp,
        viewpoint=np.zeros(3),
        dropped=depth.size - len(pixel),
        camera=DepthCamera(width, height, known.fx, known.fy, known.cx, known.cy),
        pixel=pixel.astype(np.uint32),
        rows=None if len(pixel) == depth.size else pixel.astype(np.int64),
    )


def is_same_shape(size: tuple[int, int], other: tuple[int, int]) -> bool:
    """Return whether two images, width by height, have the same aspect."""
    return abs(size[0] * other[1] / (size[1] * other[0]) - 1) <= SAME_SHAPE


def _image(path: Path) -> Image.Image:
    with opened(path.name, io.BytesIO(read_bytes(path)), "a whole image") as image:
        if image.width * image.height > MAX_PIXELS:
            raise TooLargeError(
                f"{path.name}: expected at most {MAX_PIXELS} pixels, got "
                f"{image.width}x{image.height}"
            )
        image.load()
    return image


def _depth_image(path: Path) -> NDArray[Any]:
    """Depth values (height, width), 0 for pixels without depth."""
    image = _image(path)
    depth = np.asarray(image)
    if depth.ndim != 2 or image.mode not in DEPTH_MODES:
        raise BadInputError(
            f"{path.name}: expected a depth image of one channel with 16 bits or floats, got mode "
            f"{image.mode}"
        )
    if depth.dtype.kind == "f":
        has_depth = np.isfinite(depth) & (depth > 0) & (depth < NO_DEPTH_FROM)
        return np.where(has_depth & (depth != NO_DEPTH[0]), depth, 0)
    if int(depth.min(initial=0)) < 0:
        raise BadInputError(f"{path.name}: expected depths of 0 or more, got {depth.min()}")
    return np.where(np.isin(depth, NO_DEPTH), 0, depth)


def _metres(name: str, depth: NDArray[Any], cameras: Cameras) -> NDArray[np.float32]:
    """Return depths (n,) in metres: values divided by their number per metre, floats unchanged."""
    real = depth.dtype.kind == "f"
    scale = cameras.depth.scale or cameras.scale or (1.0 if real else PER_METRE)
    z = depth.astype(np.float32) / np.float32(scale)
    median = float(np.median(z)) if len(z) else 1.0
    if not LEAST_METRES < median < MOST_METRES or not (real or scale >= LEAST_PER_METRE):
        stated = f"{cameras.depth.source or 'a camera file'}: depth_scale"
        raise BadInputError(
            f"{name}: expected depths of {LEAST_METRES:g} to {MOST_METRES:,.0f} metres, got "
            f"{median:,.4g} by {scale:g} values per metre; {stated} is values per metre: 1000 for "
            f"millimetres, 1 for metres in floats, at least {LEAST_PER_METRE:g} for whole numbers"
        )
    return z


def _colors(
    path: Path, xyz: NDArray[np.float32], pixel: NDArray[np.int64], cameras: Cameras
) -> NDArray[np.uint8]:
    """Colours (n, 3) of points by the colour camera, else at their own place in the image.

    Points outside of the colour camera's view are black.
    """
    image = _image(path)
    color = np.asarray(image.convert("RGB"))
    width, height = cameras.size
    if cameras.color is not None and image.size != cameras.size:
        known = cameras.color
        u = np.rint(known.fx * xyz[:, 0] / xyz[:, 2] + known.cx)
        v = np.rint(known.fy * xyz[:, 1] / xyz[:, 2] + known.cy)
        seen = (u >= 0) & (u < image.width) & (v >= 0) & (v < image.height)
        colors = np.zeros((len(xyz), 3), np.uint8)
        colors[seen] = color[v[seen].astype(np.int64), u[seen].astype(np.int64)]
        return colors
    if not is_same_shape(image.size, cameras.size):
        raise BadInputError(
            f"{path.name}: expected a colour image of the depth image's shape {width}x{height} "
            f"(registered to it), or the colour camera's matrix in {COLOR_FILES[0]}, got "
            f"{image.width}x{image.height}"
        )
    v, u = np.divmod(pixel, width)
    rows = ((v + 0.5) * image.height / height).astype(np.int64)
    return color[rows, ((u + 0.5) * image.width / width).astype(np.int64)]
