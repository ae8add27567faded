"""Searches in columns and in runs find what comparing all with all finds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components, dijkstra

from pointbrush.tracking.compute.columns import (
    NONE,
    columns,
    nearer_than,
    nearest,
    nearest_one,
    nearest_three,
    pairs,
    spans,
)
from pointbrush.tracking.compute.graph import parts, paths_over, shortest_paths
from pointbrush.tracking.compute.grid import RUN, close_to, in_box, numbered, perhaps_near, runs_of
from pointbrush.tracking.compute.rigid import Target, excess
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.steps.connectivity import Limits, flood

OPTIONS = TrackerOptions()

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


@given(clouds(), clouds(1), st.sampled_from([0.0112, 0.5012, 2.0012]))
def test_each_is_asked_as_far_as_its_own_reach(
    wanted: NDArray[np.float64], points: NDArray[np.float64], most: float
) -> None:
    each = np.where(np.arange(len(wanted)) % 2, most, 0.3012)
    found = nearer_than(columns(points, NONE, 0.0), wanted, NONE, each)
    assert np.array_equal(found, apart(wanted, points).min(axis=1) < each)


@given(clouds(), clouds(1), st.sampled_from([0.0112, 0.5012, 2.0012, np.inf]), st.booleans())
def test_the_nearest_is_that_of_all_with_all(
    wanted: NDArray[np.float64], points: NDArray[np.float64], most: float, coloured: bool
) -> None:
    tint, tone = (np.float32([0.5, 2.0, 1.0]) * np.float32(p) for p in (wanted, points))
    weight = 0.7 if coloured else 0.0
    distance, index = nearest(columns(points, tone, weight), wanted, tint, most)
    away = np.hypot(apart(wanted, points), weight * apart(tint, tone))
    found = index >= 0
    assert np.array_equal(found, away.min(axis=1) < most)
    np.testing.assert_allclose(distance[found], away.min(axis=1)[found], atol=1e-6)
    np.testing.assert_allclose(away[found, index[found]], distance[found], atol=1e-6)
    assert (distance[~found] == most).all()


@given(clouds(1), clouds(1), st.sampled_from([0.5012, 2.0012]), st.booleans())
def test_a_likely_point_to_begin_with_changes_nothing(
    wanted: NDArray[np.float64], points: NDArray[np.float64], most: float, coloured: bool
) -> None:
    grid = columns(points, np.float32(points), 0.7 if coloured else 0.0)
    x, y, z = wanted[0].tolist()
    place, room = (x, y, z), spans(grid)
    for likely in range(len(points)):
        found = nearest_one(grid, place, place, most, room, likely)
        assert found[0] == nearest_one(grid, place, place, most, room, -1)[0]


@given(clouds(1), clouds(1))
def test_what_lies_just_beside_a_surface(
    surface: NDArray[np.float64], points: NDArray[np.float64]
) -> None:
    away = apart(points, surface).min(axis=1)
    on, beside = np.sum(away < 3 * 0.1504), np.sum((away >= 3 * 0.1504) & (away < 6 * 0.1504))
    found = excess(surface[None], Target(points, NONE, 0.0), 0.1504, options=OPTIONS.register)
    assert found[0] == pytest.approx(0.3 * min(1.0, beside / max(on, 1)))


@given(clouds(), clouds(), st.sampled_from([0.0112, 0.5012, 2.0012]), st.booleans())
def test_what_is_close_is_that_of_all_with_all(
    wanted: NDArray[np.float64], points: NDArray[np.float64], most: float, coloured: bool
) -> None:
    away = apart(wanted, points)
    if coloured:
        wanted, points = (np.hstack([p, np.float32(0.7) * np.float32(p)]) for p in (wanted, points))
        away = np.hypot(away, apart(wanted[:, 3:], points[:, 3:]))
    assert np.array_equal(close_to(wanted, points, most), (away < most).any(axis=1))


@given(clouds(), clouds(), st.sampled_from([0.0512, 1.0012, 10.0012]))
def test_the_three_nearest_are_those_of_all_with_all(
    wanted: NDArray[np.float64], points: NDArray[np.float64], most: float
) -> None:
    distance, index = nearest_three(columns(points, NONE, 0.0), wanted, most)
    away = np.sort(np.hstack([apart(wanted, points), np.full((len(wanted), 3), np.inf)]), axis=1)
    expected = np.where(away[:, :3] < most, away[:, :3], np.inf)
    np.testing.assert_allclose(distance, expected, atol=1e-9)
    assert np.array_equal(index >= 0, np.isfinite(expected))
    assert all(len(set(row[row >= 0])) == (row >= 0).sum() for row in index)


@given(clouds(), st.sampled_from([0.0, 0.3012, 1.5012]))
def test_pairs_are_those_of_all_with_all(points: NDArray[np.float64], most: float) -> None:
    one, other = np.nonzero(np.triu(apart(points, points) <= most, 1))
    expected = sorted(zip(one.tolist(), other.tolist(), strict=True))
    assert sorted(map(tuple, pairs(points, most).tolist())) == expected


@given(clouds(), st.sampled_from([0.3012, 1.5012]), st.integers(0, 2**32 - 1))
def test_parts_and_ways_are_those_of_a_graph(
    points: NDArray[np.float64], most: float, seed: int
) -> None:
    rng, count = np.random.default_rng(seed), len(points)
    some, links = rng.random(count) < 0.8, pairs(points, most)
    length = rng.uniform(0.1, 1.0, len(links))
    inside = links[some[links].all(axis=1)]
    graph = coo_matrix((np.ones(len(inside)), tuple(inside.T)), shape=(count, count))
    _, first = np.unique(connected_components(graph, directed=False)[1][some], return_inverse=True)
    assert np.array_equal(parts(links, some)[some], first)
    assert (parts(links, some)[~some] == -1).all()
    source = np.flatnonzero(some)[:2]
    way, origin = shortest_paths(paths_over(links, length, some), source, some)
    every = coo_matrix((length, tuple(links.T)), shape=(count, count)).tocsr()[some][:, some]
    expected = dijkstra(every, directed=False, indices=np.arange(len(source)))
    np.testing.assert_allclose(way[some], expected.min(axis=0, initial=np.inf))
    reached = np.flatnonzero(np.isfinite(way))
    assert np.isin(origin[reached], source).all()
    assert np.isinf(way[~some]).all()


@given(
    arrays(np.int64, st.integers(1, 60), elements=st.integers(-(2**60), 2**60) | st.integers(0, 9))
)
def test_keys_are_numbered_by_rank(key: NDArray[np.int64]) -> None:
    assert np.array_equal(numbered(key), np.unique(key, return_inverse=True)[1])


@given(clouds(), clouds(1), st.sampled_from([0.05, 1.0]))
def test_all_that_is_near_is_perhaps_near(
    points: NDArray[np.float64], some: NDArray[np.float64], reach: float
) -> None:
    near = apart(points, some).min(axis=1) < reach
    assert perhaps_near(np.float32(points), np.float32(some), reach)[near].all()


@given(
    clouds(1),
    clouds(),
    st.sampled_from([0.3012, 1.0012]),
    st.sampled_from([3, 20]),
    st.integers(0, 20),
    st.booleans(),
)
def test_what_hangs_together(
    core: NDArray[np.float64],
    rest: NDArray[np.float64],
    reach: float,
    steps: int,
    most: int,
    in_the_open: bool,
) -> None:
    low, high = np.full(3, -9.0 if in_the_open else -1.0), np.full(3, 1e7)
    joined, ends = flood(core, rest, Limits(reach, steps, most, low, high))
    expected = apart(rest, core).min(axis=1) < reach
    rounds = [expected]
    for _ in range(steps):
        expected = expected | (apart(rest, rest[expected]) < reach).any(axis=1)
        rounds.append(expected)
    ended = not expected.any() or bool((rounds[-1] == rounds[-2]).all())
    assert ends == (ended and expected.sum() <= most and bool((rest[expected] >= low).all()))
    assert not ends or np.array_equal(joined, expected)


@given(st.integers(0, 3 * RUN), st.integers(0, 2**32 - 1))
def test_what_lies_in_a_box(count: int, seed: int) -> None:
    xyz = np.random.default_rng(seed).normal(size=(count, 3)).astype(np.float32)
    lo, hi = np.array([-0.5, -9.0, 0.0]), np.array([0.5, 0.3, 9.0])
    expected = np.flatnonzero(((xyz >= lo) & (xyz <= hi)).all(axis=1))
    assert np.array_equal(in_box(runs_of(xyz), lo, hi), expected)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 1e300])
def test_what_is_no_number_is_near_to_nothing_and_harms_nothing(wrong: float) -> None:
    points = np.random.default_rng(0).random((300, 3))
    wanted = points.copy()
    wanted[::3, 1] = wrong
    spoilt = points.copy()
    spoilt[1::3, 2] = wrong
    index = nearest(columns(spoilt, NONE, 0.0), wanted, NONE, 0.01)[1]
    assert (index[::3] == -1).all()
    assert (index[1::3] == -1).all()
    assert np.array_equal(index[2::3], np.arange(2, 300, 3))
    assert nearest_three(columns(spoilt, NONE, 0.0), wanted, 0.01)[1].max() < 300
    assert len(pairs(spoilt, 0.01)) < 300
