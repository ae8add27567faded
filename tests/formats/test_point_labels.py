"""Labels a point: arrays of any type of whole numbers, and text with a label a line."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import laspy
import numpy as np
import plyfile
import pytest

from pointbrush.errors import BadInputError
from pointbrush.formats.annotation import find_label_files
from pointbrush.formats.options import Limits, ReadOptions
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.formats.tables.datasets import ClassName


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


def test_flat_arrays_are_labels_in_a_folder_of_any_name(tmp_path: Path) -> None:
    place = tmp_path / "truth"
    place.mkdir()
    for name in ("0000", "0001"):
        np.save(place / f"{name}.npy", np.array([0, 7], np.uint16))
    assert read(place) == [[0, 7], [0, 7]]
    np.save(place / "0002.npy", np.zeros((2, 3)))
    assert find_label_files(place, None, {}, Limits()).format == "points"


def test_labelcloud_marks_points_with_the_classes_that_it_states(tmp_path: Path) -> None:
    """labelCloud io/segmentations/numpy.py, model/point_cloud.py: an int8 a point; points have the
    default class until somebody labels them."""
    named = [{"name": name, "id": i, "color": "#f156ff"} for i, name in enumerate(("none", "cart"))]
    (tmp_path / "segmentation").mkdir()
    stated = {"classes": named, "default": 0, "type": "object_detection"}
    (tmp_path / "_classes.json").write_text(json.dumps(stated))
    np.array([0, 1, 1], np.int8).tofile(tmp_path / "segmentation" / "scan.bin")
    files = find_label_files(tmp_path, None, {}, Limits())
    assert files.format == "labelcloud-points"
    assert files.names == {1: ClassName("cart", "#f156ff")}
    assert read(tmp_path) == [[0, 1, 1]]
    (tmp_path / "_classes.json").write_text(json.dumps(stated | {"default": 1}))
    assert set(find_label_files(tmp_path, None, {}, Limits()).names) == {0, 1}


def test_nuscenes_states_its_classes(tmp_path: Path) -> None:
    """nuscenes-devkit python-sdk/nuscenes/nuscenes.py: ``index`` of category.json."""
    rows = [{"token": str(i), "name": name, "index": i} for i, name in enumerate(("noise", "cow"))]
    for folder in ("v1.0-mini", "lidarseg/v1.0-mini"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "v1.0-mini" / "category.json").write_text(json.dumps(rows))
    path = tmp_path / "lidarseg" / "v1.0-mini" / f"{'a' * 32}_lidarseg.bin"
    path.write_bytes(b"\0\1")
    names = find_label_files(path.parent, None, {}, Limits()).names
    assert (names.get(0), names[1]) == (None, ClassName("cow"))
    without = [{"token": "t", "name": "cow"}]
    (tmp_path / "v1.0-mini" / "category.json").write_text(json.dumps(without))
    assert find_label_files(path.parent, None, {}, Limits()).names[1] == ClassName(
        "animal", "#4682b4"
    )


def cloudcompare_ply(path: Path, values: np.ndarray) -> None:
    rows = [(i, 0.0, 0.0, value) for i, value in enumerate(values)]
    kind = [("x", "f4"), ("y", "f4"), ("z", "f4"), ("scalar_Classification", "f4")]
    plyfile.PlyData([plyfile.PlyElement.describe(np.array(rows, kind), "vertex")]).write(str(path))


def cloudcompare_pcd(path: Path, values: np.ndarray) -> None:
    names = "VERSION .7\nFIELDS x y z Classification\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
    size = f"WIDTH {len(values)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(values)}\n"
    rows = np.array([(i, 0, 0, value) for i, value in enumerate(values)], "<f4")
    path.write_bytes(f"{names}{size}DATA binary\n".encode() + rows.tobytes())


def cloudcompare_asc(path: Path, values: np.ndarray) -> None:
    rows = [f"{i}.000000 0.000000 0.000000 {value:f}" for i, value in enumerate(values)]
    path.write_text("\n".join(["//X Y Z Classification", str(len(values)), *rows, ""]))


@pytest.mark.parametrize("write", [cloudcompare_ply, cloudcompare_pcd, cloudcompare_asc])
def test_cloudcompare_keeps_classes_in_a_scalar_field_with_nan_for_none(
    tmp_path: Path, write: Callable[[Path, np.ndarray], None]
) -> None:
    """CloudCompare qCC_io/src/PlyFilter.cpp, AsciiFilter.cpp, qPCL/PclUtils/utils/cc2sm.cpp."""
    write(tmp_path / f"scan.{write.__name__[-3:]}", np.array([2, np.nan, 6, 0]))
    assert read(tmp_path) == [[2, 0, 6, 0]]


def test_cloudcompare_keeps_scalar_fields_as_extra_dimensions_of_las(tmp_path: Path) -> None:
    """CloudCompare qLASIO/src/LasScalarField.cpp, LasExtraScalarField.cpp."""
    las = laspy.create(point_format=6, file_version="1.4")
    las.add_extra_dim(laspy.ExtraBytesParams("tree class", "f4"))
    las.xyz = np.zeros((4, 3))
    las.classification = np.array([2, 1, 6, 0])
    las["tree class"] = np.array([0, 3, 4, np.nan])
    las.write(tmp_path / "scan.las")
    assert read(tmp_path, "las") == [[2, 0, 6, 0]]
    options = ReadOptions(chosen=Corrections(columns=("tree class=label",)))
    files = find_label_files(tmp_path, "points", {}, Limits())
    assert files.read(files.paths[0], options).category.tolist() == [0, 3, 4, 0]
