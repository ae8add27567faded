"""Quantised positions stay within the error they state."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pointbrush.sequences.octree.quantise import ROOM_STEP, base_step, quantise
from tests.sequences.vertex_decoder import dequantise

finite = st.floats(-(2.0**100), 2.0**100, width=32)


def assert_within(xyz: np.ndarray, step: float) -> None:
    quantised = quantise(xyz, step)
    back = dequantise(quantised.q, quantised.origin, quantised.scale)
    difference = np.abs(back.astype(np.float64) - xyz)
    assert difference.max(initial=0.0) <= quantised.error
    assert (quantised.scale >= step).all()
    for exact in (quantised.origin, quantised.scale):
        assert np.array_equal(exact.astype(np.float32).astype(np.float64), exact)


@given(arrays(np.float32, st.tuples(st.integers(0, 40), st.just(3)), elements=finite))
def test_error_bound_holds_for_any_points(xyz: np.ndarray) -> None:
    assert_within(xyz, ROOM_STEP)


@given(st.integers(0, 2**32 - 1), st.floats(-12, 7), st.floats(-3, 7))
def test_error_bound_holds_at_any_size_and_place(seed: int, size: float, place: float) -> None:
    rng = np.random.default_rng(seed)
    xyz = (rng.uniform(-1, 1, (500, 3)) * 10**size + rng.normal(size=3) * 10**place).astype("f4")
    assert_within(xyz, base_step(float(np.ptp(xyz, axis=0).max())))


def test_flat_and_single_points() -> None:
    flat = np.random.default_rng(0).uniform(0, 3, (100, 3)).astype(np.float32)
    flat[:, 1] = 1.2345
    assert_within(flat, ROOM_STEP)
    assert_within(flat[:1], ROOM_STEP)
    assert_within(flat[:0], ROOM_STEP)


def test_a_room_has_a_millimetre_and_an_object_a_tenth() -> None:
    room = np.random.default_rng(0).uniform(-4, 4, (1000, 3)).astype(np.float32)
    assert quantise(room, base_step(8.0)).error == pytest.approx(0.0005, rel=0.05)
    thing = room / 20
    assert quantise(thing, base_step(0.4)).error < 0.0001 / 2


@pytest.mark.parametrize(
    ("extent", "step"), [(1.0, 2**-10), (5.0, 2**-10), (200.0, 2**-9), (5e3, 2**-8), (0.0, 2**-10)]
)
def test_the_grid_follows_the_extent(extent: float, step: float) -> None:
    assert base_step(extent) == step
