"""Frames of several sensors: two depth cameras and a lidar."""

from __future__ import annotations

from typing import Any

import numpy as np

from pointbrush.frame import FramePart, PointFrame, Sensor, join_sensors
from pointbrush.samples.geometry import axis_angle, rigid, vec
from tests.depth_camera import depth_camera

RIG = (Sensor("left", "depth"), Sensor("right", "depth"), Sensor("top", "spinning"))


def mount(seed: int) -> np.ndarray[Any, Any]:
    rng = np.random.default_rng([seed, 5])
    return rigid(axis_angle(vec(*rng.normal(size=3)), rng.uniform(0, 3)), rng.uniform(-4, 4, 3))


def cloud(count: int, seed: int, dtype: type = np.float32, **more: Any) -> PointFrame:
    rng = np.random.default_rng(seed)
    xyz = rng.normal(0, 3, (count, 3)).astype(dtype)
    return PointFrame(xyz, rgb=rng.integers(0, 255, (count, 3), np.uint8), **more)


def rig(frame: int = 0) -> PointFrame:
    """Two depth cameras, the second with pixels of its images, and a lidar."""
    cameras = [depth_camera(frame), depth_camera(frame + 1)]
    lidar = cloud(3000, frame, intensity=np.full(3000, 7, np.float32))
    parts = [FramePart(sensor, mount(sensor)) for sensor in range(3)]
    return join_sensors(RIG, [*zip(parts[:2], cameras, strict=True), (parts[2], lidar)])


def corrections() -> list[np.ndarray[Any, Any]]:
    """Two centimetres and two degrees for the second sensor."""
    turn = axis_angle(vec(0.2, 1, 0.1), np.radians(2.0))
    return [np.eye(4), rigid(turn, vec(0.02, 0, 0)), np.eye(4)]
