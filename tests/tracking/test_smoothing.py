"""What was in doubt is looked at once more from a later frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes
from scipy.spatial.transform import Rotation

from pointbrush.tracking import METHODS, Seed, TrackOptions
from pointbrush.tracking import tracker as auto
from pointbrush.tracking.interface import I64, FrameResult, TrackState
from pointbrush.tracking.steps.smooth import Held

COUNT, BLUE, GREEN = 14, (40, 90, 200), (60, 160, 70)


@pytest.fixture(scope="module")
def thrown() -> list[scenes.Frame]:
    """A bat that turns as it flies."""
    rng = np.random.default_rng(3)
    camera = scenes.Camera(scenes.Sensor(256, 212), scenes.room())
    frames = []
    for i in range(COUNT):
        at = np.array([-0.4 + 0.06 * i, 1.3, 1.6])
        along = Rotation.from_euler("z", 0.4 * i).as_matrix() @ [0.0, 0.1, 0.0]
        parts = [
            scenes.Part(1, BLUE, at, at + along, 0.04, 0.03),
            scenes.Part(1, GREEN, at - along, at, 0.02, 0.035),
        ]
        frames.append(camera.shoot(parts, rng))
    return frames


def follow(frames: list[scenes.Frame]) -> list[FrameResult]:
    seeds = [Seed(1, np.flatnonzero(frames[0].truth == 1))]
    options = TrackOptions(continue_lost=True)
    run = METHODS["auto"]().track(
        frames.__getitem__, range(len(frames)), seeds, lambda _: None, options
    )
    return list(run)


def iou(frame: scenes.Frame, found: FrameResult) -> float:
    truth, mine = frame.truth == 1, np.zeros(len(frame.xyz), bool)
    mine[found.assignments.get(1, [])] = True
    return float((mine & truth).sum() / (mine | truth).sum())


def overlooked(monkeypatch: pytest.MonkeyPatch, missed: range) -> None:
    """Let the run forget in some frames what it has found there."""
    step = auto.Run.step

    def forgetful(self: auto.Run, number: int, given: dict[int, I64] | None = None) -> Held:
        held = step(self, number, given)
        if number in missed:
            track: TrackState = replace(
                held.result.tracks[1], confidence=0.0, points=0, state="occluded"
            )
            held = replace(held, result=FrameResult(number, {}, {1: track}))
        return held

    monkeypatch.setattr(auto.Run, "step", forgetful)


def test_what_was_overlooked_is_found_from_a_later_frame(
    thrown: list[scenes.Frame], monkeypatch: pytest.MonkeyPatch
) -> None:
    overlooked(monkeypatch, range(4, 7))
    results = follow(thrown)
    assert [result.frame for result in results] == list(range(COUNT))
    assert all(result.tracks[1].confidence > 0.5 for result in results)
    assert min(iou(thrown[result.frame], result) for result in results[1:]) > 0.9
    # Its poses lead through those frames.
    middle = np.median(thrown[0].xyz[thrown[0].truth == 1], axis=0)
    for result in results:
        pose, seen = result.tracks[1].pose, thrown[result.frame]
        at = pose[:3, :3] @ middle + pose[:3, 3]
        assert np.linalg.norm(at - np.median(seen.xyz[seen.truth == 1], axis=0)) < 0.02


def test_what_stays_in_doubt_is_held_back_for_some_frames_only(
    thrown: list[scenes.Frame], monkeypatch: pytest.MonkeyPatch
) -> None:
    overlooked(monkeypatch, range(1, COUNT))
    results = follow(thrown)
    assert [result.frame for result in results] == list(range(COUNT))
    assert all(not len(result.assignments) for result in results)


def test_what_is_sure_is_given_at_once(thrown: list[scenes.Frame]) -> None:
    seen: list[int] = []

    def frame(number: int) -> scenes.Frame:
        seen.append(number)
        return thrown[number]

    seeds = [Seed(1, np.flatnonzero(thrown[0].truth == 1))]
    order = range(COUNT)
    run = auto.AutoTracker().track(frame, order, seeds, lambda _: None, TrackOptions())
    for result in run:
        del seen[:]
        if result.frame == COUNT - 2:
            break
    assert next(run).frame == COUNT - 1
    assert set(seen) == {COUNT - 1}
