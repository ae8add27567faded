"""The ground around a lidar on the move: found on kerbs too, and no part of what stands on it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pointbrush.tracking.model.track import OtherMovers, begin
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.scanner import on_ground
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.ground_contact import painted_with_ground, with_ground
from pointbrush.tracking.steps.grow import own_points
from pointbrush.tracking.steps.predict import search_among
from pointbrush.tracking.steps.register import find

OPTIONS = TrackerOptions()

NO_RIVALS = OtherMovers.none()
KERB = 0.13


def street() -> tuple[np.ndarray, np.ndarray]:
    """(N, 3) of a road, a kerb from y = 4 on, a wall and a post on the kerb; (N,) 1 the post."""
    rng = np.random.default_rng(3)
    ground = rng.uniform((-12, -8, 0), (12, 8, 0), (40_000, 3))
    ground[:, 2] = np.where(ground[:, 1] > 4, KERB, 0) - 1.7
    wall = rng.uniform((-12, 8, -1.5), (12, 8.02, 3), (8_000, 3))
    turn = rng.uniform(0, 2 * np.pi, 600)
    post = np.stack([0.2 * np.cos(turn) + 2, 0.2 * np.sin(turn) + 5.5, turn], axis=1)
    post[:, 2] = rng.uniform(KERB + 0.1, 1.6, 600) - 1.7
    xyz = np.concatenate([ground, wall, post]) + rng.normal(0, 0.01, (48_600, 3))
    return xyz.astype(np.float32), np.repeat([0, 0, 1], [40_000, 8_000, 600])


def test_a_kerb_is_ground_and_what_stands_on_it_is_none() -> None:
    xyz, truth = street()
    low = on_ground(xyz, options=OPTIONS)
    kerb = (xyz[:, 1] > 5) & (xyz[:, 1] < 7.5) & (truth == 0)
    road = xyz[:, 1] < 3
    assert low[kerb].mean() > 0.95
    assert low[road].mean() > 0.95
    assert not low[xyz[:, 2] > KERB + 0.5 - 1.7].any()


@pytest.mark.parametrize("with_it", [False, True])
def test_ground_under_a_thing_is_taken_only_by_what_was_painted_with_it(with_it: bool) -> None:
    xyz, truth = street()
    beside = (np.hypot(xyz[:, 0] - 2, xyz[:, 1] - 5.5) < 0.35) & (truth == 0)
    frame = SimpleNamespace(
        xyz=xyz, rgb=None, intensity=None, viewpoint=None, pose=None, sensor=None
    )
    view = View(1, frame, None, OPTIONS, np.eye(4), np.zeros(3))
    mine = np.flatnonzero((truth == 1) | (beside if with_it else False))
    track = begin(view, 1, mine, 0.05, NO_RIVALS)
    grounded = painted_with_ground(view, mine)
    assert grounded == with_it
    track.unit, track.painted = 0.15, replace(track.painted, grounded=grounded)
    # Ground that was seen before is in no search; what drives on is on other ground.
    place = find(search_among(track, view, np.flatnonzero((truth == 1) | (beside & (not with_it)))))
    view.labels = {1: own_points(track, view, place).claim.indices}
    found = with_ground(view, {1: track}, {1: place}, np.ones(len(xyz), np.bool_))[1]
    assert (truth[found] == 1).sum() == 600
    assert (np.hypot(xyz[found, 0] - 2, xyz[found, 1] - 5.5) < 0.4).all()
    taken = beside[found].sum() / beside.sum()
    assert taken > 0.9 if with_it else taken < 0.5
