"""Where a thing in doubt is looked for: what moves in every frame, what rests now and then."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes

from pointbrush.tracking.model.track import OtherMovers, begin
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps import register as fit
from pointbrush.tracking.steps.predict import search_among

OPTIONS = TrackerOptions()


@pytest.mark.parametrize("moves", [True, False])
def test_what_moves_is_looked_for_elsewhere_in_every_frame(
    tabletop: list[scenes.Frame], moves: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    frame = tabletop[0]
    always = replace(OPTIONS, register=replace(OPTIONS.register, doubt=0.0))
    view = View(1, frame, find_lens(frame, options=always), options=always)
    points = np.flatnonzero(frame.truth == 1)
    none = OtherMovers.none()
    track = begin(view, 2, points, 0.002, none)
    track.last = replace(track.last, alternatives_failed=True)
    for _ in range(4):
        pose = track.motion.poses[-1].copy()
        pose[0, 3] += 0.1 if moves else 0.0
        track.motion = track.motion.add(pose)
    asked = []
    monkeypatch.setattr(fit, "proposals", lambda *_: asked.append(1) or [])
    fit.register(search_among(track, view, points))
    assert bool(asked) == moves
