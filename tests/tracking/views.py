"""Single frames of a scene before a depth camera, as `auto` sees them."""

from __future__ import annotations

import numpy as np
import scenes

from pointbrush.tracking.interface import F64, I64
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.view import View

OPTIONS = TrackerOptions()

BLUE = (40, 90, 200)


def shot(*parts: scenes.Part) -> View:
    """A frame of a room with the ``parts`` in it."""
    camera = scenes.Camera(scenes.Sensor(256, 212), scenes.room())
    frame = camera.shoot(list(parts), np.random.default_rng(2))
    return View(1, frame, find_lens(frame, options=OPTIONS), options=OPTIONS)


def box() -> scenes.Part:
    """A blue box in mid-air, label 1."""
    size = np.array([0.1, 0.12, 0.06])
    return scenes.Part(1, BLUE, np.array([0, 1.2, 1.6]), size, rot=np.eye(3))


def top_of(view: View, own: I64) -> I64:
    """The uppermost of the points ``own`` (M,): an outline."""
    height = view.xyz[own, 1]
    return own[height > np.sort(height)[-20]]


def put(view: View, points: I64, to: F64) -> None:
    """Put ``points`` (M,) of the frame ``to`` (M, 3)."""
    view.frame.xyz[points] = to
    for name in ("xyz", "cells", "depth"):
        view.__dict__.pop(name, None)
