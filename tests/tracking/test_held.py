"""People who stand before nothing that was ever seen, leave the picture, or are half in it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes
from runs import follow

from pointbrush.tracking.model.track import OtherMovers, begin
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.scene.images import DepthNoise
from pointbrush.tracking.scene.pixels import LastSeen, reappearing_labels
from pointbrush.tracking.sensors.camera import Projection, find_lens
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.predict import search_among
from pointbrush.tracking.steps.relocate import register_and_claim

OPTIONS = TrackerOptions()

NO_RIVALS = OtherMovers.none()


def recording(
    count: int, ways: dict[int, tuple[float, float, float]], colour: bool = True
) -> list[scenes.Frame]:
    """Label → where somebody is at first (x, z) and metres a frame to the right; 5 a second."""
    rng = np.random.default_rng(11)
    cam = scenes.Camera(
        scenes.Sensor(192, 168, 130.0, origin=np.array([0.0, 1.0, 0.0])), scenes.room()
    )
    frames = []
    for i in range(count):
        parts = []
        for label, (x, z, step) in ways.items():
            heading = np.pi if step == 0 else np.copysign(np.pi / 2, step)
            at, phase = np.array([x + step * i, 0, z]), 4.0 * x + 0.9 * i * (step != 0)
            tint = (60, 110, 200) if label == 1 else (190, 80, 60)
            parts += scenes.person(label, at, heading, phase, tint)
        frame = cam.shoot(parts, rng)
        frames.append(frame if colour else replace(frame, rgb=None))
    return frames


def overlaps(frames: list[scenes.Frame], label: int) -> list[float]:
    found = []
    for result in follow(frames)[1:]:
        mask = np.zeros(len(frames[result.frame].xyz), np.bool_)
        mask[result.assignments.get(label, np.empty(0, np.int64))] = True
        truth = frames[result.frame].truth == label
        found.append(float((mask & truth).sum() / max((mask | truth).sum(), 1)))
    return found


@pytest.mark.parametrize("colour", [True, False])
def test_who_stands_all_the_time_is_found_again_when_somebody_has_passed(colour: bool) -> None:
    frames = recording(10, {1: (-0.75, 1.3, 0.18), 2: (0.06, 3.4, 0.0)}, colour)
    shown = [(f.truth == 2).sum() for f in frames]
    assert min(shown) < 0.1 * shown[0]
    assert min(overlaps(frames, 2)[-3:]) > 0.85


@pytest.mark.parametrize(("frames_away", "same"), [(7, True), (11, False)])
def test_without_colour_a_newcomer_is_a_person_who_left_only_a_moment_ago(
    frames_away: int, same: bool
) -> None:
    away = recording(frames_away, {1: (-0.6, 2.4, -0.35), 2: (0.9, 3.0, 0.0)}, colour=False)
    back = recording(8, {1: (-2.2, 2.5, 0.2), 2: (0.9, 3.0, 0.0)}, colour=False)
    assert min((f.truth == 1).sum() for f in away) == 0
    frames = [*away, *back]
    returned = np.array(overlaps(frames, 1)[frames_away + 2 :])
    assert returned.min() > 0.85 if same else returned.max() == 0
    assert min(overlaps(frames, 2)) > 0.85
    *_, last = follow(frames)
    state = last.tracks[1]
    assert state.state == "tracked" if same else state.state in ("occluded", "lost")
    assert state.confidence < 0.5


def test_somebody_painted_by_an_arm_at_the_edge_of_the_picture_is_more_than_that() -> None:
    frame = recording(1, {1: (0.0, 2.4, 0.0)})[0]
    arm = (frame.truth == 1) & (frame.xyz[:, 0] > 0.17)
    assert 40 < arm.sum() < 300

    def large(seen: np.ndarray) -> bool:
        rows = np.flatnonzero(seen)
        some = replace(frame, xyz=frame.xyz[rows], rgb=frame.rgb[rows], truth=None)
        view = View(0, some, find_lens(frame, options=OPTIONS), options=OPTIONS)
        return begin(view, 1, np.flatnonzero(arm[rows]), 0.0, NO_RIVALS).large

    assert not large(np.ones(len(arm), np.bool_))
    behind = frame.xyz[:, 0] / frame.xyz[:, 2]
    assert large(behind >= np.quantile(behind[arm], 0.3))


def test_where_all_that_is_seen_ends_is_no_edge_of_the_picture() -> None:
    frame = recording(1, {1: (0.0, 2.4, 0.0)})[0]
    arm = np.flatnonzero((frame.truth == 1) & (frame.xyz[:, 0] > 0.17))
    alone = replace(frame, xyz=frame.xyz[arm], rgb=frame.rgb[arm], truth=None)
    view, every = (
        View(0, alone, find_lens(frame, options=OPTIONS), options=OPTIONS),
        np.arange(len(arm)),
    )
    view.labels = {1: every}
    assert not begin(view, 1, every, 0.0, NO_RIVALS).large


def test_a_cell_is_held_until_what_lies_behind_shows_or_the_thing_is_elsewhere() -> None:
    limit, unknown = np.full(4, 0.02, np.float32), np.full(4, np.nan, np.float32)

    def seen(*depths: float) -> np.ndarray:
        return np.array(depths, np.float32)

    def owned(*labels: int) -> np.ndarray:
        return np.array(labels, np.int32)

    held = LastSeen.nothing(4)
    held.learn(seen(2, 2, 2, 4), owned(7, 7, 7, 0), limit, unknown, options=OPTIONS.background)
    held.learn(seen(1, 1, 2, 4), owned(3, 3, 7, 0), limit, unknown, options=OPTIONS.background)
    missed = held.learn(
        seen(2, 1, 2, 4), owned(0, 0, 0, 0), limit, unknown, options=OPTIONS.background
    )
    assert missed.tolist() == [True, False, True, False]
    points = Projection(np.arange(4, dtype=np.int32), seen(2, 2.5, 2, 4))
    shown = reappearing_labels(points, np.arange(4), held, DepthNoise(0.01, 0.0), 2.0)
    assert shown.tolist() == [7, 0, 7, 0]
    held.learn(seen(3, 2, 2, 4), owned(0, 0, 0, 0), limit, unknown, options=OPTIONS.background)
    assert held.label.tolist() == [0, 7, 7, 0]
    held.learn(seen(3, 1, 1, 3.5), owned(0, 0, 0, 7), limit, unknown, options=OPTIONS.background)
    assert held.label.tolist() == [0, 0, 0, 7]


@pytest.mark.parametrize("hidden", [True, False])
def test_nobody_jumps_from_behind_another_to_somebody_in_like_clothes(hidden: bool) -> None:
    start = recording(1, {2: (0.06, 3.4, 0.0)})[0]
    view = View(0, start, find_lens(start, options=OPTIONS), options=OPTIONS)
    track = begin(view, 2, np.flatnonzero(start.truth == 2), 0.0, NO_RIVALS)
    track.motion = replace(track.motion, poses=(np.eye(4),) * 3)
    before = {1: (0.03, 1.3, 0.0)} if hidden else {}
    now = recording(1, before | {3: (0.9, 3.3, 0.0)})[0]
    view = View(1, now, find_lens(now, options=OPTIONS), options=OPTIONS)
    search = search_among(track, view, np.flatnonzero(now.truth == 3))
    claim = register_and_claim(track, view, search).claim
    assert len(claim.indices) < 5 if hidden else len(claim.indices) > 300
