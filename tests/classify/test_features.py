"""Features tell of a point's surroundings, and nothing of where it is or which way they turn."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pointbrush.classify.features import (
    Described,
    ExampleFrame,
    describe,
    feature_names,
    scale_of,
)
from pointbrush.classify.options import FeatureOptions
from pointbrush.errors import BadInputError

OPTIONS = FeatureOptions()
RNG = np.random.default_rng(3)
SIZE = 0.125


def scene() -> NDArray[np.float64]:
    """A floor, a wall, and a post, metres."""
    floor = np.column_stack([RNG.uniform(0, 4, (4000, 2)), RNG.normal(0, 0.01, 4000)])
    wall = np.column_stack([RNG.uniform(0, 4, 3000), np.full(3000, 4.0), RNG.uniform(0, 2, 3000)])
    turn = RNG.uniform(0, 2 * np.pi, 600)
    post = np.column_stack(
        [1 + 0.06 * np.cos(turn), 1 + 0.06 * np.sin(turn), RNG.uniform(0, 2, 600)]
    )
    return np.concatenate([floor, wall, post])


SCENE = scene()
FLOOR, WALL, POST = slice(0, 4000), slice(4000, 7000), slice(7000, None)


def described(xyz: NDArray[np.float64]) -> Described:
    return describe(ExampleFrame(xyz), SIZE, OPTIONS)


def of_points(xyz: NDArray[np.float64]) -> NDArray[np.float32]:
    made = described(xyz)
    return made.features[made.of_point]


PLAIN = of_points(SCENE)


@settings(deadline=None, max_examples=10)
@given(st.tuples(*[st.floats(-5e5, 5e5)] * 3))
def test_moving_a_frame_changes_nothing(away: tuple[float, float, float]) -> None:
    moved = of_points(SCENE + np.round(away, 3))
    # A cell's border may fall on the other side of a point by rounding.
    assert np.quantile(np.abs(moved - PLAIN), 0.99) < 1e-3


@settings(deadline=None, max_examples=10)
@given(st.floats(0, 2 * np.pi))
def test_turning_a_frame_round_the_vertical_changes_little(angle: float) -> None:
    c, s = np.cos(angle), np.sin(angle)
    turned = of_points(SCENE @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]))
    spread = PLAIN.std(axis=0)
    kept = spread > 1e-6
    apart = np.abs(turned - PLAIN)[:, kept] / spread[kept]
    assert np.median(apart) < 0.25


def test_floor_wall_and_post_are_told_apart() -> None:
    names = feature_names(OPTIONS)
    assert PLAIN.shape[1] == len(names)
    level, line = names.index("level 0"), names.index("line 1")
    assert np.median(PLAIN[FLOOR, level]) > 0.95
    assert np.median(PLAIN[WALL, level]) < 0.1
    aloft = SCENE[:, 2] > 1
    assert np.median(PLAIN[POST, line][aloft[POST]]) > 2 * np.median(PLAIN[WALL, line][aloft[WALL]])
    high = PLAIN[WALL, names.index("over ground 0.5")]
    assert np.corrcoef(high, SCENE[WALL, 2])[0, 1] > 0.95


def test_heights_over_the_ground_hold_on_slopes() -> None:
    floor = np.column_stack([RNG.uniform(0, 20, (40_000, 2)), np.zeros(40_000)])
    shed = (np.abs(floor[:, :2] - 10) < 1).all(axis=1)
    floor[shed, 2] = 1.5
    floor[:, 2] += 0.4 * floor[:, 0]
    made = described(floor)
    over = made.features[made.of_point, feature_names(OPTIONS).index("over opened 25")]
    assert np.median(over[shed]) == pytest.approx(1.5, abs=0.2)
    inside = floor[:, 0] < 15  # further up, the window reaches over the border
    assert np.quantile(over[~shed & inside], 0.95) < 0.2


def test_colour_and_returns_are_features_where_there_are_any() -> None:
    rgb = np.zeros((len(SCENE), 3), np.uint8)
    rgb[FLOOR, 0] = 255
    returns = np.ones((len(SCENE), 2))
    returns[WALL, 1] = 2
    made = describe(ExampleFrame(SCENE, rgb, returns=returns), SIZE, OPTIONS)
    names, values = feature_names(OPTIONS), made.features[made.of_point]
    assert np.median(values[FLOOR, names.index("red")]) > 50
    assert np.median(values[WALL, names.index("last return")]) == 0


def test_alike_frames_have_one_scale() -> None:
    again = SCENE + RNG.normal(0, 0.003, SCENE.shape)
    sizes = np.log2([scale_of(SCENE, OPTIONS), scale_of(again, OPTIONS)]) * 2
    assert np.allclose(sizes, np.round(sizes))
    assert abs(sizes[0] - sizes[1]) < 1.5
    assert len(described(SCENE[:0]).features) == 0
    with pytest.raises(BadInputError, match="at least one point"):
        scale_of(SCENE[:0], OPTIONS)
    with pytest.raises(BadInputError, match="finite"):
        described(np.full((3, 3), np.nan))
