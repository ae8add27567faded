"""Labels made elsewhere come in as one edit; what pointbrush exports comes in again."""

from __future__ import annotations

import json
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pointbrush.formats.tables.class_maps import parse_map
from pointbrush.formats.tables.datasets import ClassName
from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.serving import with_labels
from tests.waiting import PATIENCE

COUNTS = (40, 50, 60)
START = 1532402927.647951
"""Seconds of the first frame."""
IMPORTED = 3


def xyz(frame: int) -> np.ndarray:
    return np.random.default_rng(frame).uniform(-5, 5, (COUNTS[frame], 3)).astype(np.float32)


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    for name in ("drive", "again", "boston"):
        import_frames(
            (PointFrame(xyz(k), timestamp=START + k / 2) for k in range(3)),
            tmp_path / "ws" / "sequences" / name,
            RecordingInfo(name, name, 10.0),
        )
    opened = Workspace(with_labels(Settings(workspace=tmp_path / "ws")))
    yield opened
    opened.close()


def run(workspace: Workspace, place: Path, sequence: str = "drive", **options: Any) -> Any:
    job = workspace.imports.begin_labels(sequence, place, "me", **options)
    return workspace.runner.wait(job.id, PATIENCE)


def labels(workspace: Workspace, frame: int, sequence: str = "drive") -> list[str]:
    """Name of each point's label, source order."""
    names = {0: ""} | {label.id: label.name for label in workspace.labels.palette(sequence)}
    values = workspace.labels.values(sequence, frame)
    made = np.zeros(COUNTS[frame], np.uint16)
    made[workspace.recording(sequence)[frame].source_index] = values.label
    return [names[int(value)] for value in made]


def kitti(folder: Path) -> Path:
    for k, count in enumerate(COUNTS):
        category = np.where(
            np.arange(count) % 3 == 0, 10, np.where(np.arange(count) % 3 == 1, 40, 0)
        )
        instance = np.where(category == 10, 7, 0)
        path = folder / "labels" / f"{k:06d}.label"
        path.parent.mkdir(parents=True, exist_ok=True)
        (category | instance << 16).astype("<u4").tofile(path)
    return folder


def test_semantickitti_comes_in_as_one_edit(workspace: Workspace, tmp_path: Path) -> None:
    job = run(workspace, kitti(tmp_path / "made"))
    assert job.state == "done", job.error
    assert job.result["labelled"] == sum(2 * count // 3 + (count % 3 > 0) for count in COUNTS)
    assert job.result["matched"] == 3
    assert job.result["unknown"] == job.result["unmatched"] == 0
    for frame in range(3):
        expected = ["car 7", "road", ""] * COUNTS[frame]
        assert labels(workspace, frame) == expected[: COUNTS[frame]]
        values = workspace.labels.values("drive", frame)
        assert (values.provenance[values.label > 0] == IMPORTED).all()
    car = next(label for label in workspace.labels.palette("drive") if label.name == "car 7")
    assert car.category == "car"
    workspace.labels.undo("drive", "me")
    assert set(labels(workspace, 0)) == {""}


def test_instances_that_no_label_can_have_are_told(workspace: Workspace, tmp_path: Path) -> None:
    instance = np.where(np.arange(COUNTS[0]) < 5, 70_000, 7)
    columns = np.column_stack([xyz(0), np.full(COUNTS[0], 3), instance])
    (tmp_path / "csv").mkdir()
    np.savetxt(
        tmp_path / "csv" / "0.csv", columns, delimiter=",", header="x,y,z,label,instance",
        comments="",
    )  # fmt: skip
    job = run(workspace, tmp_path / "csv", format="points")
    assert job.state == "done", job.error
    (warning,) = job.result["warnings"]
    assert "5 points of 1 other numbers (70000) have no instance" in warning
    assert labels(workspace, 0)[4:6] == ["class 3", "class 3 7"]


def test_labels_in_words_are_classes_by_name(workspace: Workspace, tmp_path: Path) -> None:
    folder = tmp_path / "csv"
    folder.mkdir()
    names = ["road", "car", "", "tree"]
    for k in range(2):
        rows = [f"{x},{y},{z},{names[(i + k) % 4]}" for i, (x, y, z) in enumerate(xyz(k).tolist())]
        (folder / f"{k}.csv").write_text("\n".join(["x,y,z,label", *rows, ""]))
    job = run(workspace, folder, format="points")
    assert job.state == "done", job.error
    assert labels(workspace, 0)[:5] == ["road", "car", "", "tree", "road"]
    assert labels(workspace, 1)[:5] == ["car", "", "tree", "road", "car"]
    # The recording itself comes with them.
    job = workspace.imports.begin([folder], name="words")
    job = workspace.runner.wait(job.id, 60)
    assert job.state == "done", job.error
    palette = workspace.labels.palette("words")
    assert [(label.name, label.category) for label in palette] == [
        ("road", "road"), ("car", "car"), ("tree", "tree"),
    ]  # fmt: skip
    assert labels(workspace, 1, "words")[:5] == ["car", "", "tree", "road", "car"]
    workspace.update_sequence("words", name="Renamed")
    assert workspace.recording("words").manifest.classes == ["road", "car", "tree"]


def test_labels_in_an_archive_alone_or_uploaded(workspace: Workspace, tmp_path: Path) -> None:
    made = kitti(tmp_path / "made")
    packed = tmp_path / "uploaded" / "labels.zip"
    packed.parent.mkdir()
    with zipfile.ZipFile(packed, "w") as archive:
        for path in sorted(made.rglob("*.label")):
            archive.write(path, f"sequences/04/labels/{path.name}")
    temporary = set(Path(tempfile.gettempdir()).glob("pointbrush-*"))
    for place in (packed, packed.parent):
        job = run(workspace, place)
        assert job.state == "done", job.error
        assert job.result["matched"] == 3
        assert labels(workspace, 1)[:3] == ["car 7", "road", ""]
        workspace.labels.undo("drive", "me")
    assert set(Path(tempfile.gettempdir()).glob("pointbrush-*")) <= temporary


def test_a_dry_run_tells_and_writes_nothing(workspace: Workspace, tmp_path: Path) -> None:
    job = run(workspace, kitti(tmp_path / "made"), dry_run=True)
    assert [told["points"] for told in job.result["frames"]] == [27, 34, 40]
    assert job.result["new_labels"] == ["car 7", "road"]
    assert job.result["edit"] is None
    assert workspace.labels.palette("drive") == []
    assert set(labels(workspace, 1)) == {""}


def test_an_import_that_labels_nothing_is_an_error_unless_it_is_allowed(
    workspace: Workspace, tmp_path: Path
) -> None:
    made = kitti(tmp_path / "made")
    for path in made.rglob("*.label"):
        path.write_bytes(bytes(path.stat().st_size))
    job = run(workspace, made)
    refused = "labels: expected some labelled points or boxes, got none in the 3 frames"
    assert job.state == "failed"
    assert refused in str(job.error)
    assert workspace.labels.revision("drive") == 0
    job = run(workspace, made, dry_run=True)
    assert job.state == "done"
    assert refused in job.result["warnings"][-1]
    assert job.result["refused"] == job.result["warnings"][-1]
    for dry_run in (True, False):
        job = run(workspace, made, allow_empty=True, dry_run=dry_run)
        assert (job.state, job.result["refused"], job.result["warnings"]) == ("done", "", [])
        assert (job.result["matched"], job.result["edit"]) == (3, None)


MANY = 65_535
"""One more than a palette has labels."""


def test_more_objects_than_labels_are_refused_before_they_are_sought(
    workspace: Workspace, tmp_path: Path
) -> None:
    np.save(tmp_path / "many.npy", np.random.default_rng(0).normal(0, 9, (MANY, 3)))
    assert workspace.runner.wait(workspace.imports.begin([tmp_path / "many.npy"]).id, PATIENCE)
    number = np.arange(MANY)
    points, boxes = tmp_path / "points", tmp_path / "boxes"
    points.mkdir()
    (number % 2 + 1 | number // 2 << 16).astype("<u4").tofile(points / "many.label")
    boxes.mkdir()
    psr = dict.fromkeys(("position", "scale", "rotation"), dict.fromkeys("xyz", 1.0))
    listed = [{"obj_type": "car", "obj_id": str(n + 1), "psr": psr} for n in number.tolist()]
    (boxes / "many.json").write_text(json.dumps(listed))
    for place in (points, boxes):
        job = run(workspace, place, "many")
        assert job.state == "failed"
        assert "expected at most 65,534 classes and objects, got 65,535" in str(job.error)
        assert workspace.labels.palette("many") == []


def test_nuscenes_labels(workspace: Workspace, tmp_path: Path) -> None:
    category = [np.arange(count) % 2 * 17 for count in COUNTS]
    names = {17: ClassName("car", "#ff9e00")}
    for kind, name in (("lidarseg", "car"), ("panoptic", "car 2")):
        folder = tmp_path / kind
        folder.mkdir()
        for k, numbers in enumerate(category):
            if kind == "lidarseg":
                numbers.astype(np.uint8).tofile(folder / f"{k}_lidarseg.bin")
            else:
                data = (numbers * 1000 + 2 * (numbers > 0)).astype(np.uint16)
                np.savez(folder / f"{k}_panoptic.npz", data=data)
        job = run(workspace, folder, names=names)
        assert job.state == "done", job.error
        assert labels(workspace, 2)[:4] == ["", name, "", name]
        told = run(workspace, folder, dry_run=True).result
        assert told["unknown_classes"] == []
        assert all("vehicle.car" in name for name in told["new_labels"])
    (tmp_path / "other").mkdir()
    for k, count in enumerate(COUNTS):
        np.full(count, 50, np.uint8).tofile(tmp_path / "other" / f"{k}_lidarseg.bin")
    told = run(workspace, tmp_path / "other", dry_run=True).result
    assert told["unknown_classes"] == [50]


def test_nuscenes_labels_named_by_tokens_are_of_the_frames_of_the_tables(
    workspace: Workspace, tmp_path: Path
) -> None:
    folder = tmp_path / "lidarseg" / "v1.0-mini"
    folder.mkdir(parents=True)
    tokens = {0: "c" * 32, 2: "a" * 32}  # whose natural order is not that of time
    for frame, token in tokens.items():
        np.full(COUNTS[frame], 17 + frame, np.uint8).tofile(folder / f"{token}_lidarseg.bin")
    job = run(workspace, folder, "boston", dry_run=True)
    assert job.state == "failed"
    assert "expected nuScenes' tables" in str(job.error)
    rows = [
        {"token": token, "timestamp": 1532402927647951 + frame * 500_000}
        for frame, token in tokens.items()
    ]
    (tmp_path / "v1.0-mini").mkdir()
    (tmp_path / "v1.0-mini" / "sample_data.json").write_text(json.dumps(rows))
    job = run(workspace, folder, "boston")
    assert job.state == "done", job.error
    assert [frame["frame"] for frame in job.result["frames"]] == [2, 0]
    assert set(labels(workspace, 0, "boston")) == {"vehicle.car"}
    assert set(labels(workspace, 2, "boston")) == {"vehicle.emergency.ambulance"}


def test_labels_are_a_field_that_is_named(workspace: Workspace, tmp_path: Path) -> None:
    for k, count in enumerate(COUNTS):
        table = np.column_stack([xyz(k), np.arange(count) % 3])
        rows = [f"{x:.4f},{y:.4f},{z:.4f},{plant:.0f}" for x, y, z, plant in table]
        (tmp_path / f"frame {k}.csv").write_text("\n".join(["x,y,z,plant", *rows]))
    job = run(workspace, tmp_path, field="stem")
    assert "expected columns of x, y, z, plant, got 'stem'" in str(job.error)
    job = run(workspace, tmp_path, field="plant")
    assert job.state == "done", job.error
    assert labels(workspace, 0)[:4] == ["", "class 1", "class 2", ""]


EXPORTED = ["ply", "pcd", "npz", "csv", "las", "semantickitti", "labels-only"]


def test_what_is_exported_comes_in_again(workspace: Workspace, tmp_path: Path) -> None:
    for number, name in enumerate(("pin 1", "pin 2"), start=1):
        workspace.labels.create_label("drive", "me", name=name, category="pin")
        for frame in range(3):
            for point in xyz(frame)[np.arange(COUNTS[frame]) % 4 == number]:
                samples = [{"origin": [float(v) for v in point]}]
                brush = {"label": number, "radius": 1e-4, "samples": samples}
                workspace.strokes.apply("drive", frame, brush, "me")
    for kind in EXPORTED:
        workspace.export("drive", kind, tmp_path / kind)
        job = run(workspace, tmp_path / kind, "again")
        assert job.state == "done", (kind, job.error)
        assert workspace.labels.palette("again") == workspace.labels.palette("drive")
        for frame in range(3):
            assert labels(workspace, frame, "again") == labels(workspace, frame), kind
        workspace.labels.undo("again", "me")
        assert set(labels(workspace, 0, "again")) == {""}


def test_counts_that_do_not_fit_name_file_and_frame(workspace: Workspace, tmp_path: Path) -> None:
    folder = kitti(tmp_path / "made")
    np.zeros(49, "<u4").tofile(folder / "labels" / "000001.label")
    job = run(workspace, folder)
    assert job.state == "failed"
    assert "000001.label: expected 50 labels, one for each point of frame 1, got 49" in job.error
    assert workspace.labels.palette("drive") == []


def test_files_are_matched_by_their_names_and_a_stranger_is_refused(
    workspace: Workspace, tmp_path: Path
) -> None:
    folder = kitti(tmp_path / "made")
    (folder / "labels" / "000000.label").rename(folder / "labels" / "000009.label")
    (folder / "labels" / "000001.label").unlink()
    job = run(workspace, folder)
    assert job.state == "failed"
    assert "1 of no frame: 000009.label" in job.error
    assert workspace.labels.palette("drive") == []
    (folder / "labels" / "000009.label").unlink()
    job = run(workspace, folder)
    assert job.result["files"] == [{"file": "000002.label", "frame": 2}]
    assert job.result["unmatched_frames"] == [0, 1]
    assert set(labels(workspace, 0)) == {""}
    assert "road" in labels(workspace, 2)


def test_a_locked_label_that_keeps_its_points_is_named(
    workspace: Workspace, tmp_path: Path
) -> None:
    kept = workspace.labels.create_label("drive", "me", name="kept").id
    label = workspace.annotations.read("drive", 0)[0]
    label[:] = kept
    workspace.annotations.put("drive", 0, label, author="me")
    workspace.labels.update_label("drive", "me", kept, locked=True)
    job = run(workspace, kitti(tmp_path / "made"))
    assert job.result["locked"] == ["kept"]
    assert 0 < job.result["changed"] < job.result["labelled"]
    assert set(labels(workspace, 0)) == {"kept"}


def test_maps_are_json_or_lines(tmp_path: Path) -> None:
    text = json.dumps({"3": "car", "4": {"name": "tree", "color": "#00ff00"}})
    assert parse_map("m", text) == {3: ClassName("car"), 4: ClassName("tree", "#00ff00")}
    assert parse_map("m", "# classes\n3: car\n4 tall tree\n") == {
        3: ClassName("car"),
        4: ClassName("tall tree"),
    }


def test_every_format_of_labels_has_a_reader_and_a_name() -> None:
    from pointbrush.formats.boxes.registry import BOX_READERS
    from pointbrush.formats.masks.registry import MASK_FORMATS
    from pointbrush.formats.point_labels import READERS
    from pointbrush.formats.tables.names import LABEL_FORMATS

    assert set(LABEL_FORMATS) == {*READERS, *BOX_READERS, *MASK_FORMATS}
