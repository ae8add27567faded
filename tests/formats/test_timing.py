"""Times in names and lists, and the rates they imply."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pointbrush.errors import BadInputError
from pointbrush.formats.times.timing import (
    natural_key,
    rate_of,
    read_times,
    stated_rate,
    time_in_name,
)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("frame_20121214T142255.814212", 1355494975.814212),
        ("2012-12-14", None),
        ("scan 20121214_142255", 1355494975),
        ("20121314T142255", None),
        ("1311868164.363181", 1311868164.363181),
        ("cloud_1311868164_5", 1311868164.5),
        ("00_lidar_15569195938203752", 1556919593.8203752),
        ("1500000000123", 1500000000.123),
        ("1500000000123456789", 1500000000.1234567),
        ("1311868164-363181", 1311868164.363181),
        ("1311868164-12", 1311868164),
        ("000123", None),
        ("9999999999", None),
        ("12345678901234567890123", None),
    ],
)
def test_times_in_names_are_read(name, expected):
    assert time_in_name(name) == (
        expected if expected is None else pytest.approx(expected, abs=1e-5)
    )


@pytest.mark.parametrize(
    ("times", "rate"),
    [
        ([0, 0.1, 0.2], 10),
        ([0, 0.0333, 0.0667, 0.1], 30),
        ([0, 0.2592, 0.5184], 3.858),
        ([0, 1, 2, 100], 1),
        ([0], None),
        ([5, 5, 5.1, 5.1, 5.2], 10),
        ([3599.8, 3599.9, 0, 0.1], 10),
        ([0, 0, 0, 1], None),
        ([1, 0], None),
        ([0, 1e-9], None),
        (None, None),
    ],
)
def test_the_rate_is_told_by_the_times(times, rate):
    assert rate_of(times) == (rate if rate is None else pytest.approx(rate, abs=0.02))


@given(st.lists(st.integers(0, 10**6), unique=True))
def test_numbers_in_names_sort_as_numbers(numbers):
    paths = [Path(f"frame{number}_a.ply") for number in numbers]
    expected = [Path(f"frame{number}_a.ply") for number in sorted(numbers)]
    assert sorted(paths, key=natural_key) == expected


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0\nsoon\n", "line 2: expected a time, got another line"),
        ("0\nnan\n", "line 2"),
        ("0.1 a.ply\n0.2 other.ply\n", "a time for 'b.ply'"),
        ("0\n", "expected 2 times"),
    ],
)
def test_lists_that_do_not_fit(tmp_path, text, message):
    (tmp_path / "times.txt").write_text(text)
    with pytest.raises(BadInputError) as caught:
        read_times(tmp_path / "times.txt", ["a.ply", "b.ply"])
    assert message in str(caught.value)


def test_a_header_of_a_list_is_passed_over(tmp_path):
    (tmp_path / "times.csv").write_text("time,name\n1,a.ply\n2,b\n")
    assert read_times(tmp_path / "times.csv", ["a.ply", "b.ply"]) == [1, 2]


@pytest.mark.parametrize(
    ("meta", "rate"),
    [
        ({"fps": 30}, 30),
        ({"rate_hz": 10.0}, 10),
        ({"rate_hz": "2-4"}, None),
        ({"fps": -1}, None),
        ([], None),
    ],
)
def test_a_stated_rate_is_believed_if_it_is_one(tmp_path, meta, rate):
    (tmp_path / "meta.json").write_text(json.dumps(meta))
    assert stated_rate(tmp_path) == rate
