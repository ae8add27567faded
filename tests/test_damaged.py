"""A damaged recording is listed with what is wrong, and keeps nothing else from working."""

from __future__ import annotations

import io
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from pointbrush.classify.classifier import Classifier
from pointbrush.classify.forest import Trees
from pointbrush.cli import main
from pointbrush.errors import DamagedError
from pointbrush.selection.objects import ObjectState
from pointbrush.selection.objects.sums import PAIR_WIDTH, WIDTH
from pointbrush.selection.selectors.tree import TreeSelector
from pointbrush.settings import Settings
from pointbrush.work.classifiers.files import ClassifierFiles
from pointbrush.work.objects.preparing import StateFiles
from pointbrush.workspace import Workspace
from tests.serving import Served, add_sequence, serving, settings_in
from tests.streaming.acting import run
from tests.streaming.client import viewer

BROKEN = {
    "cut": "expected a manifest in JSON",
    "bare": "it has no manifest.json",
    "holes": "frames/000001.points",
    "gone": "labels without their recording",
    "moved": "its manifest.json is of 'whole'",
}


@pytest.fixture(scope="module")
def settings(tmp_path_factory: pytest.TempPathFactory) -> Settings:
    made = settings_in(tmp_path_factory.mktemp("damaged"))
    for name in ("whole", "cut", "bare", "holes", "gone"):
        add_sequence(made, name, frames=2, points=300)
    with closing(Workspace(made)) as workspace:
        for name in ("whole", "cut", "bare", "holes", "gone"):
            workspace.labels.create_label(name, "ada", name="pin")
    folder = made.workspace / "sequences"
    manifest = folder / "cut" / "manifest.json"
    manifest.write_bytes(manifest.read_bytes()[:200])
    (folder / "bare" / "manifest.json").unlink()
    (folder / "holes" / "frames" / "000001.points").unlink()
    shutil.rmtree(folder / "gone")
    shutil.copytree(folder / "whole", folder / "moved")
    return made


@pytest.fixture(scope="module")
def served(settings: Settings) -> Iterator[Served]:
    with serving(settings) as running:
        yield running


def test_it_is_listed_with_what_is_wrong(served: Served) -> None:
    with httpx.Client(base_url=f"{served.url}/api/v1", headers=served.headers) as api:
        listed = {entry["id"]: entry["damaged"] for entry in api.get("/sequences").json()}
        assert listed.pop("whole") is None
        assert listed.keys() == BROKEN.keys()
        for name, words in BROKEN.items():
            assert words in listed[name]
        for name in ("cut", "bare", "moved"):
            for call in ("", "/labels", "/frames/0/points"):
                answer = api.get(f"/sequences/{name}{call}")
                assert answer.status_code == 500, (name, call)
                assert "damaged" in answer.json()["detail"]
        assert api.get("/sequences/gone").status_code == 404
        assert api.get("/sequences/holes/frames/0/points").status_code == 200
        assert api.get("/sequences/holes/frames/1/points").json()["detail"]
        assert api.get("/sequences/whole/frames/1/points").status_code == 200


def test_the_socket_says_so_and_goes_on(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.hello()
            for name in ("cut", "bare", "gone"):
                await client.send(type="open", sequence=name, frame=0)
                assert (await client.until("error"))["detail"]
            await client.open("whole")

    run(scenario)


def test_check_names_it_and_checks_the_others(
    settings: Settings, capsys: pytest.CaptureFixture[str]
) -> None:
    where = ["--workspace", str(settings.workspace)]
    assert main(["check", *where]) == 1
    said = capsys.readouterr().out
    for name, words in BROKEN.items():
        assert any(line.startswith(f"{name}: ") and words in line for line in said.splitlines())
    assert "whole: " not in said
    assert main(["check", "whole", *where]) == 0
    assert main(["info", *where]) == 0
    said = capsys.readouterr().out
    for name, words in BROKEN.items():
        assert any(
            line.startswith(f"{name}\t") and "damaged: " in line and words in line
            for line in said.splitlines()
        )
    assert main(["info", "cut", *where]) == 1
    assert "damaged" in capsys.readouterr().err


def with_changed_number(name: str, arrays: dict[str, Any]) -> bytes:
    """Return an archive with the first number of an array changed, its checksums correct."""
    out = io.BytesIO()
    arrays[name].flat[0] = 2**31 - 1
    np.savez(out, **arrays)
    return out.getvalue()


def arrays_of(data: bytes) -> dict[str, Any]:
    with np.load(io.BytesIO(data)) as stored:
        return {name: stored[name].copy() for name in stored}


def test_check_finds_a_changed_number_in_classifiers_and_prepared_frames(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = settings_in(tmp_path)
    add_sequence(settings, "ball", frames=1, points=300)
    kept = ClassifierFiles(settings.workspace / "classifiers")
    trees = Trees(
        np.array([0, -1, -1], np.int16), np.zeros(3, np.float32), np.array([1, 0, 1], np.int32),
        np.zeros(1, np.int32), np.eye(2, dtype=np.float32),
    )  # fmt: skip
    kept.write("whole", Classifier("whole", ("a", "b"), 0.5, trees=trees))
    states = StateFiles(settings.workspace / "objects", 0)
    for frame in range(2):
        path = states.path("identity", "tree", TreeSelector.version, frame)
        assert states.write(path, object_state().save)
    where = ["--workspace", str(settings.workspace)]
    assert main(["check", *where]) == 0
    path.write_bytes(with_changed_number("piece", arrays_of(path.read_bytes())))
    whole = (settings.workspace / "classifiers" / "whole.npz").read_bytes()
    changed = with_changed_number("left", arrays_of(whole))
    (settings.workspace / "classifiers" / "changed.npz").write_bytes(changed)
    capsys.readouterr()
    assert main(["check", *where]) == 1
    said = capsys.readouterr().out.splitlines()
    assert len(said) == 2
    assert said[0].startswith("classifiers/changed.npz: classifier: expected left from 0")
    assert said[1].startswith("objects/identity/")
    assert "000001.npz: expected a saved object state: expected piece from 0 to 0" in said[1]
    assert main(["check", "--repair", *where]) == 1
    assert "removed, to be prepared again: objects/identity/" in capsys.readouterr().out
    assert not path.exists()
    assert main(["check", *where]) == 1
    kept.delete("changed")
    assert main(["check", *where]) == 0


def object_state() -> ObjectState:
    """Return the state of a frame of one cell."""
    return ObjectState(
        "room", 0.1, np.zeros(5, np.int32), np.zeros((1, 3), np.float32), np.zeros(1, np.int32),
        np.empty((0, 2), np.int32), np.empty((0, PAIR_WIDTH), np.float32), np.full(1, -1, np.int32),
        np.full(1, np.inf, np.float32), np.zeros((1, WIDTH)), np.empty(0, np.float32),
        np.zeros(3), np.full((1, 1), -1, np.int32),
    )  # fmt: skip


def test_check_and_repair_name_what_cannot_even_be_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = settings_in(tmp_path)
    for name in ("ball", "cone"):
        add_sequence(settings, name, frames=1, points=300)
    stroke = {"label": 1, "radius": 0.5, "samples": [{"origin": [0.0, 0.0, 3.0]}]}
    with closing(Workspace(settings)) as workspace:
        workspace.labels.create_label("ball", "ada", name="pin")
        workspace.strokes.apply("ball", 0, stroke, "ada")
        painted = workspace.labels.counts("ball")
    where = ["--workspace", str(settings.workspace)]
    labels = settings.workspace / "labels.sqlite"
    with closing(sqlite3.connect(labels)) as connection, connection:
        connection.execute("UPDATE counts SET label = x'6162'")
    assert main(["check", *where]) == 1
    assert "ball: counts: frame 0, label b'ab'" in capsys.readouterr().out
    for name in ("manifest.json", "checksums.json"):
        file = settings.workspace / "sequences" / "cone" / name
        file.rename(tmp_path / name)
        file.mkdir()
        for flags in ([], ["--repair"]):
            assert main(["check", *where, *flags]) == 1
            assert name in capsys.readouterr().out
        file.rmdir()
        (tmp_path / name).rename(file)
    assert main(["check", *where]) == 0
    with closing(Workspace(settings)) as workspace:
        assert workspace.labels.counts("ball") == painted
    labels.write_bytes(b"")
    for command in (["info"], ["check", "--repair"]):
        assert main([*command, *where]) == 1
        assert "labels.sqlite is empty beside 2 recordings" in capsys.readouterr().err
    assert labels.read_bytes() == b""


def test_it_can_be_deleted_and_comes_back_as_it_was(tmp_path: Path) -> None:
    settings = settings_in(tmp_path)
    add_sequence(settings, "ball", frames=1, points=300)
    manifest = settings.workspace / "sequences" / "ball" / "manifest.json"
    whole = manifest.read_bytes()
    manifest.write_bytes(whole[:99])
    with closing(Workspace(settings)) as workspace:
        workspace.deletion.delete("ball")
        assert workspace.listing.all() == []
        with pytest.raises(DamagedError, match="damaged"):
            workspace.recording(workspace.deletion.restore("ball"))
        manifest.write_bytes(whole)
        assert workspace.recording("ball").manifest.frames == 1


def test_labels_of_the_first_version_with_other_frames_are_set_aside(tmp_path: Path) -> None:
    settings = settings_in(tmp_path)
    with closing(Workspace(settings)) as workspace:
        workspace.labels.recordings.register("ball", [7, 7])
        workspace.labels.create_label("ball", "ada", name="old")
    add_sequence(settings, "ball", frames=1, points=300)
    with closing(Workspace(settings)) as workspace:
        assert workspace.labels.palette("ball") == []
        listed = {entry.id: entry.damaged for entry in workspace.listing.all()}
        assert listed.pop("ball") is None
        assert [damaged is not None for damaged in listed.values()] == [True]
