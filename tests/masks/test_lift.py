"""Masks of pictures to labels of points and back, without recordings."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.masks import IN_DOUBT, VOID, View, draw, lift
from pointbrush.values.frames import Camera

WIDTH, HEIGHT, FOCAL = 160, 120, 130.0
BESIDE = 0.1
"""Metres from the sensor to the colour camera, to the right."""
WALL, OBJECT = 3.0, 1.5
"""Metres from the sensor to two surfaces."""


def camera_at(*place: float) -> Camera:
    """Return a camera at a place in the sensor's coordinates that looks along its axis."""
    T = np.eye(4)
    T[:3, 3] = -np.array(place)
    K = ((FOCAL, 0, WIDTH / 2), (0, FOCAL, HEIGHT / 2), (0, 0, 1))
    return Camera("colour", WIDTH, HEIGHT, K, (), "plumb_bob", T)


COLOUR = camera_at(BESIDE, 0, 0)


def unprojected(depth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points of a depth image (H, W), row-major."""
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    x, y = (u - WIDTH / 2) / FOCAL, (v - HEIGHT / 2) / FOCAL
    return np.stack([x * depth, y * depth, depth], axis=-1).reshape(-1, 3)


def rectangle(u: int, v: int) -> NDArray[np.bool_]:
    """True in a rectangle of 40 by 50 pixels."""
    inside = np.zeros((HEIGHT, WIDTH), np.bool_)
    inside[v : v + 40, u : u + 50] = True
    return inside


def object_before_wall(u: int = 50, v: int = 30) -> tuple[NDArray[Any], NDArray[Any]]:
    """Points of a board before a wall as the sensor sees them, and whether they are the board."""
    board = rectangle(u, v)
    return unprojected(np.where(board, OBJECT, WALL)), board.ravel()


def seen_by(camera: Camera, u: int = 50, v: int = 30) -> NDArray[np.uint16]:
    """The true mask of the board, which is 1, in a camera beside the sensor."""
    shift = round(camera.T_camera_frame[0, 3] * FOCAL / OBJECT)
    return np.roll(rectangle(u, v), shift, axis=1).astype(np.uint16)


@given(st.integers(0, 2**32 - 1), st.integers(1, 400))
def test_mask_of_lattice_comes_back_as_it_was(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    pixel = rng.choice(WIDTH * HEIGHT, count, replace=False)
    labels = rng.choice([0, 1, 300, 65534], count).astype(np.uint16)
    view = View.of_lattice("depth", (WIDTH, HEIGHT), pixel, rng.uniform(1, 5, count))
    mask = draw(view, labels)
    assert (mask != VOID).sum() == count
    assert np.array_equal(lift([(view, mask)], np.zeros((count, 3))), labels)


@given(st.integers(20, 80), st.integers(10, 60), st.sampled_from([1, 2, 3]))
def test_drawn_mask_labels_no_point_wrongly(u: int, v: int, step: int) -> None:
    xyz, board = object_before_wall(u, v)
    kept = np.arange(len(xyz)).reshape(HEIGHT, WIDTH)[::step, ::step].ravel()
    xyz, labels = xyz[kept], board[kept].astype(np.uint16) * 7
    view = View.of_camera(COLOUR, xyz)
    back = lift([(view, draw(view, labels))], xyz)
    assert set(np.unique(back)) <= {IN_DOUBT, 0, 7}
    assert (labels[back > 0] == 7).all()
    assert (back[labels == 7] == 7).mean() > 0.9


def test_gaps_of_one_surface_are_filled_and_others_stay_holes() -> None:
    xyz, board = object_before_wall()
    sparse = np.arange(len(xyz)).reshape(HEIGHT, WIDTH)[::4, ::4].ravel()
    view = View.of_camera(camera_at(0, 0, 0), xyz[sparse])
    mask = draw(view, board[sparse].astype(np.uint16))
    true = board.reshape(HEIGHT, WIDTH)
    assert (mask[mask != VOID] == true[mask != VOID]).all()
    assert (mask[true] == 1).mean() > 0.8
    assert (mask == VOID).any()


def test_surface_behind_another_one_stays_unlabelled() -> None:
    rear = unprojected(np.full((HEIGHT, WIDTH), WALL))
    front, board = object_before_wall()
    # The sensor is high: it sees the wall that the board hides from the camera.
    xyz = np.concatenate([rear, front[board]])
    mask = np.ones((HEIGHT, WIDTH), np.uint16)
    found = lift([(View.of_camera(camera_at(0, 0, 0), xyz), mask)], xyz)
    hidden = rectangle(50, 30).ravel()
    assert (found[: len(rear)][hidden] == 0).all()
    assert (found[len(rear) :] == 1).all()
    assert (found[: len(rear)][~hidden] == 1).mean() > 0.9


@pytest.mark.parametrize("off", [(0, 0, 0), (0.02, 0.01, 0), (-0.015, 0.015, 0.02)])
def test_error_of_calibration_is_found_by_jumps_of_depth(off: tuple[float, ...]) -> None:
    xyz, board = object_before_wall()
    T = COLOUR.T_camera_frame.copy()
    T[:3, 3] += off
    view = View.of_camera(replace(COLOUR, T_camera_frame=T), xyz)
    found = lift([(view, seen_by(COLOUR))], xyz)
    assert ((found == 1) & board).sum() / ((found == 1) | board).sum() > 0.97


def test_cameras_vote() -> None:
    xyz, board = object_before_wall()
    views = [View.of_camera(camera_at(x, 0, 0), xyz) for x in (-BESIDE, 0.0, BESIDE)]
    masks = [seen_by(camera_at(x, 0, 0)) for x in (-BESIDE, 0.0, BESIDE)]
    wrong = masks[0] * 0 + 2
    both = lift([(views[0], wrong), (views[1], masks[1])], xyz)
    assert (both[board] == IN_DOUBT).mean() > 0.9
    most = lift([(views[0], wrong), *zip(views[1:], masks[1:], strict=True)], xyz)
    assert (most[board] == 1).mean() > 0.9
    nothing = lift([(views[0], masks[0] * 0 + VOID), (views[1], masks[1])], xyz)
    assert (nothing[board] == 1).mean() > 0.9


def test_lens_bends_places_as_opencv_does() -> None:
    xyz = np.array([[0.3, -0.2, 1.0], [-0.4, 0.1, 1.0]])
    lens = replace(camera_at(0, 0, 0), K=((1000, 0, 500), (0, 1000, 500), (0, 0, 1)), width=1000)
    lens = replace(lens, height=1000)
    # Worked out by hand from the formulas of OpenCV's documentation.
    for model, distortion, expected in (
        ("plumb_bob", (0.1, -0.2, 0.001, 0.002, 0.05), [(803, 298), (96, 601)]),
        ("equidistant", (0.1, -0.2, 0.01, 0.02), [(791, 306), (117, 596)]),
    ):
        view = View.of_camera(replace(lens, model=model, distortion=distortion), xyz)
        row, column = np.divmod(view.pixel, 1000)
        assert np.array_equal(np.stack([column, row], axis=1), expected), model


def test_points_beside_and_behind_a_camera_are_not_in_its_picture() -> None:
    wide = replace(camera_at(0, 0, 0), distortion=(-0.4, 0.0, 0, 0, 0))
    xyz = np.array([[0, 0, -2.0], [0, 0, 0.01], [3.0, 0, 1], [9.0, 0, 1], [0.1, 0.1, 1]])
    assert (View.of_camera(wide, xyz).pixel >= 0).tolist() == [False, False, False, False, True]


def test_camera_without_calibration_and_mask_of_another_size_are_refused() -> None:
    xyz, _ = object_before_wall()
    for camera, words in (
        (replace(COLOUR, K=None), "its K is not known"),
        (replace(COLOUR, model="omni", distortion=(1.0,)), "got 'omni'"),
    ):
        with pytest.raises(BadInputError, match=words):
            View.of_camera(camera, xyz)
    with pytest.raises(BadInputError, match=r"160x120 pixels .* got 120x160"):
        lift([(View.of_camera(COLOUR, xyz), np.ones((160, 120), np.uint16))], xyz)
