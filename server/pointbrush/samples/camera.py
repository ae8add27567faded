"""The depth camera of the samples: a Kinect 2 on a tripod."""

from __future__ import annotations

import math

import numpy as np

from pointbrush.frame import DepthCamera
from pointbrush.samples.geometry import Array, Field, axis_angle, rigid, vec

KINECT = DepthCamera(width=512, height=424, fx=365.456, fy=365.456, cx=254.878, cy=205.395)
"""Intrinsics of a Kinect for Xbox One depth sensor (factory calibration of one unit)."""

FPS = 30.0


def pixel_rays(camera: DepthCamera) -> Field:
    """(3, H*W) directions of the pixels in camera coordinates, z = 1; so depth = ray parameter."""
    v, u = np.mgrid[0 : camera.height, 0 : camera.width]
    x = (u.ravel() - camera.cx) / camera.fx
    y = (v.ravel() - camera.cy) / camera.fy
    return np.stack([x, y, np.ones_like(x)]).astype(np.float32)


def tripod(height: float, pitch_degrees: float) -> Array:
    """``T_room_camera`` of a camera above the room's origin that looks along -z and down."""
    flip = np.diag([1.0, -1.0, -1.0])  # camera: x right, y down, z forward
    return rigid(axis_angle(vec(-1, 0, 0), math.radians(pitch_degrees)) @ flip, vec(0, height, 0))
