"""`icp` and `color-icp` say how sure they are by what was painted."""

from __future__ import annotations

import numpy as np
import pytest
import scenes

from pointbrush.tracking import METHODS, Seed, TrackOptions, TrackState

STEP = 0.01
RNG = np.random.default_rng(2)
SIDE = np.stack(np.meshgrid(*[np.arange(0, 0.1, STEP)] * 2), axis=-1).reshape(-1, 2)
BOX = np.vstack([np.insert(SIDE, axis, 0.0, axis=1) for axis in range(3)])
WALL = np.stack(np.meshgrid(np.arange(-1, 1, STEP), np.arange(-1, 1, STEP)), axis=-1).reshape(-1, 2)


def frame(at: tuple[float, float, float]) -> scenes.Frame:
    """Three sides of a box, 1, before a wall."""
    box = BOX + np.array(at)
    wall = np.insert(WALL, 2, 1.3, axis=1)
    xyz = np.vstack([box, wall]) + RNG.normal(0, 0.001, (len(box) + len(wall), 3))
    truth = np.repeat([1, 0], [len(box), len(wall)]).astype(np.uint16)
    rgb = np.full((len(xyz), 3), 120, np.uint8)
    return scenes.Frame(xyz.astype(np.float32), rgb, truth)


def last_state(method: str, places: list[tuple[float, float, float]]) -> TrackState:
    frames = [frame(at) for at in places]
    seeds = [Seed(1, np.flatnonzero(frames[0].truth == 1))]
    run = METHODS[method]().track(
        frames.__getitem__, range(len(frames)), seeds, lambda _: None, TrackOptions()
    )
    return list(run)[-1].tracks[1]


@pytest.mark.parametrize("method", ["icp", "color-icp"])
def test_a_box_that_moves_a_little_is_surely_found(method: str) -> None:
    assert last_state(method, [(0.003 * i, 0.0, 1.0) for i in range(4)]).confidence > 0.5


@pytest.mark.parametrize("method", ["icp", "color-icp"])
def test_who_took_the_wall_for_a_box_doubts_it_from_then_on(method: str) -> None:
    state = last_state(method, [(0.0, 0.0, 1.2), (0.9, 0.9, 1.0), (0.9, 0.9, 1.0)])
    assert state.inliers > 0.5  # the step by itself fits
    assert state.confidence < 0.5


@pytest.mark.parametrize("method", ["icp", "color-icp"])
def test_a_label_that_grows_over_the_table_is_doubted_once_most_of_it_is_table(method: str) -> None:
    """The painted surface stays where it was all the while."""
    table = np.insert(WALL, 1, 0.0, axis=1)
    table = table[~((table >= 0.0) & (table < 0.1)).all(axis=1)]
    frames = []
    for _ in range(14):
        xyz = np.vstack([BOX, table]) + RNG.normal(0, 0.001, (len(BOX) + len(table), 3))
        truth = np.repeat([1, 0], [len(BOX), len(table)]).astype(np.uint16)
        frames.append(scenes.Frame(xyz.astype(np.float32), None, truth))
    seeds = [Seed(1, np.flatnonzero(frames[0].truth == 1))]
    run = METHODS[method]().track(
        frames.__getitem__, range(len(frames)), seeds, lambda _: None, TrackOptions()
    )
    mostly_table = []
    for result in list(run)[1:]:
        own = frames[result.frame].truth[result.assignments[1]] == 1
        if own.sum() / (len(BOX) + (~own).sum()) < 0.5:
            mostly_table.append(result.tracks[1].confidence)
    assert len(mostly_table) > 2
    assert max(mostly_table) < 0.5
