"""Columns by their names: instances that 16 bits do not hold cost their points alone."""

from __future__ import annotations

import logging

import numpy as np
import pytest

from pointbrush.formats.options import ReadOptions
from pointbrush.formats.tables.columns import frame_from_columns
from pointbrush.frame import PointFrame


def of_instances(values: list[float], kind: str, name: str = "instance") -> PointFrame:
    axes = {axis: np.arange(len(values), dtype=np.float32) for axis in "xyz"}
    return frame_from_columns("a.ply", {**axes, name: np.array(values, kind)}, ReadOptions())


@pytest.mark.parametrize(
    ("values", "kind", "said"),
    [
        (
            [3, 70_000, 4, 70_000, 2**31 - 1],
            "i4",
            "3 points of 2 other numbers (70000, 2147483647)",
        ),
        ([3, -(2**31), 4, 0, 0], "i4", "1 points of 1 other numbers (-2147483648)"),
        ([3, 1e20, 4, 0, 0], "f8", "1 points of 1 other numbers (1e+20)"),
    ],
)
def test_instances_beyond_16_bits_are_named_and_cost_their_points(
    values: list[float], kind: str, said: str, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING):
        frame = of_instances(values, kind)
    assert frame.instance is not None
    assert frame.instance.tolist() == [3, 0, 4, 0, 0]
    assert said in caplog.text
    assert frame.other["instance"].tolist() == values, "nothing is lost"


def test_instances_none_of_which_fits_stay_a_field(caplog: pytest.LogCaptureFixture) -> None:
    frame = of_instances([2**40, 2**41, 2**41], "i8")
    assert frame.instance is None
    assert frame.other["instance"].tolist() == [2**40, 2**41, 2**41]
    assert "3 points of 2 other numbers" in caplog.text


def test_trees_of_lidr_without_a_number_have_no_instance(caplog: pytest.LogCaptureFixture) -> None:
    frame = of_instances([1, np.nan, 2, -1], "f8", "treeID")
    assert frame.instance is not None
    assert frame.instance.tolist() == [1, 0, 2, 0]
    assert "no instance" not in caplog.text
    assert "columns treeID=label makes each one a label" in caplog.text
