"""Names that a Mac writes with separate accents (NFD) are those that Linux composes (NFC)."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unicodedata import normalize

import numpy as np
import pytest
from PIL import Image

from pointbrush.formats import open_source
from pointbrush.formats.tables.class_maps import parse_map
from pointbrush.labels.classes.taxonomy import Category
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.serving import with_labels
from tests.waiting import PATIENCE

SPELLINGS = [("NFD", "NFC"), ("NFC", "NFD")]
COUNT = 20
XYZ = np.random.default_rng(0).uniform(1, 9, (COUNT, 3)).astype(np.float32)


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    opened = Workspace(with_labels(Settings(workspace=tmp_path / "workspace")))
    yield opened
    opened.close()


def bring(workspace: Workspace, path: Path, **options: Any) -> str:
    done = workspace.runner.wait(workspace.imports.begin([path], **options).id, PATIENCE)
    assert done.state == "done", done.error
    return str(done.result["sequence"])


def labelled(workspace: Workspace, sequence: str, place: Path, **options: Any) -> None:
    job = workspace.imports.begin_labels(sequence, place, "ann", **options)
    done = workspace.runner.wait(job.id, PATIENCE)
    assert done.state == "done", done.error


@pytest.mark.parametrize(("mine", "theirs"), SPELLINGS)
def test_label_files_and_classes_are_matched_by_name(
    workspace: Workspace, tmp_path: Path, mine: str, theirs: str
) -> None:
    names = ["straße_é_1", "ü_點雲_2", "straße_é_3"]
    (tmp_path / "scan").mkdir()
    (tmp_path / "label").mkdir()
    for k, name in enumerate(names):
        np.save(tmp_path / "scan" / f"{normalize(mine, name)}.npy", XYZ)
        np.save(tmp_path / "label" / f"{normalize(theirs, name)}.npy", np.full(COUNT, k + 1, "u2"))
    (tmp_path / "label" / f"{normalize(theirs, names[2])}.npy").unlink()
    sequence = bring(workspace, tmp_path / "scan")
    workspace.labels.taxonomy.put([Category(7, normalize(mine, "Bäume"))])
    label = workspace.labels.create_label(
        sequence, "ann", name=normalize(mine, "Bäume"), category=normalize(mine, "Bäume")
    )
    classes = "".join(f"{k} {normalize(theirs, 'Bäume')}\n" for k in (1, 2))
    labelled(workspace, sequence, tmp_path / "label", names=parse_map("classes.txt", classes))
    for k, file in enumerate(workspace.recording(sequence).manifest.files):
        wanted = 0 if normalize("NFC", file).startswith(names[2]) else label.id
        assert set(workspace.annotations.read(sequence, k)[0].tolist()) == {wanted}
    assert [each.name for each in workspace.labels.palette(sequence)] == ["Bäume"]
    assert [each.name for each in workspace.labels.taxonomy.entries()] == ["Bäume"]


@pytest.mark.parametrize(("mine", "theirs"), SPELLINGS)
def test_objects_of_boxes_have_one_class(
    workspace: Workspace, tmp_path: Path, mine: str, theirs: str
) -> None:
    (tmp_path / "scan").mkdir()
    (tmp_path / "boxes").mkdir()
    psr = {
        "position": dict.fromkeys("xyz", 5.0),
        "scale": dict.fromkeys("xyz", 20.0),
        "rotation": dict.fromkeys("xyz", 0.0),
    }
    for k, form in enumerate((mine, theirs)):
        np.save(tmp_path / "scan" / f"{k}.npy", XYZ)
        box = {"obj_type": normalize(form, "Vélo"), "obj_id": "4", "psr": psr}
        (tmp_path / "boxes" / f"{k}.json").write_text(json.dumps([box]))
    sequence = bring(workspace, tmp_path / "scan")
    labelled(workspace, sequence, tmp_path / "boxes")
    (box,) = workspace.labels.boxes.listing(sequence).boxes
    assert sorted(box.poses) == [0, 1]
    assert [each.name for each in workspace.labels.palette(sequence)] == ["Vélo 4"]


@pytest.mark.parametrize("form", ["NFC", "NFD"])
def test_recordings_have_one_name(workspace: Workspace, tmp_path: Path, form: str) -> None:
    path = tmp_path / f"{normalize(form, 'Mühle')}.npy"
    np.save(path, XYZ)
    sequence = bring(workspace, path)
    assert (sequence, workspace.recording(sequence).manifest.name) == ("m-hle", "Mühle")
    other = bring(workspace, path, name=normalize(form, "Schöner Ort"))
    assert (other, workspace.recording(other).manifest.name) == ("sch-ner-ort", "Schöner Ort")
    workspace.update_sequence(other, name=normalize(form, "Straße é"))
    assert workspace.recording(other).manifest.name == "Straße é"


@pytest.mark.parametrize(("mine", "theirs"), SPELLINGS)
def test_lists_name_the_files_of_an_archive(tmp_path: Path, mine: str, theirs: str) -> None:
    names = ["é_b", "é_a"]
    packed = tmp_path / "scan.zip"
    with zipfile.ZipFile(packed, "w") as archive:
        for name in names:
            archive.writestr(f"scan/{normalize(mine, name)}.xyz", "1 2 3\n4 5 6\n")
        times = "".join(f"{k}.5 {normalize(theirs, name)}.xyz\n" for k, name in enumerate(names))
        archive.writestr("scan/times.txt", times)
        pictures = [f"{normalize(theirs, name)}.png" for name in names]
        camera = {"cameras": [{"name": "front", "files": pictures}]}
        archive.writestr("scan/cameras.json", json.dumps(camera))
        for name in names:
            with archive.open(f"scan/{normalize(mine, name)}.png", "w") as file:
                Image.new("RGB", (4, 4)).save(file, "PNG")
    with open_source([packed]) as source:
        assert [frame.timestamp for frame in source.frames] == [0.5, 1.5]
        assert [normalize("NFC", origin.file)[:3] for origin in source.origins] == names
        assert source.pictures is not None
        assert [each.frame for each in source.pictures.pictures()] == [0, 1]


@pytest.mark.parametrize(("mine", "theirs"), SPELLINGS)
def test_labels_beside_records_and_images_of_a_list(tmp_path: Path, mine: str, theirs: str) -> None:
    scan = tmp_path / "scan" / f"{normalize(mine, 'é')}.bin"
    scan.parent.mkdir()
    scan.write_bytes(np.c_[XYZ, np.full(COUNT, 0.5)].astype("<f4").tobytes())
    np.full(COUNT, 40, "<u4").tofile(scan.with_name(f"{normalize(theirs, 'é')}.label"))
    (frame,) = open_source([scan.parent]).frames
    assert frame.label is not None
    assert set(frame.label.tolist()) == {40}
    room = tmp_path / "room"
    for kind, mode in (("depth", "I;16"), ("rgb", "RGB")):
        (room / kind).mkdir(parents=True)
        image = Image.new(mode, (640, 480), 1000 if kind == "depth" else (9, 9, 9))
        image.save(room / kind / f"{normalize(mine, 'é')}.png")
        (room / f"{kind}.txt").write_text(f"0.5 {kind}/{normalize(theirs, 'é')}.png\n")
    (frame,) = open_source([room]).frames
    assert len(frame) == 640 * 480
