"""Votes of neighbours and of pieces correct outliers, and keep borders."""

from __future__ import annotations

import numpy as np
import pytest

from pointbrush.classify.smoothing import average_over_pieces, smoothed

ROOF, TREE = [0.95, 0.05], [0.05, 0.95]


def test_cells_between_others_keep_their_class_unless_they_are_in_doubt() -> None:
    near = np.full((5, 26), -1, np.int32)
    near[4, :4] = np.arange(4)
    for own, others, expected in ((ROOF, TREE, 0), ([0.55, 0.45], TREE, 1)):
        chance = np.array([*[others] * 4, own], np.float32)
        out = smoothed(chance, near)
        assert out.sum(axis=1) == pytest.approx(np.ones(5), abs=1e-5)
        assert out[4].argmax() == expected


def test_cells_of_a_piece_vote() -> None:
    chance = np.array([[0.9, 0.1], [0.8, 0.2], [0.45, 0.55], [0.2, 0.8]], np.float32)
    out = average_over_pieces(chance, np.array([0, 0, 0, 1], np.int32))
    assert out.sum(axis=1) == pytest.approx(np.ones(4))
    assert out[2, 0] > 0.5  # outvoted
    assert out[3] == pytest.approx(chance[3])
    assert average_over_pieces(chance, np.zeros(0, np.int32)).tolist() == chance.tolist()
