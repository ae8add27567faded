"""The cluster tool: one thing that stands on the ground, whole, and nothing of the ground."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pointbrush.selection import Points, Selector, Stroke, select
from tests.selection.test_select import indexed

GAP, SLOPE, STEP = 0.3, 0.08, 0.08
BOXES = np.array([[3.0, 2.0], [3.0, 3.4], [-4.0, 1.0]])
SIZE = np.array([1.0, 0.8, 1.5])


def street(seed: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A sloping street with boxes on it, z up: points (N, 3), and of which box each is, or -1."""
    rng = np.random.default_rng(seed)
    plan = np.mgrid[-8:8:STEP, -6:6:STEP].reshape(2, -1).T
    parts, owner = [np.column_stack([plan, rng.normal(0, 0.01, len(plan))])], [-1] * len(plan)
    for number, at in enumerate(BOXES):
        x, y, z = (np.arange(0, edge + 1e-9, STEP) for edge in SIZE)
        grid = np.stack(np.meshgrid(x, y, z, indexing="ij"), -1).reshape(-1, 3)
        shell = (np.abs(grid / SIZE - 0.5) > 0.45).any(axis=1)
        parts.append(grid[shell] - [*(SIZE[:2] / 2), 0] + [*at, 0])
        owner += [number] * int(shell.sum())
    xyz = np.concatenate(parts)
    xyz[:, 2] += SLOPE * xyz[:, 0]
    return xyz, np.array(owner)


def pointed_at(place: NDArray[np.float64], up: NDArray[np.float64]) -> Stroke:
    sample = {"origin": (place + 4 * up).tolist(), "direction": (-up).tolist()}
    return Stroke.parse({"label": 1, "shape": "cluster", "radius": GAP, "samples": [sample]})


@given(st.integers(0, 2**32 - 1), st.integers(0, 2))
@settings(max_examples=8, deadline=None)
def test_a_cluster_is_one_box_without_the_street(seed: int, number: int) -> None:
    """In coordinates of any orientation: up is the recording's, not an axis."""
    rng = np.random.default_rng(seed)
    xyz, owner = street(seed)
    turn = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    up = turn @ [0.0, 0, 1]
    points = replace(indexed((xyz @ turn.T).astype(np.float32)), up=tuple(up.tolist()))
    roof = np.array([*BOXES[number], SIZE[2] + SLOPE * BOXES[number][0]]) @ turn.T
    stroke = pointed_at(roof, up)
    got = select(points, stroke)
    over = xyz[:, 2] - SLOPE * xyz[:, 0]
    assert set(owner[got]) == {number}
    assert set(np.flatnonzero((owner == number) & (over > 0.45))) <= set(got), "but for its foot"
    selector = Selector(points, stroke.run(slice(0, 0)))
    list(selector.add(stroke))
    assert len(selector.taken) == len(got)


@pytest.mark.parametrize("place", [(0.0, 0.0), (-6.0, -4.0)])
def test_the_ground_alone_is_no_cluster(place: tuple[float, float]) -> None:
    points: Points = indexed(street(1)[0].astype(np.float32))
    at = np.array([*place, SLOPE * place[0]])
    assert len(select(points, pointed_at(at, np.array([0.0, 0, 1])))) == 0
