"""What a lidar sees: coarser the farther it is, never in a hand, at rest or on the move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes
from runs import follow

from pointbrush.errors import BadInputError
from pointbrush.tracking import METHODS, Seed, TrackOptions
from pointbrush.tracking.compute.grid import bounds, cells_of
from pointbrush.tracking.interface import KnownSensor
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import Bending, OtherMovers, Track, begin
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.scene.scans import PointBackground
from pointbrush.tracking.scene.scene import Scene
from pointbrush.tracking.sensors.scan_odometry import find_trajectory
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.association import LabelledPoints
from pointbrush.tracking.steps.claim import Claim, claim
from pointbrush.tracking.steps.predict import crop
from pointbrush.tracking.steps.register import register
from pointbrush.tracking.steps.update import Observation, learn
from pointbrush.tracking.steps.verdict import Verdict, judge

OPTIONS = TrackerOptions()


@pytest.fixture(scope="module")
def resting() -> list[scenes.Frame]:
    return scenes.street(seed=7, frames=8, ego=False)


def iou(frame: scenes.Frame, points: np.ndarray, label: int) -> float:
    assert frame.truth is not None
    both = np.count_nonzero(frame.truth[points] == label)
    return both / (np.count_nonzero(frame.truth == label) + len(points) - both)


def test_what_passes_a_lidar_at_rest_is_kept_whole(resting: list[scenes.Frame]) -> None:
    """Cars come as near as a few metres and go: their points get closer, and farther apart."""
    found = follow(resting)
    good = total = 0
    for result in found[1:]:
        frame = resting[result.frame]
        assert frame.truth is not None
        for label, track in result.tracks.items():
            if min(np.count_nonzero(f.truth == label) for f in (frame, resting[0])) < 40:
                continue
            overlap = iou(frame, result.assignments.get(label, np.empty(0, np.int64)), label)
            total += 1
            good += overlap > 0.8
            # What is said to be sure is right.
            assert track.confidence <= 0.9 or overlap > 0.7
    assert good > 0.93 * total


def test_a_point_that_flew_off_leaves_the_others_in_their_cells() -> None:
    xyz = np.array([[0.0, 0, 0], [0.05, 0, 0], [1.0, 0, 0], [3e38, -3e38, 0]])
    cell = cells_of(xyz, 0.1)
    assert cell[0] == cell[1]
    assert len(set(cell[1:].tolist())) == 3


@pytest.mark.parametrize("method", ["auto", "icp"])
@pytest.mark.parametrize("order", [range(9), range(7, -2, -1)])
def test_frames_that_the_recording_has_not_are_refused(
    resting: list[scenes.Frame], order: range, method: str
) -> None:
    seeds = [Seed(1, np.arange(50))]
    run = METHODS[method]().track(resting.__getitem__, order, seeds, lambda _: None, TrackOptions())
    with pytest.raises(BadInputError, match="frames of the recording, got"):
        next(run)


def test_poses_that_are_none_count_as_unknown(resting: list[scenes.Frame]) -> None:
    flat = [replace(frame, pose=np.zeros((4, 4))) for frame in resting[:2]]
    assert find_trajectory(flat.__getitem__, range(2), options=OPTIONS) is None


def in_the_world(told: bool) -> list[scenes.Frame]:
    """A street in the world's coordinates, whether its viewpoints are told or not; no poses."""
    world = []
    for frame in scenes.street(seed=1, frames=3):
        away = np.array([31.0, 4.0, -14.0])
        at = frame.xyz @ frame.pose[:3, :3].T + frame.pose[:3, 3] + away
        eye = frame.pose[:3, 3] + away if told else None
        world.append(scenes.Frame(at.astype(np.float32), viewpoint=eye, truth=frame.truth))
    return world


@pytest.mark.parametrize("told", [False, True])
def test_a_street_in_the_worlds_coordinates_is_seen_by_a_lidar_that_moves(told: bool) -> None:
    """No pose: what is far away all round is a lidar's, and one that is told elsewhere moves."""
    world = in_the_world(told)
    scene = Scene(
        world.__getitem__,
        [0, 1, 2],
        lambda xyz: np.zeros(len(xyz)),
        ahead=False,
        known=KnownSensor(),
        options=OPTIONS,
    )
    for number in range(3):
        view = scene.view(number)
        assert (view.eye is None) != told
        assert view.scans
        assert view.roams
        assert 0.2 < view.low.mean() < 0.9


def test_a_lidar_whose_viewpoint_stays_is_at_rest() -> None:
    frame = in_the_world(told=True)[0]
    assert find_trajectory([frame, frame].__getitem__, range(2), options=OPTIONS) is None


def half_hidden() -> tuple[Track, View, Registration, Claim, Verdict]:
    """A box of which a lidar at rest sees one end only, densely, after its whole side."""
    rng = np.random.default_rng(1)
    side = rng.uniform((0, 5, -1), (8, 5.01, 0.5), (800, 3))
    end = rng.uniform((0, 5, -1), (0.3, 5.01, 0.5), (300, 3))
    walls = rng.uniform((-30, 20, -1.7), (30, 20.1, 4), (5000, 3))
    xyz = np.concatenate([end, side, walls]).astype(np.float32)
    view = View(0, scenes.Frame(xyz), None, OPTIONS, np.eye(4))
    track = begin(view, 1, np.arange(1100), 0.0, OtherMovers(np.empty((0, 3)), np.empty((0, 3))))
    here = np.arange(300)
    world = track.model.xyz
    place = Registration(np.eye(4), world, bounds(world), here, here, here, 0.1)
    found = claim(view, here, world, track.model.colour, 0.0, 3 * track.unit)
    return track, view, place, found, judge(track, view, np.eye(4), world, found)


def test_what_shows_many_of_its_points_is_there_though_most_of_it_is_hidden() -> None:
    """What hides it is known too coarsely to tell which part of it should be seen."""
    track, view, place, found, verdict = half_hidden()
    assert track.scanned
    assert len(found.indices) > 250
    assert verdict.inliers < 0.25
    assert verdict.found
    half = found.pick(np.arange(len(found.indices)) < 150)
    assert judge(track, view, place.pose, place.world, half).found
    few = found.pick(np.arange(len(found.indices)) < 80)
    assert not judge(track, view, place.pose, place.world, few).found


def test_what_bends_and_is_half_hidden_keeps_what_it_was() -> None:
    track, view, place, found, verdict = half_hidden()
    track.bending = Bending(share=0.5)
    learn(track, Observation(view, place, LabelledPoints(found), verdict))
    assert track.bends
    assert np.ptp(track.model.xyz[:, 0]) > 7.5


def test_what_comes_near_is_not_asked_more_finely_than_its_model_is_known() -> None:
    track = half_hidden()[0]
    unit, spacing = track.unit, track.model.spacing
    track.set_distance(10.0)
    for distance in (5.0, 2.5, 1.25):
        track.set_distance(distance)
    assert 0.4 * spacing < track.unit < unit
    for distance in (2.5, 5.0, 10.0):
        track.set_distance(distance)
    assert np.isclose(track.unit, unit)


def test_a_side_that_comes_into_view_beside_a_coarse_model_is_learnt() -> None:
    whole, view, place, _, _ = half_hidden()
    old = np.flatnonzero(view.xyz[:1100, 0] < 5.0)
    grown = np.flatnonzero((view.xyz[:1100, 0] > 5.32) & (view.xyz[:1100, 0] < 5.38))
    track = begin(view, 1, old, 0.0, whole.other_movers)
    track.unit, track.model.spacing = 0.1, 0.2
    world = track.model.xyz
    found = claim(view, old, world, track.model.colour, 0.0, 3 * track.unit)
    verdict = judge(track, view, np.eye(4), world, found)
    learn(track, Observation(view, place, LabelledPoints(found, grown), verdict))
    assert track.model.xyz[:, 0].max() > 5.3


@pytest.mark.parametrize(("frames", "beside", "most"), [(3, 2.8, 2.0), (0, 4.0, 3.6)])
def test_a_car_that_is_gone_is_not_the_one_beside_it(
    frames: int, beside: float, most: float
) -> None:
    """What drives past in the next lane is nearer to its shape than to its way.

    Nor may a car have gone farther than its size while its motion is unknown.
    """
    view, nobody = (
        beside_the_road(0.0),
        PointBackground(OPTIONS, lambda xyz: np.zeros(len(xyz), np.float32)),
    )
    track = parked(view, frames)
    later = beside_the_road(beside)
    search = crop(track, later, nobody, np.ones(len(later.xyz), np.bool_))
    assert search is not None
    pose = register(search).pose
    assert abs(pose[1, 3]) < most


SIDE = 8000


def beside_the_road(shift: float) -> View:
    """The side of a car, ``SIDE`` points, 5 metres and ``shift`` from a lidar at rest."""
    rng = np.random.default_rng(1)
    side = rng.uniform((0, 5, -1), (4, 5.01, 0.5), (SIDE, 3))
    walls = rng.uniform((-30, 20, -1.7), (30, 20.1, 4), (5000, 3))
    walls = walls[(walls[:, 0] < 0) | (walls[:, 0] > 16)]  # not behind the car
    xyz = np.concatenate([side + np.array([0.0, shift, 0.0]), walls]).astype(np.float32)
    return View(1, scenes.Frame(xyz), None, OPTIONS, None, np.zeros(3))


def parked(view: View, frames: int) -> Track:
    """The car of ``beside_the_road``, which has stood there for some ``frames``."""
    track = begin(view, 1, np.arange(SIDE), 0.0, OtherMovers(np.empty((0, 3)), np.empty((0, 3))))
    for _ in range(frames):
        track.motion = track.motion.add(np.eye(4))
    return track


@pytest.mark.parametrize(("beside", "gap"), [(-0.7, 1), (-3.0, 8), (2.6, 8)])
def test_a_parked_car_that_is_hidden_is_not_a_like_one(beside: float, gap: int) -> None:
    """Not what drives by before it, nor what stands beside it, however long it was hidden."""
    view, nobody = (
        beside_the_road(0.0),
        PointBackground(OPTIONS, lambda xyz: np.zeros(len(xyz), np.float32)),
    )
    track = parked(view, 3)
    assert track.stands
    track.motion = replace(track.motion, gap=gap)
    later = beside_the_road(beside)
    search = crop(track, later, nobody, np.ones(len(later.xyz), np.bool_))
    assert search is not None
    pose = register(search).pose
    assert np.linalg.norm(pose[:3, 3]) < 0.3


def test_what_was_hidden_and_stood_before_a_lidar_need_not_wait_for_the_others() -> None:
    track = parked(beside_the_road(0.0), 3)
    track.frames_unseen, track.motion = 5, replace(track.motion, gap=6)
    assert not track.absent
    *before, last = track.motion.poses
    away = last + np.eye(4, k=3)  # 1 metre on
    track.motion = replace(track.motion, poses=(*before, away))
    assert track.absent
