"""Toys that bend are followed whole; what is stiff is not taken to bend."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes
from runs import follow
from scipy.spatial.transform import Rotation

from pointbrush.tracking.interface import I64
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import Bending, OtherMovers, Track, begin
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps import update as bending
from pointbrush.tracking.steps.association import LabelledPoints
from pointbrush.tracking.steps.claim import Claim, claim
from pointbrush.tracking.steps.update import Observation, learn
from pointbrush.tracking.steps.verdict import Verdict, judge

OPTIONS = TrackerOptions()


def snake(frames: int, bend: float, every: int = 1) -> list[scenes.Frame]:
    """A chain of capsules on the floor, waving by ``bend`` radians a joint; some of its frames."""
    rng = np.random.default_rng(6)
    sensor = scenes.Sensor(origin=np.array([0.0, 0.6, 0.6]))
    sensor.look = Rotation.from_euler("x", 22, degrees=True).as_matrix()
    camera = scenes.Camera(sensor, scenes.room())
    result = []
    for number in range(0, frames, every):
        at, angle, parts = np.array([-0.3, 0.03, 1.5]), 0.2 * np.sin(0.05 * number), []
        for joint in range(8):
            angle += bend * np.sin(0.06 * number + joint)
            to = at + 0.07 * np.array([np.cos(angle), 0.0, np.sin(angle)])
            tint = (200, 160, 40) if joint % 2 else (60, 140, 80)
            parts.append(scenes.Part(1, tint, at, to, 0.03, 0.03))
            at = to
        result.append(camera.shoot(parts, rng))
    return result


def union(found: np.ndarray, truth: np.ndarray) -> float:
    """IoU of a label's points with the (N,) truth."""
    both = np.count_nonzero(truth[found])
    return both / (np.count_nonzero(truth) + len(found) - both)


def doors(frames: int) -> list[scenes.Frame]:
    """Two doors of a cupboard; the left one opens, pushed by nobody."""
    rng = np.random.default_rng(3)
    upright, z = np.eye(3), 2.2
    sides = [
        scenes.Part(0, (120, 90, 60), np.array([0.0, 0.9, z + 0.3]), np.array([0.62, 0.9, 0.28]))
    ]
    sides[0].rot = upright
    camera = scenes.Camera(scenes.Sensor(), scenes.room() + sides)
    result = []
    for number in range(frames):
        turn = Rotation.from_euler("y", 0.09 * max(0, number - 2)).as_matrix()
        hinge, half = np.array([-0.6, 0.9, z]), np.array([0.29, 0.85, 0.01])
        left = scenes.Part(1, (90, 140, 160), hinge + turn @ [0.3, 0.0, 0.0], half, rot=turn)
        right = scenes.Part(2, (95, 145, 165), np.array([0.3, 0.9, z]), half, rot=upright)
        result.append(camera.shoot([left, right], rng))
    return result


def puppet(number: int, rng: np.random.Generator) -> scenes.Frame:
    """A toy in a hand, all round, as several cameras see it together: no scene, no one place."""
    ball = rng.normal(size=(6000, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    sway = np.array([0.03 * number, 0.02 * np.sin(number), 0.0])
    nod = Rotation.from_euler("x", 0.5 * np.sin(0.5 * number)).as_matrix()
    body = ball[:2000] * [0.09, 0.12, 0.07] + sway
    head = (ball[2000:3000] * 0.06 + [0.0, 0.16, 0.0]) @ nod.T + sway
    arm = ball[3000:4000] * [0.12, 0.035, 0.035] + [0.2, 0.0, 0.0] + sway
    torso = ball[4000:] * [0.2, 0.4, 0.12] + [0.0, 0.0, 0.5]
    xyz = np.vstack([body, head, arm, torso]) + [0.3, 1.0, 0.9]
    tints = [(190, 140, 60), (200, 150, 90), (210, 160, 130), (60, 80, 150)]
    rgb = np.repeat(np.array(tints), [2000, 1000, 1000, 2000], axis=0)
    rgb = np.clip(rgb + rng.normal(0, 4, rgb.shape), 0, 255).astype(np.uint8)
    truth = (np.arange(6000) < 3000).astype(np.uint16)
    return scenes.Frame(xyz.astype(np.float32), rgb, truth)


def test_a_door_that_opens_is_no_person_and_leaves_its_neighbour_alone() -> None:
    frames = doors(14)
    last = follow(frames)[-1]
    for label in (1, 2):
        assert union(last.assignments[label], frames[-1].truth == label) > 0.8


def test_a_toy_seen_all_round_is_kept_apart_from_the_hand_that_moves_it() -> None:
    rng = np.random.default_rng(1)
    frames = [puppet(number, rng) for number in range(12)]
    last = follow(frames)[-1]
    assert union(last.assignments[1], frames[-1].truth == 1) > 0.9


def test_a_snake_that_waves_is_followed_to_its_ends() -> None:
    frames = snake(24, bend=0.3)
    last = follow(frames)[-1]
    truth = frames[-1].truth == 1
    found = last.assignments[1]
    both = np.count_nonzero(truth[found])
    assert both > 0.9 * (np.count_nonzero(truth) + len(found) - both)


def test_a_snake_that_no_rigid_fit_explains_is_bent_all_the_same() -> None:
    frames = snake(48, bend=1.0, every=3)
    last = follow(frames)[-1]
    truth = frames[-1].truth == 1
    found = last.assignments[1]
    both = np.count_nonzero(truth[found])
    assert both > 0.7 * (np.count_nonzero(truth) + len(found) - both)


def test_what_one_frame_alone_says_makes_nothing_soft(monkeypatch: pytest.MonkeyPatch) -> None:
    frame = snake(1, bend=0.0)[0]
    view = View(3, frame, find_lens(frame, options=OPTIONS), options=OPTIONS)
    mine, none = np.flatnonzero(frame.truth == 1), np.empty(0, np.int64)
    track = begin(view, 1, mine, 0.004, OtherMovers.none())
    xyz = track.model.xyz
    box = (xyz.min(axis=0), xyz.max(axis=0))
    place = Registration(np.eye(4), xyz, box, mine, mine, mine, cost=0.1)
    found = claim(view, mine, xyz, track.model.colour, 0.0, track.reach)
    verdict = Verdict(True, 1.0, 1.0, none, none, 1.0)
    observation = Observation(view, place, LabelledPoints(found), verdict)
    monkeypatch.setattr(bending, "bent_share", lambda *_: 0.5)  # a wrong pose
    bending.note_strain(track, observation)
    assert not track.soft
    for _ in range(6):
        bending.note_strain(track, observation)
    assert track.soft
    track.bending, track.size = (
        Bending(),
        2.0 * OPTIONS.track.dense_points,
    )  # many points are seldom posed wrongly
    bending.note_strain(track, observation)
    assert track.soft


def covered(share: float) -> scenes.Frame:
    """A ball on the floor, about ``share`` of its width behind a board."""
    camera = scenes.Camera(scenes.Sensor(256, 212, origin=np.array([0.0, 1.0, 0.0])), scenes.room())
    at = np.array([0.0, 0.9, 1.2])
    parts = [scenes.Part(1, (190, 60, 40), at, at + [0.0, 0.01, 0.0], 0.1, 0.1)]
    if share:
        at, half = np.array([-0.3 + 0.14 * share, 1.0, 0.9]), np.array([0.2, 0.5, 0.01])
        parts.append(scenes.Part(0, (70, 80, 110), at, half, rot=np.eye(3)))
    return camera.shoot(parts, np.random.default_rng(4))


def rested(share: float) -> tuple[Track, View, I64]:
    """A ball that was painted in full view and has rested since, and its points (M,) now."""
    first, frame = covered(0.0), covered(share)
    none = OtherMovers.none()
    lens = find_lens(first, options=OPTIONS)
    track = begin(
        View(0, first, lens, options=OPTIONS), 1, np.flatnonzero(first.truth == 1), 0.004, none
    )
    for _ in range(4):
        track.motion = track.motion.add(np.eye(4))
    return track, View(1, frame, lens, options=OPTIONS), np.flatnonzero(frame.truth == 1)


def found_where_it_was(track: Track, view: View, mine: I64) -> tuple[Registration, Claim, Verdict]:
    xyz = track.model.xyz
    place = Registration(
        np.eye(4), xyz, (xyz.min(axis=0), xyz.max(axis=0)), mine, mine, mine, cost=0.1
    )
    found = claim(view, mine, xyz, track.model.colour, track.weight, track.reach)
    return place, found, judge(track, view, place.pose, xyz, found)


def test_the_rim_of_what_is_half_hidden_does_not_make_it_soft() -> None:
    track, view, mine = rested(1.0)
    place, found, verdict = found_where_it_was(track, view, mine)
    assert np.count_nonzero(~verdict.hidden) > 100
    assert (
        bending.bent_share(track, Observation(view, place, LabelledPoints(found), verdict))
        < OPTIONS.track.soft_strain
    )


def test_what_little_shows_of_a_thing_does_not_make_it_bend() -> None:
    for visible, bends in ((0.1, False), (1.0, True)):
        track, view, mine = rested(1.0)
        for _ in range(6):
            place, found, verdict = found_where_it_was(track, view, mine)
            poor = replace(verdict, inliers=0.5, visible=visible)
            learn(track, Observation(view, place, LabelledPoints(found), poor))
        assert track.bends == bends
