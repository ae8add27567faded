"""Labels a point: arrays of any type of whole numbers, and text with a label a line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pointbrush.errors import BadInputError
from pointbrush.formats.annotation import find_label_files
from pointbrush.formats.options import Limits, ReadOptions


def read(place: Path, format: str | None = None) -> list[list[int]]:
    files = find_label_files(place, format, {}, Limits())
    return [files.read(path, ReadOptions()).category.tolist() for path in files.paths]


@pytest.mark.parametrize("kind", ["f2", "f4", "f8", "bool", "i1", "i8", ">u4"])
def test_arrays_of_whole_numbers_of_any_type_are_labels(tmp_path: Path, kind: str) -> None:
    np.save(tmp_path / "labels_0.npy", np.array([0, 1, 1], kind))
    assert read(tmp_path) == [[0, 1, 1]]


def test_marks_of_no_label_in_arrays_of_floats(tmp_path: Path) -> None:
    np.save(tmp_path / "labels_0.npy", np.array([np.nan, -1, 7]))
    assert read(tmp_path) == [[0, 0, 7]]


@pytest.mark.parametrize("wrong", [0.5, np.inf, 1e9, -3])
def test_other_floats_are_no_labels(tmp_path: Path, wrong: float) -> None:
    np.save(tmp_path / "labels_0.npy", np.array([1, wrong]))
    with pytest.raises(BadInputError, match=r"labels_0\.npy: expected .*labels"):
        read(tmp_path)


@pytest.mark.parametrize("name", ["scan.labels", "scan.seg", "scan.txt", "scan.csv"])
@pytest.mark.parametrize(
    "text", ["2\n0\n17\n", "2\r\n0\r\n17", "2.0\n0.0\n17.0\n", "label\n2\n0\n17\n"]
)
def test_text_with_a_label_a_line(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_bytes(text.encode())
    assert read(tmp_path) == [[2, 0, 17]]


def test_texts_beside_labels_are_no_labels(tmp_path: Path) -> None:
    (tmp_path / "scan_0.txt").write_text("2\n0\n")
    (tmp_path / "times.txt").write_text("1\n2\n")
    (tmp_path / "classes.txt").write_text("0 none\n2 tree\n")
    (tmp_path / "scores.txt").write_text("0.25\n0.5\n")
    assert read(tmp_path) == [[2, 0]]


def test_lines_that_are_no_labels_say_so(tmp_path: Path) -> None:
    (tmp_path / "scan.labels").write_text("2\ncar\n")
    with pytest.raises(BadInputError, match=r"scan\.labels: expected numbers, .* line 2"):
        read(tmp_path)
    (tmp_path / "scan.labels").write_text("2\n0.5\n")
    with pytest.raises(BadInputError, match=r"scan\.labels: expected whole labels, got 0\.5"):
        read(tmp_path)
