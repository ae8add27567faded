"""Searches in columns find what comparing all with all finds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from pointbrush.tracking.columns import NONE, columns, nearest, nearest_three, pairs
from pointbrush.tracking.grid import perhaps_near

# No two points are apart by one of the reaches below, so that rounding decides nothing.
COORDINATE = st.floats(-3, 3, width=32).map(lambda x: round(x, 2))


def clouds(least: int = 0) -> st.SearchStrategy[NDArray[np.float64]]:
    """Few points, some in the same place, in a plane or on a line."""
    shape = st.tuples(st.integers(least, 40), st.just(3))
    flat = st.sampled_from([(1, 1, 1), (1, 1, 0), (0, 1, 0), (0, 0, 0), (1, 0, 1e6)])
    cloud = arrays(np.float64, shape, elements=COORDINATE)
    return st.tuples(cloud, flat).map(lambda both: both[0] * np.array(both[1]))


def apart(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.linalg.norm(a[:, None] - b, axis=2)


@given(clouds(), clouds(1), st.sampled_from([0.0112, 0.5012, 2.0012, np.inf]), st.booleans())
def test_nearest(
    wanted: NDArray[np.float64], points: NDArray[np.float64], most: float, coloured: bool
) -> None:
    tint, tone = (np.float32([0.5, 2.0, 1.0]) * np.float32(p) for p in (wanted, points))
    weight = 0.7 if coloured else 0.0
    distance, index = nearest(columns(points, tone, weight), wanted, tint, weight, most)
    away = np.hypot(apart(wanted, points), weight * apart(tint, tone))
    found = index >= 0
    assert np.array_equal(found, away.min(axis=1) < most)
    np.testing.assert_allclose(distance[found], away.min(axis=1)[found], atol=1e-6)
    np.testing.assert_allclose(away[found, index[found]], distance[found], atol=1e-6)
    assert (distance[~found] == most).all()


@given(clouds(), clouds(), st.sampled_from([0.0512, 1.0012, 10.0012]))
def test_three_nearest(
    wanted: NDArray[np.float64], points: NDArray[np.float64], most: float
) -> None:
    distance, index = nearest_three(columns(points, NONE, 0.0), wanted, most)
    away = np.sort(np.hstack([apart(wanted, points), np.full((len(wanted), 3), np.inf)]), axis=1)
    expected = np.where(away[:, :3] < most, away[:, :3], np.inf)
    np.testing.assert_allclose(distance, expected, atol=1e-9)
    assert np.array_equal(index >= 0, np.isfinite(expected))
    assert all(len(set(row[row >= 0])) == (row >= 0).sum() for row in index)


@given(clouds(), st.sampled_from([0.0, 0.3012, 1.5012]))
def test_pairs(points: NDArray[np.float64], most: float) -> None:
    one, other = np.nonzero(np.triu(apart(points, points) <= most, 1))
    expected = sorted(zip(one.tolist(), other.tolist(), strict=True))
    assert sorted(map(tuple, pairs(points, most).tolist())) == expected


@given(clouds(), clouds(1), st.sampled_from([0.05, 1.0]))
def test_all_that_is_near_is_perhaps_near(
    points: NDArray[np.float64], some: NDArray[np.float64], reach: float
) -> None:
    near = apart(points, some).min(axis=1) < reach
    assert perhaps_near(np.float32(points), np.float32(some), reach)[near].all()


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 1e300])
def test_what_is_no_number_is_near_to_nothing_and_harms_nothing(wrong: float) -> None:
    points = np.random.default_rng(0).random((300, 3))
    wanted = points.copy()
    wanted[::3, 1] = wrong
    spoilt = points.copy()
    spoilt[1::3, 2] = wrong
    index = nearest(columns(spoilt, NONE, 0.0), wanted, NONE, 0.0, 0.01)[1]
    assert (index[::3] == -1).all()
    assert (index[1::3] == -1).all()
    assert np.array_equal(index[2::3], np.arange(2, 300, 3))
    assert nearest_three(columns(spoilt, NONE, 0.0), wanted, 0.01)[1].max() < 300
    assert len(pairs(spoilt, 0.01)) < 300
