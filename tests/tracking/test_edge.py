"""Painted objects at the edge of the picture: cut off by it, or small and whole."""

from __future__ import annotations

import numpy as np
import pytest
import scenes
from views import BLUE, shot

from pointbrush.tracking.model.painted import cut_off_by_edge


@pytest.mark.parametrize(
    ("right", "half", "cut", "entering"),
    [
        (1.15, (0.3, 0.3, 0.1), True, True),  # a broad contact, though few points are at the edge
        (0.2, (0.3, 0.3, 0.1), False, False),  # nowhere near the edge
        (1.15, (0.3, 0.05, 0.05), False, True),  # too small to be a part of a person, or a hand
    ],
)
def test_a_part_of_a_person_is_cut_off_where_much_of_its_width_touches_the_edge(
    right: float, half: tuple[float, float, float], cut: bool, entering: bool
) -> None:
    at = np.array([right, 1.2, 1.6])
    view = shot(scenes.Part(1, BLUE, at, np.array(half), rot=np.eye(3)))
    points = np.flatnonzero(view.frame.truth == 1)
    xyz = view.xyz[points].astype(np.float64)
    radius = float(np.percentile(np.linalg.norm(xyz - np.median(xyz, axis=0), axis=1), 90))
    view.labels = {1: points}
    assert cut_off_by_edge(view, points, radius) == (cut, entering)
