"""SemanticKITTI in, some points painted, out: nothing else differs, bit for bit."""

from __future__ import annotations

import shutil
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from pointbrush.formats.tables.class_maps import parse_map
from pointbrush.formats.tables.datasets import SEMANTIC_KITTI
from pointbrush.labels import Category
from pointbrush.settings import Settings
from pointbrush.work.palettes import add_template
from pointbrush.workspace import Workspace
from tests.waiting import PATIENCE

POINTS = 500


def drive(folder: Path, frames: int = 2) -> Path:
    """Scans with roads, cars 3 and 7, a moving person and points that nobody labelled."""
    rng = np.random.default_rng(0)
    for name in ("velodyne", "labels"):
        (folder / "sequences" / "04" / name).mkdir(parents=True)
    for i in range(frames):
        scan = rng.uniform(-20, 20, (POINTS, 4)).astype("<f4")
        scan[:, 3] = rng.uniform(0, 1, POINTS)
        kind = rng.choice([0, 40, 10, 254, 99], POINTS).astype("<u4")
        instance = np.where(np.isin(kind, (10, 254)), rng.choice([3, 7], POINTS), 0).astype("<u4")
        (folder / "sequences/04/velodyne" / f"{i:06d}.bin").write_bytes(scan.tobytes())
        (folder / "sequences/04/labels" / f"{i:06d}.label").write_bytes(
            (kind | instance << 16).tobytes()
        )
    return folder / "sequences" / "04"


def packed(folder: Path, frame: int) -> np.ndarray:
    path = next(folder.rglob(f"{frame:06d}.label"))
    return np.frombuffer(path.read_bytes(), "<u4")


def opened(tmp_path: Path, name: str = "w") -> Workspace:
    return Workspace(Settings.load({"workspace": tmp_path / name}, {}))


def import_path(workspace: Workspace, path: Path) -> str:
    job = workspace.runner.wait(workspace.imports.begin([path]).id, PATIENCE)
    assert job.state == "done", job.error
    assert job.result is not None
    return str(job.result["sequence"])


@pytest.mark.parametrize("way", ["with the scans", "as labels"])
def test_files_differ_in_the_points_that_were_painted_alone(tmp_path: Path, way: str) -> None:
    source = drive(tmp_path / "kitti")
    labels = source / "labels"
    if way == "as labels":
        labels = labels.rename(tmp_path / "labels")
    with closing(opened(tmp_path)) as workspace:
        sequence = import_path(workspace, source)
        if way == "as labels":
            job = workspace.runner.wait(
                workspace.imports.begin_labels(sequence, labels, "ann").id, PATIENCE
            )
            assert job.state == "done", job.error
        car = workspace.labels.create_label(sequence, "ann", name="my car", category="car")
        workspace.export(sequence, "semantickitti", tmp_path / "before")
        painted = np.arange(20, 60)
        array = workspace.annotations.read(sequence, 1)[0].copy()
        array[painted] = car.id
        workspace.annotations.put(sequence, 1, array, author="ann")
        workspace.export(sequence, "semantickitti", tmp_path / "after")
    for frame in range(2):
        np.testing.assert_array_equal(packed(tmp_path / "before", frame), packed(labels, frame))
    np.testing.assert_array_equal(packed(tmp_path / "after", 0), packed(labels, 0))
    differs = np.flatnonzero(packed(tmp_path / "after", 1) != packed(labels, 1))
    assert set(differs.tolist()) == set(painted.tolist())
    new = packed(tmp_path / "after", 1)[painted]
    assert set((new & 0xFFFF).tolist()) == {10}
    (instance,) = set((new >> 16).tolist())
    assert instance not in (0, 3, 7)
    with closing(opened(tmp_path, "again")) as workspace:
        sequence = import_path(workspace, tmp_path / "after")
        names = {label.id: label for label in workspace.labels.palette(sequence)}
        found = workspace.annotations.read(sequence, 1)[0]
        assert {names[n].name for n in np.unique(found[painted]).tolist()} == {"my car"}
        workspace.export(sequence, "semantickitti", tmp_path / "twice")
    np.testing.assert_array_equal(packed(tmp_path / "twice", 1), packed(tmp_path / "after", 1))


def test_labels_beside_scans_become_the_labels_that_an_import_of_them_alone_makes(
    tmp_path: Path,
) -> None:
    source = drive(tmp_path / "kitti")
    made = {}
    with closing(opened(tmp_path)) as workspace:
        beside = import_path(workspace, source)
        labels = (source / "labels").rename(tmp_path / "labels")
        alone = import_path(workspace, source)
        job = workspace.runner.wait(
            workspace.imports.begin_labels(alone, labels, "ann").id, PATIENCE
        )
        assert job.state == "done", job.error
        for sequence in (beside, alone):
            palette = workspace.labels.palette(sequence)
            points = [workspace.annotations.read(sequence, frame)[0] for frame in range(2)]
            made[sequence] = palette, np.stack(points).tolist()
    assert made[beside] == made[alone]
    palette, _ = made[beside]
    cars = {label.name for label in palette if label.category == "car"}
    assert cars == {"car 3", "car 7"}


@pytest.mark.parametrize("way", ["a flat folder", "a zip", "a zip of a flat folder"])
def test_scans_with_label_files_have_the_classes_names_wherever_they_lie(
    tmp_path: Path, way: str
) -> None:
    source = drive(tmp_path / "kitti", 1)
    if "flat" in way:
        flat = tmp_path / "flat"
        flat.mkdir()
        for path in sorted(source.rglob("*.*")):
            path.rename(flat / path.name)
        source = flat
    if "zip" in way:
        source = Path(shutil.make_archive(str(tmp_path / "packed"), "zip", source))
    with closing(opened(tmp_path)) as workspace:
        palette = workspace.labels.palette(import_path(workspace, source))
    assert {"road", "car 3", "car 7"} <= {label.name for label in palette}


def test_a_folder_of_point_labeler_has_the_classes_of_its_xml(tmp_path: Path) -> None:
    """src/widget/KittiReader.cpp: labels/ beside velodyne/, a uint32 a point, made as scans are
    looked at; src/data/label_utils.cpp: id and name of each label of labels.xml."""
    source = drive(tmp_path / "yard")
    labels = (source / "labels").rename(tmp_path / "labels")
    (labels / "000000.label").unlink()
    (source / "calib.txt").write_text("Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n")
    (source / "poses.txt").write_text("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 2 0 1 0 0 0 0 1 0\n")
    classes = "".join(
        f"<label><id>{number}</id><name>{name}</name><color>0 90 200</color></label>"
        for number, name in ((10, "lorry"), (40, "yard"))
    )
    with closing(opened(tmp_path)) as workspace:
        sequence = import_path(workspace, source)
        labels.rename(source / "labels")
        job = workspace.imports.begin_labels(
            sequence, source, "ann", names=parse_map("labels.xml", f"<config>{classes}</config>")
        )
        done = workspace.runner.wait(job.id, PATIENCE)
        assert done.state == "done", done.error
        assert done.result["files"] == [{"file": "000001.label", "frame": 1}]
        names = {label.id: label.name for label in workspace.labels.palette(sequence)}
        found = [names.get(n, "") for n in workspace.annotations.read(sequence, 1)[0].tolist()]
    kind = packed(source / "labels", 1)
    for name, number in (("yard", 40), ("lorry 3", 10 | 3 << 16), ("lorry 7", 10 | 7 << 16)):
        assert [each == name for each in found] == (kind == number).tolist()


def test_categories_keep_their_number_in_a_dataset_and_in_the_workspace(tmp_path: Path) -> None:
    source = drive(tmp_path / "kitti", 1)
    with closing(opened(tmp_path)) as workspace:
        workspace.labels.taxonomy.put([Category(10, "juggler")])
        sequence = import_path(workspace, source)
        known = {entry.name: entry for entry in workspace.labels.taxonomy.entries()}
        assert known["car"].datasets == {"semantickitti": 10}
        assert (known["road"].number, known["road"].datasets["semantickitti"]) == (40, 40)
        assert known["car"].number != 10
        workspace.labels.create_label(sequence, "ann", name="Ada", category="juggler")
        workspace.export(sequence, "npz", tmp_path / "npz")
    arrays = np.load(tmp_path / "npz" / "000000.npz")
    assert known["car"].number in arrays["category"]


def test_a_category_of_another_place_does_not_take_a_number_of_the_dataset(tmp_path: Path) -> None:
    source = drive(tmp_path / "kitti", 1)
    with closing(opened(tmp_path)) as workspace:
        workspace.labels.taxonomy.put([Category(10, "juggler")])
        sequence = import_path(workspace, source)
        juggler = workspace.labels.create_label(sequence, "ann", name="Ada", category="juggler")
        array = workspace.annotations.read(sequence, 0)[0].copy()
        array[:5] = juggler.id
        workspace.annotations.put(sequence, 0, array, author="ann")
        workspace.export(sequence, "semantickitti", tmp_path / "out")
    (kind,) = set((packed(tmp_path / "out", 0)[:5] & 0xFFFF).tolist())
    assert kind not in set((packed(source / "labels", 0) & 0xFFFF).tolist())


def test_what_comes_in_after_a_class_was_renamed_is_of_that_class(tmp_path: Path) -> None:
    source = drive(tmp_path / "kitti", 1)
    with closing(opened(tmp_path)) as workspace:
        first = import_path(workspace, source)
        workspace.export(first, "ply", tmp_path / "own")
        car = workspace.labels.taxonomy.numbers(["car"])["car"]
        workspace.labels.taxonomy.put([Category(car, "vehicle")])
        for labels in (tmp_path / "own", source / "labels"):
            if labels.name == "labels":  # whose numbers count, though the old name is another's now
                workspace.labels.taxonomy.put([Category(900, "car")])
            job = workspace.runner.wait(
                workspace.imports.begin_labels(first, labels, "ann").id, PATIENCE
            )
            assert job.state == "done", job.error
            assert job.result["new_labels"] == []
        workspace.labels.taxonomy.put([Category(900, "truck")])
        workspace.labels.taxonomy.put([Category(car, "Auto")])
        second = import_path(workspace, source)
        add_template(workspace.labels, second, SEMANTIC_KITTI, "ann")
        palette = {label.name: label.category for label in workspace.labels.palette(second)}
        assert (palette["car 3"], palette["car"], palette["truck"]) == ("Auto", "Auto", "truck")
        workspace.export(second, "semantickitti", tmp_path / "out")
    np.testing.assert_array_equal(packed(tmp_path / "out", 0), packed(source / "labels", 0))
