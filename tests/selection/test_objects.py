"""One click, one object: what a frame is prepared to, and what clicks on it offer."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.selection.objects import (
    Candidate,
    ObjectFrame,
    ObjectOptions,
    ObjectState,
    candidates,
    prepare,
)
from pointbrush.selection.objects.options import CellOptions
from pointbrush.selection.objects.weights import FILE, load_weights, save_weights
from pointbrush.sensor_kind import SENSOR_KINDS, SensorKind

FLOOR, BALL, CRATE, POST = 0, 1, 2, 3


def room(seed: int, points: int = 60_000) -> tuple[ObjectFrame, NDArray[np.int64]]:
    """A floor with a ball, a crate and a post on it, apart, room coordinates, scanned all round."""
    rng = np.random.default_rng(seed)
    n = points // 6
    floor = np.column_stack([rng.uniform(-2, 2, 3 * n), np.zeros(3 * n), rng.uniform(-2, 2, 3 * n)])
    way = rng.normal(size=(n, 3))
    ball = 0.25 * way / np.linalg.norm(way, axis=1, keepdims=True) + [-0.9, 0.25, 0.3]
    crate = rng.uniform(-1, 1, (n, 3))
    crate[np.arange(n), rng.integers(0, 3, n)] = rng.choice([-1, 1], n)
    crate = crate * [0.3, 0.2, 0.25] + [0.8, 0.2, -0.6]
    turn = rng.uniform(0, 2 * np.pi, n)
    post = np.column_stack([0.06 * np.cos(turn), rng.uniform(0, 1.2, n), 0.06 * np.sin(turn)])
    post += [0.9, 0.0, 1.1]
    parts = [floor, ball, crate, post]
    xyz = np.concatenate(parts) + rng.normal(0, 0.002, (6 * n, 3))
    which = np.repeat([FLOOR, BALL, CRATE, POST], [len(part) for part in parts])
    # Nothing is seen of the floor under what stands on it.
    under = (np.hypot(xyz[:, 0] - 0.9, xyz[:, 2] - 1.1) < 0.06) | (
        (np.abs(xyz[:, [0, 2]] - [0.8, -0.6]) < [0.3, 0.25]).all(axis=1)
    )
    kept = ~((which == FLOOR) & under)
    colour = np.array([[150, 140, 130], [200, 40, 40], [60, 90, 160], [90, 150, 80]])
    rgb = np.clip(colour[which] + rng.normal(0, 6, xyz.shape), 0, 255).astype(np.uint8)
    frame = ObjectFrame(xyz[kept].astype(np.float32), rgb[kept], None, None, "room", np.eye(4))
    return frame, which[kept]


CLICK = {
    BALL: [-0.9, 0.5, 0.3],
    CRATE: [0.8, 0.4, -0.6],
    POST: [0.96, 0.7, 1.1],
    FLOOR: [-1.5, 0.0, -1.5],
}


@pytest.fixture(scope="module")
def furnished() -> tuple[ObjectFrame, NDArray[np.int64], ObjectState]:
    frame, which = room(1)
    return frame, which, prepare(frame)


def overlap(candidate: Candidate, truth: NDArray[np.bool_]) -> float:
    taken = np.zeros(len(truth), np.bool_)
    taken[candidate.indices] = True
    return float((taken & truth).sum() / (taken | truth).sum())


def clicked(*places: int) -> NDArray[np.float64]:
    return np.array([CLICK[place] for place in places])


@pytest.mark.parametrize("thing", [BALL, CRATE, POST])
def test_a_click_offers_the_thing_among_its_levels(
    furnished: tuple[ObjectFrame, NDArray[np.int64], ObjectState], thing: int
) -> None:
    _, which, state = furnished
    found = candidates(state, clicked(thing))
    assert max(overlap(each, which == thing) for each in found) > 0.8


def test_a_click_on_a_floor_of_tiles_shows_the_whole_floor() -> None:
    rng = np.random.default_rng(0)
    frame, which = room(7)
    floor = which == FLOOR
    xyz, rgb = frame.xyz.copy(), np.array(frame.rgb)
    xyz[floor, 1] += rng.normal(0, 0.008, int(floor.sum()))
    tile = np.floor(xyz[floor] / 0.4).astype(int) @ [1, 0, 3] % 7
    rgb[floor] = rng.integers(30, 220, (7, 3))[tile]
    state = prepare(ObjectFrame(xyz, rgb, None, None, "room", np.eye(4)))
    shown = candidates(state, clicked(FLOOR))[0]
    assert overlap(shown, floor) > 0.8
    assert shown.score > 0.7


def test_a_click_on_a_bent_floor_offers_it_without_its_rug() -> None:
    rng = np.random.default_rng(0)
    frame, which = room(7)
    floor = which == FLOOR
    xyz, rgb = frame.xyz.copy(), np.array(frame.rgb)
    rug = floor & (np.abs(xyz[:, [0, 2]] - [-0.7, -0.9]) < [0.6, 0.5]).all(axis=1)
    rgb[rug] = [150, 70, 60]
    xyz[floor, 1] += rng.normal(0, 0.008, int(floor.sum())) + 0.015 * rug[floor]
    xyz[:, 1] += 0.012 * xyz[:, 0] ** 2
    state = prepare(ObjectFrame(xyz, rgb, None, None, "room", np.eye(4)))
    found = candidates(state, np.array([[-1.5, 0.03, 1.5]]))
    assert max(overlap(each, floor & ~rug) for each in found) > 0.9


def test_levels_are_nested_few_and_numbered_by_size(
    furnished: tuple[ObjectFrame, NDArray[np.int64], ObjectState],
) -> None:
    _, _, state = furnished
    for thing in CLICK:
        found = candidates(state, clicked(thing))
        assert 1 <= len(found) <= 6
        assert found[0].score == max(each.score for each in found)
        ranked = sorted(found, key=lambda each: each.level)
        assert [each.level for each in ranked] == list(range(len(found)))
        for small, large in pairwise(ranked):
            assert len(small.indices) < len(large.indices)
            assert np.isin(small.indices, large.indices).all()


def test_before_a_depth_camera_the_level_shown_is_scored_as_sure_as_it_is() -> None:
    frame, which = room(1)
    state = prepare(replace(frame, sensor="camera", viewpoint=np.array([0.0, 3.0, 3.0])))
    shown, *others = candidates(state, clicked(BALL))
    assert overlap(shown, which == BALL) > 0.8
    assert abs(shown.score - overlap(shown, which == BALL)) < 0.12
    assert all(each.score < shown.score for each in others)


def test_indices_are_point_numbers_ascending(
    furnished: tuple[ObjectFrame, NDArray[np.int64], ObjectState],
) -> None:
    frame, _, state = furnished
    for each in candidates(state, clicked(BALL)):
        assert each.indices.dtype == np.int64
        assert (np.diff(each.indices) > 0).all()
        assert 0 <= each.indices[0] <= each.indices[-1] < len(frame.xyz)


def holds(state: ObjectState, frame: ObjectFrame, candidate: Candidate, place: int) -> bool:
    """Whether the point nearest to a click is taken."""
    away = np.linalg.norm(frame.xyz - np.array(CLICK[place]), axis=1)
    return bool(np.isin(int(away.argmin()), candidate.indices))


def test_every_candidate_holds_the_positives_and_no_negative(
    furnished: tuple[ObjectFrame, NDArray[np.int64], ObjectState],
) -> None:
    frame, _, state = furnished
    for yes, no in [([BALL, CRATE], [POST, FLOOR]), ([POST], [FLOOR]), ([FLOOR], [BALL, CRATE])]:
        found = candidates(state, clicked(*yes), clicked(*no))
        assert found
        for each in found:
            assert all(holds(state, frame, each, place) for place in yes)
            assert not any(holds(state, frame, each, place) for place in no)


def test_a_click_on_what_is_left_out_adds_it_to_what_is_taken(
    furnished: tuple[ObjectFrame, NDArray[np.int64], ObjectState],
) -> None:
    _, which, state = furnished
    best = max(candidates(state, clicked(BALL)), key=lambda each: overlap(each, which == BALL))
    both = (which == BALL) | (which == CRATE)
    found = candidates(state, clicked(BALL, CRATE), mask=best.indices)
    assert max(overlap(each, both) for each in found) > 0.75


def test_a_negative_click_takes_a_thing_from_what_is_taken(
    furnished: tuple[ObjectFrame, NDArray[np.int64], ObjectState],
) -> None:
    _, which, state = furnished
    mask = (which == BALL) | (which == CRATE)
    found = candidates(state, clicked(BALL), clicked(CRATE), mask=mask)
    assert max(overlap(each, which == BALL) for each in found) > 0.8


def test_a_click_sees_a_wrong_level_through(
    furnished: tuple[ObjectFrame, NDArray[np.int64], ObjectState],
) -> None:
    _, which, state = furnished
    mask = (which == BALL) | (which == FLOOR)
    found = candidates(state, clicked(BALL), clicked(FLOOR), mask=mask)
    assert overlap(found[0], which == BALL) > 0.8


def test_a_negative_click_takes_away_only_what_it_touches(
    furnished: tuple[ObjectFrame, NDArray[np.int64], ObjectState],
) -> None:
    frame, which, state = furnished
    crate = which == CRATE
    corner = frame.xyz[crate][np.argmax(frame.xyz[crate] @ [1.0, 1.0, 1.0])]
    found = candidates(state, clicked(CRATE), corner[None].astype(np.float64), mask=crate)
    assert max(overlap(each, crate) for each in found) > 0.8


def test_a_click_on_a_lone_return_goes_to_the_nearest_surface() -> None:
    frame, which = room(2)
    lone = np.array([[-0.9, 0.5 + 0.06, 0.3]], np.float32)
    assert frame.rgb is not None
    xyz, rgb = np.concatenate([frame.xyz, lone]), np.concatenate([frame.rgb, frame.rgb[:1]])
    state = prepare(ObjectFrame(xyz, rgb, None, None, "room", np.eye(4)))
    found = candidates(state, lone.astype(np.float64))
    assert max(overlap(each, np.append(which == BALL, False)) for each in found) > 0.8


def test_a_click_on_a_lone_return_of_a_lidar_goes_to_what_is_behind_it() -> None:
    rng = np.random.default_rng(0)
    road = np.column_stack([rng.uniform(-20, 20, (20_000, 2)), np.zeros(20_000)])
    van = np.column_stack(
        [np.full(3000, 12.0), rng.uniform(-2, 2, 3000), rng.uniform(0.3, 2, 3000)]
    )
    lone = np.array([[10.5, 0.0, 1.5]])
    xyz = np.concatenate([road, van, lone]) - [0, 0, 1.8]
    truth = np.repeat([False, True, False], [len(road), len(van), 1])
    z_up = np.eye(4)
    z_up[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
    frame = ObjectFrame(xyz.astype(np.float32), None, None, np.zeros(3), "lidar", z_up)
    state = prepare(frame)
    assert max(overlap(each, truth) for each in candidates(state, xyz[-1:])) > 0.9
    # A correction stays where it is.
    seen, both = xyz[truth][:1], truth | (np.arange(len(xyz)) == len(xyz) - 1)
    assert overlap(candidates(state, seen, xyz[-1:], mask=both)[0], truth) > 0.99
    assert overlap(candidates(state, np.concatenate([seen, xyz[-1:]]), mask=truth)[0], both) > 0.99


def test_two_opposite_clicks_on_one_flat_piece_share_it_between_them() -> None:
    rng = np.random.default_rng(0)
    xyz = np.column_stack([rng.uniform(-1, 1, (8000, 2)), np.zeros(8000)]).astype(np.float32)
    state = prepare(ObjectFrame(xyz))
    left, right = np.array([[-0.5, 0, 0]]), np.array([[0.5, 0, 0]])
    for each in candidates(state, left, right):
        assert holds_point(xyz, each, left[0])
        assert not holds_point(xyz, each, right[0])


def holds_point(xyz: NDArray[np.float32], candidate: Candidate, at: NDArray[np.float64]) -> bool:
    nearest = int(np.linalg.norm(xyz - at, axis=1).argmin())
    return bool(np.isin(nearest, candidate.indices))


@pytest.mark.parametrize("sensor", SENSOR_KINDS)
@pytest.mark.parametrize("count", [0, 1, 2, 3, 10, 200])
def test_frames_of_few_points_work(sensor: SensorKind, count: int) -> None:
    rng = np.random.default_rng(count)
    xyz = rng.uniform(-1, 1, (count, 3)).astype(np.float32)
    rgb = rng.integers(0, 255, (count, 3)).astype(np.uint8)
    state = prepare(ObjectFrame(xyz, rgb, sensor=sensor, viewpoint=np.zeros(3)))
    found = candidates(state, np.zeros((1, 3)))
    assert bool(found) == bool(count)
    for each in found:
        assert len(each.indices)
        assert each.indices[-1] < count


@pytest.mark.parametrize("sensor", SENSOR_KINDS)
def test_points_that_all_lie_in_one_place_work(sensor: SensorKind) -> None:
    state = prepare(ObjectFrame(np.ones((500, 3), np.float32), sensor=sensor))
    assert [len(each.indices) for each in candidates(state, np.ones((1, 3)))] == [500]


def test_points_without_coordinates_are_never_taken() -> None:
    frame, _ = room(2, 12_000)
    xyz = frame.xyz.copy()
    xyz[::7] = np.nan
    state = prepare(ObjectFrame(xyz, frame.rgb))
    for each in candidates(state, clicked(BALL)):
        assert not (each.indices % 7 == 0).any()


def test_cells_stay_few_in_a_dense_frame() -> None:
    frame, _ = room(3, 30_000)
    options = ObjectOptions(cells=CellOptions(fewest=1000, lidar_fewest=1000, most=2000))
    assert len(prepare(frame, options).center) <= 2000


def test_the_same_frame_gives_the_same_state_and_answers() -> None:
    frame, _ = room(4, 12_000)
    one, other = prepare(frame), prepare(frame)
    assert (one.parent == other.parent).all()
    assert (one.piece == other.piece).all()
    assert (one.score == other.score).all()
    for a, b in zip(
        candidates(one, clicked(CRATE)), candidates(other, clicked(CRATE)), strict=True
    ):
        assert (a.indices == b.indices).all()
        assert (a.score, a.level) == (b.score, b.level)


def test_turning_a_frame_and_its_room_turns_nothing_else() -> None:
    """Local axes do not count: the room's do."""
    frame, which = room(5, 24_000)
    R = np.array([[0.0, -1, 0], [0, 0, 1], [-1, 0, 0]])
    T = np.eye(4)
    T[:3, :3] = R.T
    turned = ObjectFrame((frame.xyz @ R.T).astype(np.float32), frame.rgb, T_room_local=T)
    for thing in (BALL, CRATE):
        plain = candidates(prepare(frame), clicked(thing))
        found = candidates(prepare(turned), clicked(thing) @ R.T)
        assert max(overlap(each, which == thing) for each in found) == pytest.approx(
            max(overlap(each, which == thing) for each in plain), abs=0.05
        )


def test_a_state_comes_back_from_its_file_and_cannot_be_written_to(tmp_path: Path) -> None:
    frame, _ = room(6, 12_000)
    state = prepare(frame)
    state.save(tmp_path / "frame.npz")
    again = ObjectState.load(tmp_path / "frame.npz")
    for a, b in zip(
        candidates(state, clicked(POST)), candidates(again, clicked(POST)), strict=True
    ):
        assert (a.indices == b.indices).all()
        assert a.score == b.score
    for each in (state, again):
        with pytest.raises(ValueError, match="read-only"):
            each.center[0] = 0


@pytest.mark.parametrize("content", [b"", b"nonsense", b"PK\x03\x04" + bytes(40)])
def test_a_damaged_file_of_a_state_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "frame.npz"
    path.write_bytes(content)
    with pytest.raises(BadInputError, match=r"frame\.npz: expected a saved object state"):
        ObjectState.load(path)


def test_bad_input_is_refused(
    furnished: tuple[ObjectFrame, NDArray[np.int64], ObjectState],
) -> None:
    frame, _, state = furnished
    with pytest.raises(BadInputError, match="positives: expected finite"):
        candidates(state, np.full((1, 3), np.nan))
    with pytest.raises(BadInputError, match=r"negatives: expected \(K, 3\)"):
        candidates(state, clicked(BALL), np.zeros((1, 2)))
    with pytest.raises(BadInputError, match="mask: expected point numbers"):
        candidates(state, clicked(BALL), mask=np.array([len(frame.xyz)]))
    with pytest.raises(BadInputError, match="rgb: expected"):
        prepare(ObjectFrame(frame.xyz, frame.rgb[:-1] if frame.rgb is not None else None))
    with pytest.raises(BadInputError, match="sensor: expected one of camera, lidar, room"):
        prepare(ObjectFrame(frame.xyz, sensor="sonar"))  # type: ignore[arg-type]


def test_without_a_positive_click_nothing_is_offered(
    furnished: tuple[ObjectFrame, NDArray[np.int64], ObjectState],
) -> None:
    assert candidates(furnished[2], np.empty((0, 3)), clicked(FLOOR)) == []


def test_weights_are_small_and_come_back_from_their_file(tmp_path: Path) -> None:
    assert FILE.stat().st_size <= 300_000
    shipped = load_weights(FILE)
    assert set(shipped) == set(SENSOR_KINDS)
    save_weights(tmp_path / "weights.npz", shipped)
    for sensor, pair in load_weights(tmp_path / "weights.npz").items():
        for one, other in zip(pair, shipped[sensor], strict=True):
            for a, b in zip(one, other, strict=True):
                assert (a == b).all()
