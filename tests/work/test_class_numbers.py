"""Numbers of classes in exports: given once for a workspace, and told beside each export."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import laspy
import numpy as np
import pytest

from pointbrush.formats import EXPORTS
from pointbrush.frame import PointFrame
from pointbrush.labels.classes.taxonomy import Category
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.serving import with_labels


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    """Two recordings: one has cars and poles, the other poles and people."""
    place = tmp_path / "workspace"
    xyz = np.random.default_rng(0).uniform(0, 1, (40, 3)).astype(np.float32)
    for name in ("one", "two"):
        folder = place / "sequences" / name
        import_frames([PointFrame(xyz=xyz)], folder, RecordingInfo(name, name, 1.0))
    with closing(Workspace(with_labels(Settings(workspace=place)))) as opened:
        opened.labels.taxonomy.put([Category(10, "car")])
        for name, kinds in (("one", ("car", "pole")), ("two", ("pole", "person"))):
            label = np.zeros(40, np.uint16)
            for k, kind in enumerate(kinds):
                made = opened.labels.create_label(name, "ann", name=f"{kind} 1", category=kind)
                label[20 * k : 20 * k + 20] = made.id
            opened.annotations.put(name, 0, label, author="ann")
        yield opened


def classes(workspace: Workspace, sequence: str, kind: str, out: Path) -> dict[str, int]:
    workspace.export(sequence, kind, out)
    told: dict[str, int] = json.loads((out / "classes.json").read_text())
    return told


@pytest.mark.parametrize("kind", sorted(k for k, made in EXPORTS.items() if not made.pictures))
def test_recordings_agree_and_a_deleted_label_moves_nothing(
    workspace: Workspace, tmp_path: Path, kind: str
) -> None:
    first = classes(workspace, "one", kind, tmp_path / "first")
    second = classes(workspace, "two", kind, tmp_path / "second")
    assert first["pole"] == second["pole"]
    assert len({*first.values(), *second.values()}) == 3
    workspace.labels.delete_label("one", "ann", workspace.labels.palette("one")[0].id)
    again = classes(workspace, "one", kind, tmp_path / "again")
    assert again == {"pole": first["pole"]}


def test_las_keeps_the_classes_of_asprs_to_themselves(workspace: Workspace, tmp_path: Path) -> None:
    numbers = classes(workspace, "one", "las", tmp_path / "out")
    assert all(64 <= number <= 255 for number in numbers.values())
    written = laspy.read(tmp_path / "out" / "000000.las").classification
    assert set(np.asarray(written).tolist()) == set(numbers.values())
