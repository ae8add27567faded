"""What ends where something before it begins may go on behind that."""

from __future__ import annotations

import numpy as np
import scenes

from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import cut_off

OPTIONS = TrackerOptions()
BLUE = (40, 90, 200)


def test_what_comes_out_from_behind_an_object_is_cut_off_by_it_alone() -> None:
    camera = scenes.Camera(scenes.Sensor(256, 212), scenes.room())
    box = scenes.Part(1, BLUE, np.array([0, 1.2, 1.6]), np.array([0.1, 0.12, 0.1]), rot=np.eye(3))
    block = scenes.Part(
        2, BLUE, np.array([0.1, 1.2, 1.73]), np.array([0.06, 0.06, 0.1]), rot=np.eye(3)
    )
    frame = camera.shoot([box, block], np.random.default_rng(2))
    view = View(0, frame, find_lens(frame, options=OPTIONS), options=OPTIONS)
    core, beside = (np.flatnonzero(frame.truth == label) for label in (1, 2))
    assert cut_off(view, beside, 0.01, by=view.marked(core))
    assert not cut_off(view, beside, 0.01, by=view.marked(core[:0]))
    assert not cut_off(view, core, 0.01, by=view.marked(beside))
