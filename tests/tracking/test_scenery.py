"""The scene behind what was painted: drawn on where it was hidden, and how noisy it is."""

from __future__ import annotations

import numpy as np
import pytest
import scenes

from pointbrush.tracking import FrameResult
from pointbrush.tracking.interface import KnownSensor
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.scene.depth import ImageBackground
from pointbrush.tracking.scene.images import (
    DepthNoise,
    continued,
    drawn_on,
    farthest,
    measure_noise,
)
from pointbrush.tracking.scene.pixels import least
from pointbrush.tracking.scene.scene import Scene
from pointbrush.tracking.sensors.camera import Lens, find_lens
from pointbrush.tracking.sensors.view import View

OPTIONS = TrackerOptions()

SHAPE = (96, 128)


def room_corner() -> np.ndarray:
    """(H, W) depth of a floor 1.2 m below the sensor that ends at a wall 4 m away."""
    down = (np.arange(SHAPE[0])[:, None] - 48) / 90.0
    with np.errstate(divide="ignore"):
        floor = np.where(down > 0, 1.2 / down, np.inf)
    return np.broadcast_to(np.minimum(floor, 4.0), SHAPE).astype(np.float32)


def test_scenery_just_uncovered_is_not_the_objects(
    passing: list[scenes.Frame], followed: list[FrameResult]
) -> None:
    """The wall and the floor behind two people were never seen before they walked on."""
    taken = [passing[r.frame].truth[p] for r in followed for p in r.assignments.values()]
    truth = np.concatenate(taken)
    assert (truth == 0).sum() < 0.005 * len(truth)


def test_floors_and_walls_go_on_behind_what_hides_them() -> None:
    scene = room_corner()
    hidden = np.zeros(SHAPE, np.bool_)
    hidden[20:60, 50:70] = True  # before the wall
    hidden[80:88, 20:60] = True  # on the floor
    seen = np.where(hidden, 1.0, scene).astype(np.float32)
    depth = drawn_on(seen.ravel(), SHAPE, hidden.ravel(), options=OPTIONS.background).reshape(SHAPE)
    wrong = np.abs(depth[hidden] / scene[hidden] - 1)
    assert wrong.max() < 0.03
    assert np.isnan(depth[0]).all()
    assert np.isnan(depth[:70, :40]).all()


def test_what_was_not_measured_is_drawn_on_too_and_nothing_is_made_of_nothing() -> None:
    scene = room_corner()
    seen = scene.copy()
    seen[10:25, 90:110] = np.nan
    nothing = np.zeros(scene.size, np.bool_)
    depth = drawn_on(seen.ravel(), SHAPE, nothing, options=OPTIONS.background).reshape(SHAPE)
    np.testing.assert_allclose(depth[10:25, 90:110], 4.0, rtol=0.01)
    assert np.isnan(drawn_on(seen.ravel(), SHAPE, ~nothing, options=OPTIONS.background)).all()


def test_no_scene_is_drawn_on_where_nothing_is_measured_far_and_wide() -> None:
    """Two people before nothing: between them there is no wall as far away as they are."""
    across = np.mgrid[0 : SHAPE[0], 0 : SHAPE[1]][1]
    people = (across < 10) | (across >= 116)
    track = (across >= 60) & (across < 66)
    seen = np.where(people | track, 3.0, np.nan).astype(np.float32)
    depth = drawn_on(seen.ravel(), SHAPE, track.ravel(), options=OPTIONS.background).reshape(SHAPE)
    assert (depth[track] > 6.0).all()


def test_people_who_walk_before_the_sensor_are_no_noise_of_it() -> None:
    rng = np.random.default_rng(1)
    depth = np.linspace(1.5, 6.5, 20_000)
    one, other = (
        (depth + rng.normal(0, 0.002 + 0.001 * depth**2)).astype(np.float32) for _ in range(2)
    )
    other[:2400] += 0.3  # the nearest eighth has moved on
    waver = measure_noise(one, other, options=OPTIONS.noise)
    true = 0.002 + 0.001 * depth**2
    np.testing.assert_allclose(waver(depth.astype(np.float32))[2400:], true[2400:], rtol=0.2)


def test_what_moves_is_no_noise_where_it_was_cut_out_of_its_room() -> None:
    """Something in two hands, and nothing else: all of it comes 3 cm nearer."""
    down, across = (at.ravel() for at in np.indices(SHAPE))
    figure = np.abs(down - 48) + np.abs(across - 64) < 40
    rays = np.stack([(across - 64) / 120.0, (down - 48) / 120.0, np.ones(len(down))], axis=1)

    def frame(number: int) -> scenes.Frame:
        return scenes.Frame((rays[figure] * (0.6 - 0.03 * number)).astype(np.float32))

    scene = Scene(
        frame, [0, 1], lambda world: world[:, 0], ahead=False, known=KnownSensor(), options=OPTIONS
    )
    assert scene.lens is not None
    assert scene.noise(scene.first, np.arange(1000)) < 0.006


def test_the_farthest_that_is_seen_again_lies_behind_what_passes() -> None:
    wall = np.full(8, 3.0, np.float32)
    images = [wall.copy() for _ in range(4)]
    for at, image in enumerate(images):
        image[at] = 1.0
        image[7] = np.nan
    images[1][6] = 3.5
    depth, count = farthest(images, DepthNoise(0.01, 0.0), options=OPTIONS.background)
    np.testing.assert_allclose(depth[:6], 3.0)
    np.testing.assert_array_equal(count[:6], [3, 3, 3, 3, 4, 4])
    assert count[6] == 1
    assert count[7] == 0


def test_furniture_goes_on_beside_whom_it_is_hidden_by_and_people_end() -> None:
    depth = room_corner()
    hidden = np.zeros(SHAPE, np.bool_)
    hidden[20:80, 30:70] = True
    depth[50:70, 60:100] = 3.0  # a sofa, half of it hidden
    depth[25:75, 40:50] = 2.5  # somebody else, who stands where the first one hid him
    found = continued(depth.ravel(), ~hidden.ravel(), SHAPE, options=OPTIONS.background).reshape(
        SHAPE
    )
    assert found[52:68, 60:70].all()
    assert not found[30:70, 40:50].any()
    assert found[25:45, 52:70].all()


def filmed(number: int, depth: np.ndarray, track: np.ndarray) -> View:
    """A view of (48, 64) depths in which label 1 has the pixels ``track``."""
    lens = Lens(np.zeros(3, np.float32), None, 2, 1.0, (-0.32, -0.24), (0.01, 0.01), (48, 64))
    v, u = np.mgrid[0:48, 0:64]
    xyz = np.stack([(0.01 * u - 0.32) * depth, (0.01 * v - 0.24) * depth, depth], axis=-1)
    view = View(number, scenes.Frame(xyz.reshape(-1, 3).astype(np.float32)), lens, options=OPTIONS)
    view.labels[1] = np.flatnonzero(track.ravel())
    return view


def unknown_scene() -> ImageBackground:
    nothing = np.full(48 * 64 + 1, np.nan, np.float32)
    return ImageBackground(OPTIONS, DepthNoise(0.002, 0.0), nothing, nothing.copy())


def test_pixels_that_were_not_painted_at_an_outline_are_not_the_scene() -> None:
    u = np.mgrid[0:48, 0:64][1]

    def walker(number: int, left: int) -> View:
        depth = np.where((u >= left) & (u < left + 12), 2.0, 4.0)
        return filmed(number, depth, (u > left) & (u < left + 11))

    first, second = walker(0, 20), walker(1, 22)
    scene = unknown_scene()
    scene.learn(first, first=True)
    scene.survey(first, [second])
    moved_on = np.flatnonzero(second.cells[0] % 64 > 32)
    before = second.xyz[moved_on, 2] < 3
    np.testing.assert_array_equal(scene.certain(second, moved_on), before)


def test_a_hand_that_passed_before_a_thing_leaves_no_scenery_there() -> None:
    u = np.mgrid[0:48, 0:64][1]
    track, hand = (u >= 20) & (u < 40), (u >= 28) & (u < 40)
    depth = np.where(track, 2.0, 4.0)
    before = np.where(hand, 1.8, depth)
    scene = unknown_scene()
    scene.learn(filmed(0, depth, track), first=True)
    for number in (1, 2):
        scene.learn(filmed(number, before, track & ~hand))
    gone = filmed(3, depth, track)
    scene.learn(gone)
    again = filmed(4, depth, track)
    points = again.labels[1]
    assert not scene.static(again, points)[0].any()
    assert scene.static(again, np.flatnonzero(~track.ravel()))[0].all()


def test_what_has_left_the_picture_teaches_no_pixel() -> None:
    """The picture of a cut-out figure ends where its first frames do."""
    track = np.mgrid[0:48, 0:64][1] > 40
    depth = np.full(track.shape, 2.0)
    scene = unknown_scene()
    scene.learn(filmed(0, depth, track), first=True)
    left = filmed(1, depth, track)
    left.xyz[left.labels[1], 0] += 5.0
    left.frame.xyz[left.labels[1], 0] += 5.0
    scene.learn(left)
    assert (left.cells[0][left.labels[1]] == -1).all()
    assert scene.static(left, np.flatnonzero(~track.ravel()))[0].all()


def test_slanting_surfaces_are_as_deep_as_they_are_and_at_edges_the_nearest_counts() -> None:
    scene = room_corner()
    scene[60:, 100:] -= 0.3  # a box on the floor
    known = np.append(scene.ravel(), np.float32(np.nan))
    found = least(known, SHAPE, DepthNoise(0.001, 0.001))[:-1].reshape(SHAPE)
    np.testing.assert_array_equal(found[85:95, 5:90], scene[85:95, 5:90])
    np.testing.assert_array_equal(found[80:95, 99], scene[79:94, 100].clip(max=scene[81:96, 100]))


def test_what_stands_for_a_while_before_the_scene_is_furniture() -> None:
    camera = scenes.Camera(scenes.Sensor(64, 48, 50.0), scenes.room())
    frame = camera.shoot([], np.random.default_rng(0))
    view = View(0, frame, find_lens(frame, options=OPTIONS), options=OPTIONS)
    every = np.arange(len(view.xyz))
    background = ImageBackground(
        OPTIONS,
        DepthNoise(0.004, 0.002),
        view.depth.copy(),
        view.depth.copy(),
    )
    background.scene = view.depth.copy()
    assert not background.furniture(view, every).any()
    background.scene = view.depth + np.float32(1.0)
    assert background.furniture(view, every).all()
    background.depth += np.float32(0.5)
    assert not background.furniture(view, every).any()


@pytest.mark.parametrize(
    ("way", "stood", "left"), [(0.5, 20, True), (0.01, 20, False), (0.5, 1, False)]
)
def test_what_stands_while_who_has_its_label_goes_on_is_scenery(
    way: float, stood: int, left: bool
) -> None:
    v, u = np.mgrid[0:48, 0:64]
    box = (u >= 20) & (u < 20 + stood) & (v > 20)
    scene = unknown_scene()
    for number in range(4):
        walker = (u >= 30) & (u < 50) & ~box
        depth = np.where(box, 3.0, np.where(walker, 2.0 + 0.2 * number, 4.0))
        view = filmed(number, depth, box | walker)
        scene.learn(view, first=number == 0)
    points = np.flatnonzero(box.ravel())
    assert not scene.scenery(view, points, 100).any()
    scene.left_behind(1, 3, way)
    assert scene.scenery(view, points, 100).all() == left
    assert not scene.scenery(view, np.flatnonzero(walker.ravel()), 100).any()
