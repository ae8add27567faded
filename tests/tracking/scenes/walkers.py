"""People who walk before a depth camera: at rest, carried, or swaying in a hand."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from scenes.figures import person, room
from scenes.raycaster import Camera, Frame, Part, Sensor


def walking(seed=0, frames=60, people=3, sensor=None, rate=30.0) -> list[Frame]:
    rng = np.random.default_rng(seed)
    cam = Camera(sensor or Sensor(), room())
    starts = [
        np.array([rng.uniform(-1.2, 1.2), 0, 2.2 + 0.75 * k + rng.uniform(-0.1, 0.1)])
        for k in range(people)
    ]
    tints = [tuple(rng.integers(40, 220, 3)) for _ in range(people)]
    speed = rng.uniform(0.7, 1.3, people) * np.where(rng.random(people) < 0.5, -1, 1)
    off = rng.random(people) * 6
    out = []
    for i in range(frames):
        time = i / rate
        parts: list[Part] = []
        for k in range(people):
            span = 1.5
            s = (starts[k][0] + speed[k] * time + span) % (4 * span)
            x = s - span if s < 2 * span else 3 * span - s
            head = (np.pi / 2) * np.sign(speed[k]) * (1 if s < 2 * span else -1)
            wob = 0.25 * np.sin(0.6 * time + off[k])
            at = np.array([x, 0, starts[k][2] + wob])
            parts += person(
                k + 1, at, head, off[k] + 2 * np.pi * abs(speed[k]) * time * 0.75, tints[k]
            )
        out.append(cam.shoot(parts, rng))
    return out


def passing(frames=14) -> list[Frame]:
    """Person 1 walks by close to the sensor, and for a while hides person 2, who stands behind."""
    rng = np.random.default_rng(4)
    cam = Camera(Sensor(192, 168, 130.0, origin=np.array([0.0, 1.0, 0.0])), room())
    tints = [(60, 110, 200), (190, 80, 60)]
    out = []
    for i in range(frames):
        t = i / (frames - 1)
        near, far = np.array([1.2 * t - 0.6, 0, 1.6]), np.array([0.19 - 0.38 * t, 0, 2.8])
        parts = person(1, near, np.pi / 2, 6.0 * t, tints[0])
        parts += person(2, far, -np.pi / 2, 6.0 * t + 1, tints[1])
        out.append(cam.shoot(parts, rng))
    return out


def carried(frames=10, hold=None) -> list[Frame]:
    """Person 1 walks, person 2 stands, before a camera that somebody carries, 5 frames a second.

    In the camera's coordinates (right, up, ahead), with its poses.  ``hold``: frame number →
    rotation vector (3,) and place (3,) of the camera.
    """
    rng = np.random.default_rng(5)
    sensor = Sensor(192, 168, 130.0)
    cam = Camera(sensor, room())
    out = []
    for i in range(frames):
        turn, at = (hold or _walks)(i)
        sensor.look, sensor.origin = Rotation.from_rotvec(turn).as_matrix(), at
        parts = person(1, np.array([0.9 - 0.2 * i, 0, 3.2]), -np.pi / 2, 1.2 * i, (60, 110, 200))
        parts += person(2, np.array([0.9, 0, 2.6]), np.pi, 0.1 * i, (190, 80, 60))
        frame = cam.shoot(parts, rng)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = sensor.look, at
        xyz = ((frame.xyz - at) @ sensor.look).astype(np.float32)
        out.append(Frame(xyz, frame.rgb, frame.truth, pose=pose))
    return out


def _walks(i: int) -> tuple[np.ndarray, np.ndarray]:
    return np.array([0.02, 0.3 - 0.05 * i, 0.0]), np.array([0.12 * i - 0.5, 1.4, -0.05 * i])


def swaying(frames=10, far=0.015, turn=0.015) -> list[Frame]:
    """The same before a camera in a hand that is held still: by so many metres, and radians."""
    axes = np.array([[1.0, 0.7, -0.5], [0.4, -1.0, 0.8]])

    def hold(i: int) -> tuple[np.ndarray, np.ndarray]:
        to, fro = np.sin(1.3 * i), np.sin(2.1 * i)
        return turn * (to * axes[0] + fro * axes[1]), np.array([0, 1.4, 0]) + far * fro * axes[0]

    return carried(frames, hold)
