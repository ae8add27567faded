"""What a frame shows of a place."""

from __future__ import annotations

import numpy as np
import scenes

from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.view import View

OPTIONS = TrackerOptions()


def test_crops_are_the_same_with_a_pose() -> None:
    rng = np.random.default_rng(0)
    frame = scenes.Frame(rng.uniform([-1, -1, 1], [1, 1, 3], (20_000, 3)).astype(np.float32))
    T = np.eye(4)
    T[:3, 3] = [5.0, 0.0, 1.0]
    here = View(0, frame, None, options=OPTIONS).box(
        np.array([-0.2, -0.2, 1.0]), np.array([0.2, 0.2, 2.0])
    )
    there = View(0, frame, None, OPTIONS, T).box(
        np.array([4.8, -0.2, 2.0]), np.array([5.2, 0.2, 3.0])
    )
    assert len(here) > 10
    assert np.array_equal(here, there)
