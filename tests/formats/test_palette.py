"""Names of labels that come with files."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np
import pytest

from pointbrush.formats import LabeledFrame, export, own_labels, read
from pointbrush.formats.source import open_source
from pointbrush.formats.tables.datasets import SEMANTIC_KITTI
from pointbrush.formats.writers.labeled import Palette
from pointbrush.frame import PointFrame


@dataclass
class Label:
    id: int
    name: str
    category: str
    color: str
    instance: int | None = None


PALETTE = [Label(300, "pin 1", "pin", "#ff8800"), Label(7, "Ännä", "", "#00ff00")]


def frames():
    label = np.array([0, 7, 300], np.uint16)
    points = PointFrame(xyz=np.eye(3))
    yield LabeledFrame(0, points, label, np.zeros(3, np.uint8), np.zeros(3, bool))


FOLDERS = [(name, out) for name in ("ply", "semantickitti") for out in ("out", "out.zip")]


@pytest.mark.parametrize(("name", "out"), [*FOLDERS, ("npz", "a.npz"), ("las", "a.las")])
def test_an_export_read_again_keeps_ids_and_names(tmp_path, name, out):
    export(name, frames(), PALETTE, tmp_path / out)
    labels = {label.id: label for label in own_labels([tmp_path / out])}
    assert labels[300].name == "pin 1"
    assert labels[300].category == "pin"
    assert labels[300].color == "#ff8800"
    assert labels[7].name == "Ännä"
    (frame,) = read(tmp_path / out)
    assert frame.label.tolist() == [0, 7, 300]


def test_labels_beside_scans_are_of_semantickitti(tmp_path):
    drive = tmp_path / "sequences" / "03"
    for folder in ("velodyne", "labels"):
        (drive / folder).mkdir(parents=True)
    scan = drive / "velodyne" / "0.bin"
    scan.write_bytes(bytes(32))
    for labels, dataset in ((None, ""), (bytes(8), SEMANTIC_KITTI.name)):
        if labels is not None:
            (drive / "labels" / "0.label").write_bytes(labels)
        for path in (tmp_path, drive, scan.parent, scan):
            with open_source([path]) as source:
                assert source.listings[0].dataset == dataset


@pytest.mark.parametrize(
    "document",
    [
        *("", "[]", "{}", '{"labels": 3}', "[" * 100_000),
        json.dumps({"labels": [{"id": 0, "name": "a", "category": "", "color": "#000000"}]}),
        json.dumps({"labels": [{"id": 1, "name": "a", "category": "", "color": "red"}]}),
        json.dumps({"labels": [{"id": 1, "name": "a", "category": "", "color": "#000000"}] * 2}),
    ],
)
def test_other_files_of_that_name_name_nothing(tmp_path, document):
    (tmp_path / "palette.json").write_text(document)
    assert own_labels([tmp_path]) == []


def test_a_class_gets_no_number_that_another_one_has_in_a_data_set():
    trees = [Label(4, "tree", "", "#00ff00")]
    palette = Palette(trees, {"tree": 3}, {"rellis": {"grass": 3}})
    assert palette.of_dataset("rellis").category[[0, 4]].tolist() == [0, 65535]
