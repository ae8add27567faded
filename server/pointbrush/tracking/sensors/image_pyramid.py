"""Image pyramid of a depth camera's frame, and comparison of two images.

The last channel is the inverse depth, in which planes are linear and stereo noise is uniform; the
others are colours free of shading.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled, innermost
from pointbrush.tracking.interface import F32, F64, I64, TrackFrame
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.options.sensors import VisualOdometryOptions
from pointbrush.tracking.sensors.camera import Lens
from pointbrush.tracking.sensors.view import View


class Image(NamedTuple):
    """A picture: ``values`` (height, width, channels), NaN where unmeasured.

    ``least``: tangents of the middle of its first pixel; ``pitch``: tangents between pixels.
    """

    values: F32
    least: tuple[float, float]
    pitch: tuple[float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """A level of the pyramid: its ``image``, and a uniform sample of its pixels.

    ``points`` (M, 3): across, down and along the picture; ``values`` (M, channels).
    """

    image: Image
    points: F64
    values: F32


def picture_of(
    frame: TrackFrame, lens: Lens, aside: I64 | None = None, *, options: TrackerOptions
) -> list[Layer]:
    """Return the levels of a frame of a sensor with a pixel lattice, the coarsest first.

    ``aside`` (M,): excluded points, which may have moved independently.
    """
    cell, depth = lens.cells(np.asarray(frame.xyz, np.float32), options=options.lens)
    there = cell >= 0
    if aside is not None:
        there[aside] = False
    seen = np.flatnonzero(there)
    tones = View(0, frame, lens, options=options).colour(seen)[:, : 0 if frame.rgb is None else 3]
    flat = np.full((lens.shape[0] * lens.shape[1], tones.shape[1] + 1), np.nan, np.float32)
    flat[cell[seen]] = np.column_stack([tones, 1.0 / depth[seen]])
    image = Image(flat.reshape(*lens.shape, -1), lens.least, lens.pitch)
    while (
        max(image.values.shape) > options.visual_odometry.longest_side_px
        and min(image.values.shape[:2]) >= 2 * options.visual_odometry.shortest_side_px
    ):
        image = _halved(image)
    layers = [_layer(image, options=options.visual_odometry)]
    while min(image.values.shape[:2]) >= 2 * options.visual_odometry.shortest_side_px:
        image = _halved(image)
        layers.insert(0, _layer(image, options=options.visual_odometry))
    return layers


def _halved(image: Image) -> Image:
    height, width = (size // 2 * 2 for size in image.values.shape[:2])
    parts = np.stack([image.values[i:height:2, j:width:2] for i in (0, 1) for j in (0, 1)])
    there = np.isfinite(parts)
    count = there.sum(axis=0)
    mean = np.where(there, parts, 0).sum(axis=0) / np.maximum(count, 1)
    (x, y), (across, down) = image.least, image.pitch
    values = np.where(count > 1, mean, np.nan).astype(np.float32)
    return Image(values, (x + 0.5 * across, y + 0.5 * down), (2 * across, 2 * down))


def _layer(image: Image, options: VisualOdometryOptions) -> Layer:
    _, width, channels = image.values.shape
    flat = image.values.reshape(-1, channels)
    there = np.flatnonzero(np.isfinite(flat[:, -1]))
    there = there[:: max(1, -(-len(there) // options.sampled_pixels))]
    row, column = np.divmod(there, width)
    plane = np.array(image.least) + np.array(image.pitch) * np.stack([column, row], axis=1)
    depth = 1.0 / flat[there, -1:].astype(np.float64)
    return Layer(image, np.hstack([plane * depth, depth]), flat[there])


@innermost
def _seen_at(
    T: F64, point: F64, image: Image, nearest_m: float
) -> tuple[float, float, float, float, float]:
    """Return a moved point, and its column and row, -1 outside the image."""
    x = T[0, 0] * point[0] + T[0, 1] * point[1] + T[0, 2] * point[2] + T[0, 3]
    y = T[1, 0] * point[0] + T[1, 1] * point[1] + T[1, 2] * point[2] + T[1, 3]
    z = T[2, 0] * point[0] + T[2, 1] * point[1] + T[2, 2] * point[2] + T[2, 3]
    if not z > nearest_m:
        return x, y, z, -1.0, -1.0
    u = (x / z - image.least[0]) / image.pitch[0]
    v = (y / z - image.least[1]) / image.pitch[1]
    height, width, _ = image.values.shape
    if u >= 0 and v >= 0 and u < width - 1 and v < height - 1:
        return x, y, z, u, v
    return x, y, z, -1.0, -1.0


@compiled
def compared(T: F64, points: F64, values: F32, image: Image, nearest_m: float) -> F32:
    """Return (M, channels) residuals of an image at moved points; NaN outside."""
    off = np.full(values.shape, np.nan, np.float32)
    last = values.shape[1] - 1
    for i in range(len(points)):
        _, _, z, u, v = _seen_at(T, points[i], image, nearest_m)
        if u < 0:
            continue
        row, column = int(v), int(u)
        a, b = u - column, v - row
        for c in range(last + 1):
            p, q = image.values[row, column, c], image.values[row, column + 1, c]
            r, s = image.values[row + 1, column, c], image.values[row + 1, column + 1, c]
            shown = (p * (1 - a) + q * a) * (1 - b) + (r * (1 - a) + s * a) * b
            off[i, c] = shown - (1 / z if c == last else values[i, c])
    return off


@compiled
def equations(
    T: F64, points: F64, off: F32, image: Image, reach: F64, nearest_m: float
) -> tuple[F64, F64]:
    """Return the normal equations (6, 6) and (6,) of a translation and a rotation of the camera.

    ``off``: residuals of ``compared``; ``reach`` (channels,): residual at a weight of a quarter.
    """
    H, g, J = np.zeros((6, 6)), np.zeros(6), np.empty(6)
    last = off.shape[1] - 1
    for i in range(len(points)):
        far = 0.0
        for c in range(last + 1):
            far += (off[i, c] / reach[c]) ** 2 / (last + 1)
        if not np.isfinite(far):
            continue
        # An outlier in one channel is another surface and is ignored in all channels.
        weight = 1.0 / (1.0 + far) ** 2
        x, y, z, u, v = _seen_at(T, points[i], image, nearest_m)
        row, column = int(v), int(u)
        a, b = u - column, v - row
        for c in range(last + 1):
            p, q = image.values[row, column, c], image.values[row, column + 1, c]
            r, s = image.values[row + 1, column, c], image.values[row + 1, column + 1, c]
            along = ((q - p) * (1 - b) + (s - r) * b) / (image.pitch[0] * z)
            down = ((r - p) * (1 - a) + (s - q) * a) / (image.pitch[1] * z)
            ahead = -(along * x + down * y) / z + (1 / (z * z) if c == last else 0.0)
            J[0], J[1], J[2] = along, down, ahead
            J[3], J[4], J[5] = y * ahead - z * down, z * along - x * ahead, x * down - y * along
            share = weight / (reach[c] * reach[c])
            for k in range(6):
                g[k] -= share * J[k] * off[i, c]
                for m in range(6):
                    H[k, m] += share * J[k] * J[m]
    return H, g
