"""Places that a thing was seen beside of."""

from __future__ import annotations

import numpy as np
import scenes
from scipy.spatial.transform import Rotation

from pointbrush.tracking.model.surface import CarvingView, carved, remember
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.view import View

OPTIONS = TrackerOptions()

CENTRE = np.array([0.0, 1.0, 1.6])


def turned(angle: float) -> tuple[View, np.ndarray]:
    """A bar before a wall, turned about the line of sight, and its pose."""
    R = Rotation.from_rotvec([0, 0, angle]).as_matrix()
    bar = scenes.Part(1, (40, 90, 200), CENTRE, np.array([0.2, 0.03, 0.03]), rot=R)
    frame = scenes.Camera(scenes.Sensor(256, 212), scenes.room()).shoot(
        [bar], np.random.default_rng(1)
    )
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = R, CENTRE - R @ CENTRE
    view = View(0, frame, find_lens(frame, options=OPTIONS), options=OPTIONS)
    view.labels = {1: np.flatnonzero(frame.truth == 1)}
    return view, pose


def test_beside_a_thing_is_where_it_was_looked_past() -> None:
    carving_views: list[CarvingView] = []
    for angle in (0.0, 0.01, 0.6, 1.2):
        view, pose = turned(angle)
        remember(carving_views, view, pose, view.xyz[view.labels[1]].astype(float))
    assert len(carving_views) == 3  # the second shows nothing new
    view, pose = turned(0.3)
    own = view.labels[1]
    assert carved(carving_views, view, pose, own, 0.01).mean() < 0.05  # a rim of flying pixels
    moved = pose.copy()
    moved[:3, 3] += pose[:3, :3] @ [0.0, 0.08, 0.0]
    assert carved(carving_views, view, moved, own, 0.01).mean() > 0.6
    assert not carved(carving_views[:1], view, moved, own, 0.01).any()
