"""Two depth cameras: what each can see, and people hidden from one of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
import scenes
from runs import follow
from scenes.figures import person
from views import OPTIONS, box

from pointbrush.tracking.model.track import OtherMovers, begin
from pointbrush.tracking.sensors.sights import find_lenses
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.predict import target_of

FRONT = scenes.Sensor(192, 168, 130.0, origin=np.array([0.0, 1.0, 0.0]))
SIDE = scenes.Sensor(
    192, 168, 130.0, origin=np.array([2.4, 1.1, 2.2]),
    look=np.array([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]]),
)  # fmt: skip
"""Cameras before the room and at its side, which looks across it."""


@dataclass
class Lattice:
    """A ``PixelLattice`` of the cameras: right, up, ahead."""

    width: int = FRONT.width
    height: int = FRONT.height
    axis: int = 2
    sign: float = 1.0
    tangent: tuple[float, float] = (
        (0.5 - FRONT.width / 2) / FRONT.focal,
        (FRONT.height / 2 - 0.5) / FRONT.focal,
    )
    pitch: tuple[float, float] = (1 / FRONT.focal, -1 / FRONT.focal)
    eye: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass
class Part:
    """A ``SensorPart``."""

    sensor: int
    T_frame_sensor: np.ndarray
    lattice: Lattice | None


def mount(sensor: scenes.Sensor) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = sensor.look, sensor.origin
    return T


def joined(seen: list[scenes.Frame], sensors: list[scenes.Sensor], lattice: bool) -> scenes.Frame:
    """One frame of several cameras, in an order that mixes them."""
    number = np.repeat(np.arange(len(seen)), [len(frame.xyz) for frame in seen]).astype(np.uint8)
    order = np.random.default_rng(0).permutation(len(number))
    xyz, rgb, truth = (
        np.concatenate([getattr(frame, name) for frame in seen])[order]
        for name in ("xyz", "rgb", "truth")
    )
    parts = [Part(k, mount(s), Lattice() if lattice else None) for k, s in enumerate(sensors)]
    return scenes.Frame(xyz, rgb, truth, sensor=number[order], parts=parts)


def shots(
    sensors: list[scenes.Sensor], moments: list[list[scenes.Part]], *, lattice: bool = True
) -> list[scenes.Frame]:
    """What the cameras record of the ``moments`` in a room."""
    rng = np.random.default_rng(4)
    cameras = [scenes.Camera(sensor, scenes.room()) for sensor in sensors]
    return [
        joined([camera.shoot(parts, rng) for camera in cameras], sensors, lattice)
        for parts in moments
    ]


def view_of(*sensors: scenes.Sensor, lattice: bool = True) -> View:
    frame = shots(list(sensors), [[box()]], lattice=lattice)[0]
    return View(1, frame, find_lenses([frame], options=OPTIONS), options=OPTIONS)


BEHIND, INSIDE, BEFORE = (
    np.array([[0.0, 1.2, 2.3]]),
    np.array([[0.0, 1.2, 1.6]]),
    np.array([[0.0, 1.15, 1.0]]),
)
"""Places behind the box as the front camera sees it, inside of it, and before it."""


def test_a_place_is_seen_through_by_the_camera_that_looks_there() -> None:
    for lattice in (True, False):  # pixels of the import, and pixels found in the points
        both = view_of(FRONT, SIDE, lattice=lattice)
        assert not both.hides(BEHIND, 0.05)[0]
        assert both.sees_through(BEHIND, 0.05)[0]
        assert both.hides(INSIDE, 0.02)[0]
        assert not both.sees_through(INSIDE, 0.02)[0]
        assert both.sees_through(BEFORE, 0.05)[0]
    alone = view_of(FRONT)
    assert alone.hides(BEHIND, 0.05)[0]
    assert not alone.sees_through(BEHIND, 0.05)[0]


def test_the_unit_is_the_spacing_of_one_camera_where_several_overlap() -> None:
    units = []
    for sensors in ((FRONT,), (FRONT, replace(FRONT, origin=np.array([0.02, 1.0, 0.0])))):
        view = view_of(*sensors)
        points = np.flatnonzero(view.frame.truth)
        units.append(begin(view, 1, points, 0.0, OtherMovers.none()).unit)
    assert units[1] == pytest.approx(units[0], rel=0.1)


def test_pixels_beside_a_picture_belong_to_no_other_camera() -> None:
    view = view_of(FRONT, SIDE)
    for number, cells in enumerate(view.pictures):
        own = view.cells.cell[view.frame.sensor == number]
        assert ((own >= cells.start) & (own < cells.stop)).all()
        image = view.depth[cells].reshape(-1, view.image_shape[1])
        assert np.isnan(image[[0, -1]]).all()


def test_another_camera_makes_the_fitted_points_no_sparser() -> None:
    def fitted(view: View) -> int:
        xyz = target_of(view, np.arange(len(view.xyz)), weight=0.0).xyz.astype(np.float32)
        front = view.xyz[view.frame.sensor == 0]
        return len(set(map(bytes, xyz)) & set(map(bytes, front)))

    assert fitted(view_of(FRONT, SIDE)) > 0.9 * fitted(view_of(FRONT))


def passing(count: int) -> list[list[scenes.Part]]:
    """Person 1 walks before person 2, who is hidden from the front camera for a while."""
    moments = []
    for i in range(count):
        t = i / (count - 1)
        near, far = np.array([1.2 * t - 0.6, 0, 1.6]), np.array([0.19 - 0.38 * t, 0, 2.8])
        moments.append(
            person(1, near, np.pi / 2, 6.0 * t, (60, 110, 200))
            + person(2, far, -np.pi / 2, 6.0 * t + 1, (190, 80, 60))
        )
    return moments


def test_a_person_hidden_from_one_camera_is_kept() -> None:
    frames = shots([FRONT, SIDE], passing(14))
    hidden, ious = 0, []
    for result in follow(frames)[1:]:
        frame = frames[result.frame]
        own = frame.truth == 2
        hidden += int((own & (frame.sensor == 0)).sum() < 0.2 * (own & (frame.sensor == 1)).sum())
        found = np.zeros(len(own), np.bool_)
        found[result.assignments.get(2, np.empty(0, np.int64))] = True
        ious.append((own & found).sum() / (own | found).sum())
    assert hidden >= 2  # the front camera hardly sees the person there
    assert np.mean(ious) > 0.9
    assert min(ious) > 0.75


def test_frames_without_a_camera_are_tracked_by_the_other() -> None:
    frames = shots([FRONT, SIDE], passing(6))
    last = frames[-1]
    kept = last.sensor == 1
    frames[-1] = replace(
        last, xyz=last.xyz[kept], rgb=last.rgb[kept], truth=last.truth[kept],
        sensor=last.sensor[kept], parts=last.parts[1:],
    )  # fmt: skip
    found = follow(frames)[-1].assignments
    for label in (1, 2):
        own = np.flatnonzero(frames[-1].truth == label)
        assert len(np.intersect1d(found[label], own)) > 0.8 * len(own)
