"""Small pictures of frames, for lists of recordings and for the timeline."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences import StoredFrame

WIDTH, HEIGHT = 256, 144
"""Pixels."""
POINTS = 60_000
"""Limit of drawn points; the first points of a frame are a uniform sample."""
SPLAT = 2
"""Width of a point, pixels."""
_FIELD = np.tan(np.deg2rad(50) / 2)
"""Half the height of the field of view at a distance of 1."""
_ONE_WAY = 0.6
"""Length of the mean unit direction from a sensor above which it has a limited field of view."""
_OVERVIEW = np.array([0.45, 0.5, 0.75]) / np.linalg.norm([0.45, 0.5, 0.75])
_BACK = np.array([11, 14, 18], np.uint8)
_QUALITY = 80

Points = NDArray[np.float64]


def thumbnail(frame: StoredFrame, T_room_local: Points) -> bytes:
    """Return a JPEG of ``WIDTH`` x ``HEIGHT`` pixels, from the sensor or an overview."""
    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(draw(frame, T_room_local)).save(stream, "JPEG", quality=_QUALITY)
    return stream.getvalue()


def draw(frame: StoredFrame, T_room_local: Points) -> NDArray[np.uint8]:
    """Return the picture, (HEIGHT, WIDTH, 3) colours."""
    picture = np.broadcast_to(_BACK, (HEIGHT, WIDTH, 3)).copy()
    local = np.asarray(frame.coordinates[:POINTS], np.float64)
    if len(local) == 0:
        return picture
    rotation, origin = T_room_local[:3, :3], T_room_local[:3, 3]
    points = local @ rotation.T + origin
    sensor = np.zeros(3) if frame.viewpoint is None else frame.viewpoint
    eye, target = _view(points, rotation @ sensor + origin)
    across, down, depth = _project(points, eye, target)
    inside = (depth > 1e-3) & (across >= 0) & (across < WIDTH) & (down >= 0) & (down < HEIGHT)
    # Near points are drawn last.
    order = np.flatnonzero(inside)[np.argsort(-depth[inside], kind="stable")]
    colors = _colors(frame, points)[order]
    x, y = across[order].astype(np.intp), down[order].astype(np.intp)
    for right in range(SPLAT):
        for below in range(SPLAT):
            columns, rows = np.minimum(x + right, WIDTH - 1), np.minimum(y + below, HEIGHT - 1)
            picture[rows, columns] = colors
    return picture


def _view(points: Points, sensor: Points) -> tuple[Points, Points]:
    """Return eye and target: the view of a sensor with a limited field, else an overview."""
    offset = points - sensor
    distance = np.maximum(np.linalg.norm(offset, axis=1), 1e-9)
    mean = (offset / distance[:, None]).mean(axis=0)
    length, middle = float(np.linalg.norm(mean)), float(np.median(distance))
    if length > _ONE_WAY:
        forward = mean / length
        return sensor - 0.02 * middle * forward, sensor + middle * forward
    low, high = np.quantile(points, [0.04, 0.96], axis=0)
    target = (low + high) / 2
    radius = max(0.3, 0.55 * float(np.linalg.norm(high - low)))
    return target + _OVERVIEW * radius / _FIELD * 0.85, target


def _project(points: Points, eye: Points, target: Points) -> tuple[Points, Points, Points]:
    """Return pixel columns and rows, and depths in metres."""
    ahead = (target - eye) / max(float(np.linalg.norm(target - eye)), 1e-9)
    right = np.cross(ahead, [0.0, 1.0, 0.0])
    right /= max(float(np.linalg.norm(right)), 1e-9)
    offset = points - eye
    depth = offset @ ahead
    scale = HEIGHT / 2 / _FIELD / np.maximum(depth, 1e-6)
    across = WIDTH / 2 + offset @ right * scale
    return across, HEIGHT / 2 - offset @ np.cross(right, ahead) * scale, depth


def _colors(frame: StoredFrame, points: Points) -> NDArray[np.uint8]:
    """Return colours (n, 3): of the frame, else grey by intensity or height."""
    if frame.rgb is not None:
        return np.asarray(frame.rgb[: len(points)])
    values = points[:, 1] if frame.intensity is None else frame.intensity[: len(points)]
    low, high = np.quantile(values, [0.02, 0.98])
    share = np.clip((values - low) / max(float(high - low), 1e-9), 0, 1)
    grey = (70 + 170 * share).astype(np.uint8)
    return np.repeat(grey[:, None], 3, axis=1)
