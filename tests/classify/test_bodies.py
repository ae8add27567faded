"""Bodies as a sensor sees them, and the vote of the cells that lie in one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pointbrush.classify.bodies import seen_bodies
from pointbrush.classify.smoothing import voted

GAP = 0.015
STEP = 0.007
"""Radians between rays, less than half the gap."""
EYE = np.array([5.0, -2.0, 1.7])


def seen(away: float, azimuth: float, width: float, height: float) -> NDArray[np.float64]:
    """Where rays from the eye meet an upright board that faces it; metres and radians."""
    turns = np.arange(-width / 2, width / 2, STEP * away) / away + azimuth
    ups = np.arange(-height / 2, height / 2, STEP * away)
    turn, up = (each.ravel() for each in np.meshgrid(turns, ups))
    board: NDArray[np.float64] = np.column_stack([away * np.cos(turn), away * np.sin(turn), up])
    return np.asarray(board + EYE)


@settings(deadline=None, max_examples=30)
@given(away=st.floats(3, 80), azimuth=st.floats(-np.pi, np.pi))
def test_what_rays_meet_side_by_side_is_one_body_near_and_far(away: float, azimuth: float) -> None:
    boards = [seen(away, azimuth, 0.3 * away, 0.1 * away), seen(2 * away, azimuth, 0.3, 0.5)]
    center = np.concatenate(boards)
    body = seen_bodies(center, np.ones(len(center), bool), EYE, GAP)
    near, far = body[: len(boards[0])], body[len(boards[0]) :]
    assert len(np.unique(near)) == 1  # also across the least and greatest azimuth
    assert not np.isin(far, near).any()  # twice as far behind it


def test_ground_is_in_no_body() -> None:
    center = seen(10.0, 0.0, 1.0, 1.0)
    standing = np.arange(len(center)) % 2 == 0
    body = seen_bodies(center, standing, EYE, GAP)
    assert (body[standing] >= 0).all()
    assert (body[~standing] == -1).all()
    nothing = seen_bodies(center, np.zeros(len(center), bool), EYE, GAP)
    assert (nothing == -1).all()


def test_cells_of_a_body_vote_and_others_keep_their_chance() -> None:
    chance = np.array([[0.9, 0.1], [0.8, 0.2], [0.3, 0.7], [0.2, 0.8]], np.float32)
    body = np.array([0, 0, 0, -1], np.int32)
    out = voted(chance, [body])
    assert out.sum(axis=1) == pytest.approx(np.ones(4))
    assert out[2, 0] > 0.5  # outvoted
    assert out[3].tolist() == chance[3].tolist()
    assert voted(chance, []).tolist() == chance.tolist()
    nobody = np.full(4, -1, np.int32)
    assert voted(chance, [nobody]).tolist() == chance.tolist()
