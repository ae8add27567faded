"""Places that are offered for an answer."""

from __future__ import annotations

import numpy as np

from pointbrush.classify.doubt import doubts
from pointbrush.classify.features import Described
from pointbrush.classify.options import DoubtOptions

SPARSE, DENSE = 30, 10
"""Cells with one point each, and cells with 100."""


def test_the_place_that_resembles_most_points_comes_first() -> None:
    cells = SPARSE + DENSE
    features = np.zeros((cells, 4), np.float32)
    features[SPARSE:] = 5
    of_point = np.repeat(np.arange(cells), [1] * SPARSE + [100] * DENSE).astype(np.int32)
    place = Described(
        0.1, of_point, np.zeros((cells, 3), np.float32), np.full((cells, 26), -1, np.int32),
        features, np.zeros(0, np.int32),
    )  # fmt: skip
    chance = np.full((cells, 2), 0.5, np.float32)
    open_, none = np.ones(cells, bool), np.zeros((0, 4), np.float32)
    found = doubts(place, chance, open_, none, np.ones(4), DoubtOptions(), most=2)
    assert [each.cell >= SPARSE for each in found] == [True, False]
    assert found[0].worth > found[1].worth
