"""Boxes fitted to points: completed where nothing was seen, steady, upright, ahead."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from pointbrush.errors import BadInputError
from pointbrush.fitting import FittedBox, Observation, fit_box, priors_of
from pointbrush.geometry.quaternions import rotation_of
from tests.fitting.cars import SIZE, UP, Floats, placed, seen


def heading(made: FittedBox, frame: int = 0) -> Floats:
    return np.asarray(rotation_of(made.poses[frame].quaternion)[:, 0])


def test_a_side_that_is_not_seen_grows_away_from_the_sensor() -> None:
    made = fit_box([seen("rt", 0.0, (1.0, 8.0))], priors_of("car"))
    only_side = fit_box([seen("r", 0.0, (1.0, 8.0))], priors_of("car"))
    for box in (made, only_side):
        near = box.poses[0].centre[1] - box.size[1] / 2
        assert near == pytest.approx(8 - 0.9, abs=0.06)
        assert box.size[1] == pytest.approx(1.84, abs=0.1)
        assert box.size[0] == pytest.approx(4.3, abs=0.2)
        assert box.poses[0].centre[2] - box.size[2] / 2 == pytest.approx(0, abs=0.06)


def test_a_sensor_on_the_ground_is_the_origin_of_a_vehicle() -> None:
    car = replace(seen("rb", 0.0, (4.0, 4.0)), sensor=np.zeros(3))
    assert fit_box([car], priors_of("van")).size[0] < 4.9  # a van of 5.4 m has no space


def test_points_painted_beside_a_car_do_not_widen_its_box() -> None:
    clean = seen("rtb", 0.4, (9.0, 2.0))
    stray = placed(
        np.random.default_rng(5).uniform(-0.3, 0.3, (60, 3)) + [0, 3.5, 0.5], 0.4, (9, 2)
    )
    painted = replace(clean, xyz=np.concatenate([clean.xyz, stray]))
    made = fit_box([painted], priors_of("car"))
    assert made.size == pytest.approx(fit_box([clean], priors_of("car")).size, abs=0.05)


def drive(speed: float) -> Iterator[Observation]:
    """A car that goes along its own direction, or stays, and its sides that are seen in turn."""
    for frame, sides in enumerate(("rf", "rf", "rt", "r", "rb", "rb", "rb", "b")):
        way = speed * frame / 10
        yield seen(sides, 0.3, (9 + way * np.cos(0.3), 6 + way * np.sin(0.3)), frame)


def test_a_parked_car_stays_in_place() -> None:
    made = fit_box(list(drive(0.0)), priors_of("car"))
    assert not made.moves
    centres = np.array([pose.centre for pose in made.poses.values()])
    assert np.ptp(centres, axis=0).max() < 0.02
    assert made.size[:2] == pytest.approx(SIZE[:2], abs=0.2)


def test_what_moves_has_its_front_ahead() -> None:
    for speed in (6.0, -6.0):
        made = fit_box(list(drive(speed)), priors_of("vehicle"))
        assert made.moves
        assert made.front_known
        assert made.kind == "car"
        for frame in made.poses:
            ahead = np.array([np.cos(0.3), np.sin(0.3), 0]) * np.sign(speed)
            assert heading(made, frame) @ ahead > np.cos(np.radians(5))


def passing(direction: int, step: float) -> Iterator[Observation]:
    """A car with a bonnet at one end that a sensor passes, ``step`` metres a frame."""
    for frame in range(4):
        seen_now = seen("rfb", 0.0, (9 - step * frame, 4.0), frame)
        along, height = (seen_now.xyz[:, 0] - (9 - step * frame)) * direction, seen_now.xyz[:, 2]
        bonnet = (along > 1.0) & (height > 0.9)
        pose = np.eye(4)
        pose[0, 3] = step * frame
        yield replace(seen_now, xyz=seen_now.xyz[~bonnet], T_world_frame=pose)


@pytest.mark.parametrize("direction", [1, -1])
def test_a_car_that_is_passed_heads_to_its_bonnet(direction: int) -> None:
    made = fit_box(list(passing(direction, 1.0)), priors_of("car"))
    assert (made.moves, made.front_known) == (False, True)
    assert heading(made)[0] * direction > 0.99


@pytest.mark.parametrize("direction", [1, -1])
def test_a_lorry_that_is_passed_heads_to_the_gap_behind_its_cab(direction: int) -> None:
    scale = np.array([2.1, 1.4, 2.1])
    for gap, known in ((0.4, True), (0.0, False)):
        passed = []
        for step in range(4):
            car = seen("rfb", 0.0, (8.0 - step, 6.0), step)
            along = (car.xyz[:, 0] - (8.0 - step)) * 2.1 * direction
            lorry = (car.xyz - [8 - step, 6, 0]) * scale + [8 - step, 6.5, 0]
            pose = np.eye(4)
            pose[0, 3] = step
            closed = np.abs(along - 2.4) >= gap / 2
            passed.append(replace(car, xyz=lorry[closed], T_world_frame=pose))
        made = fit_box(passed, priors_of("truck"))
        assert (made.moves, made.front_known) == (False, known)
        assert not known or heading(made)[0] * direction > 0.99


def test_the_front_is_unknown_without_motion_or_shape() -> None:
    assert not fit_box(list(passing(1, 0.0)), priors_of("car")).front_known
    unposed = [replace(each, T_world_frame=None) for each in passing(1, 1.0)]
    assert not fit_box(unposed, priors_of("car")).front_known
    assert not fit_box(list(drive(0.0)), priors_of("car")).front_known


def turning(
    rate: float, start: tuple[float, float], sides: tuple[str, str], points: int
) -> Iterator[Observation]:
    """A car that turns from the first frame on, ``rate`` radians a second at 5 m/s.

    Of its ``sides`` the former are seen by few ``points`` in four frames, then the latter by more.
    """
    at = np.array(start)
    for frame in range(10):
        yaw = rate * frame / 10
        whole = seen(sides[frame > 3], yaw, (float(at[0]), float(at[1])), frame)
        some = np.random.default_rng(frame).permutation(len(whole.xyz))
        yield replace(whole, xyz=whole.xyz[some[: points if frame < 4 else 4 * points]])
        at = at + 0.5 * np.array([np.cos(yaw), np.sin(yaw)])


@pytest.mark.parametrize(
    ("rate", "start", "sides", "points"),
    [
        (0.6, (-7.0, -9.0), ("f", "fl"), 40),
        (-0.6, (-12.0, 6.0), ("l", "lb"), 100),
        (-0.6, (-7.0, -9.0), ("l", "lb"), 40),
    ],
)
def test_what_turns_at_once_heads_along_its_turn(
    rate: float, start: tuple[float, float], sides: tuple[str, str], points: int
) -> None:
    made = fit_box(list(turning(rate, start, sides, points)), priors_of("car"))
    for frame in made.poses:
        yaw = rate * frame / 10
        ahead = np.array([np.cos(yaw), np.sin(yaw), 0])
        assert heading(made, frame) @ ahead > np.cos(np.radians(5)), frame


def test_boxes_are_upright_in_coordinates_whose_up_is_another_axis() -> None:
    z_up = seen("rtb", 0.4, (9.0, 2.0))
    turn = np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]])  # a camera's axes: y down, z ahead
    assert z_up.sensor is not None
    camera = replace(
        z_up, xyz=z_up.xyz @ turn.T, up=turn @ UP, sensor=turn @ z_up.sensor,
        others=z_up.others @ turn.T, T_world_frame=None,
    )  # fmt: skip
    a, b = fit_box([z_up], priors_of("car")), fit_box([camera], priors_of("car"))
    assert b.size == pytest.approx(a.size, abs=0.02)
    assert b.poses[0].centre == pytest.approx(turn @ a.poses[0].centre, abs=0.02)
    assert rotation_of(b.poses[0].quaternion)[:, 2] == pytest.approx(turn @ UP, abs=1e-6)


@pytest.mark.parametrize("yaw", [-0.4, 0.3, 1.2])
def test_a_standing_person_faces_across_the_shoulders(yaw: float) -> None:
    rng = np.random.default_rng(3)
    around, up = rng.uniform(0, 2 * np.pi, 900), rng.uniform(0.05, 1.7, 900)
    wide = np.where((up > 1.15) & (up < 1.45), 0.3, 0.13)
    person = np.column_stack([0.13 * np.cos(around), wide * np.sin(around), up])
    seen_now = replace(seen("b", 0.0, (4.0, 3.0)), xyz=placed(person, yaw, (4.0, 3.0)))
    made = fit_box([seen_now], priors_of("pedestrian"))
    assert abs(heading(made) @ [np.cos(yaw), np.sin(yaw), 0]) > np.cos(np.radians(10))


def test_a_class_of_several_kinds_takes_the_one_that_fits() -> None:
    bus = seen("rtb", 0.0, (1.0, 9.0))
    grown = replace(bus, xyz=(bus.xyz - [1, 9, 0]) * [2.6, 1.45, 2.1] + [1, 10, 0])
    assert fit_box([grown], priors_of("vehicle")).kind in ("bus", "truck")
    assert priors_of("Large Vehicle")[0].name == "car"
    assert [prior.name for prior in priors_of("REGULAR_CAR")] == ["car"]
    assert [prior.name for prior in priors_of("motorcycle", names=("rider 3",))] == ["motorcycle"]
    assert priors_of("parked Bicycle")[0].mean[2] < priors_of("bicyclist")[0].mean[2] - 0.3


def test_too_few_points_are_refused() -> None:
    few = Observation(0, np.zeros((2, 3)), UP, 0.0)
    with pytest.raises(BadInputError, match="points"):
        fit_box([few], priors_of("car"))
