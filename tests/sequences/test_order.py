"""Progressive order: every prefix is an even, deterministic subsample."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from pointbrush.sequences.octree.order import MAX_POINTS, morton_codes, morton_order, progressive


def room(count: int, seed: int = 0) -> np.ndarray:
    """Points on the faces of a box, in the order of rows, as a scanner delivers them."""
    rng = np.random.default_rng(seed)
    xyz = rng.uniform(0, 4, (count, 3)).astype(np.float32)
    xyz[np.arange(count), rng.integers(0, 3, count)] = 0
    return xyz[np.lexsort(xyz.T)]


@given(st.integers(0, 20_000), st.integers(1, 4096))
def test_order_is_a_permutation_and_levels_double(count: int, level0: int) -> None:
    order, first = progressive(morton_order(room(count)), level0)
    assert np.array_equal(np.sort(order), np.arange(count))
    assert first[0] == 0
    assert first[-1] == count
    assert first[1] <= level0 or count == 0
    for before, after in pairwise(first[1:]):
        assert 2 * before - 1 <= after <= 2 * before


def test_every_prefix_of_levels_takes_every_kth_position_of_the_curve() -> None:
    curve = morton_order(room(50_000))
    position = np.empty(50_000, np.int64)
    position[curve] = np.arange(50_000)
    order, first = progressive(curve)
    for level, stop in enumerate(first[1:]):
        gaps = np.diff(np.sort(position[order[:stop]]))
        assert set(gaps.tolist()) == {2 ** (len(first) - 2 - level)}


def test_a_prefix_covers_the_room_better_than_chance() -> None:
    xyz = room(60_000)
    order, first = progressive(morton_order(xyz))
    chance = np.random.default_rng(1).permutation(len(xyz))

    def farthest(chosen: np.ndarray) -> float:
        return float(np.quantile(cKDTree(xyz[chosen]).query(xyz)[0], 0.999))

    assert farthest(order[: first[1]]) < 0.9 * farthest(chance[: first[1]])


def test_inside_a_level_neighbours_are_near() -> None:
    xyz = room(60_000)
    order, first = progressive(morton_order(xyz))
    last = xyz[order[first[-2] :]]
    steps = np.linalg.norm(np.diff(last, axis=0), axis=1)
    assert np.median(steps) < 0.05


def test_morton_interleaves_x_first() -> None:
    cells = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [3, 3, 3], [20_000] * 3, [-1, 1, -5]])
    codes = morton_codes(cells.astype(np.float32), np.zeros(3), 2.0**14)
    assert codes.tolist() == [1, 2, 4, 63, 2**42 - 1, 2]


@pytest.mark.parametrize("value", [0.0, -3.5, 1e30])
def test_identical_points_keep_their_order(value: float) -> None:
    order, _ = progressive(morton_order(np.full((300, 3), value, np.float32)))
    assert order.tolist() == list(range(300))


def test_more_points_than_fit_a_key_are_refused() -> None:
    with pytest.raises(ValueError, match="at most"):
        morton_order(np.broadcast_to(np.float32(0), (MAX_POINTS + 1, 3)))
