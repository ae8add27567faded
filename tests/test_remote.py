"""Commands on the workspace of a server: the same lines as on one of this machine."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterator
from inspect import isfunction, signature
from pathlib import Path

import numpy as np
import pytest

from pointbrush import remote
from pointbrush.cli import main
from pointbrush.client import Client
from pointbrush.settings import REMOTE
from tests.serving import TOKEN, Served, serving, settings_in


@pytest.fixture
def served(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Served]:
    monkeypatch.setenv("POINTBRUSH_WORKSPACE", str(tmp_path / "here"))
    with serving(settings_in(tmp_path / "there")) as running:
        yield running


def drift(folder: Path) -> Path:
    folder.mkdir()
    cube = np.random.default_rng(0).uniform(-0.1, 0.1, (2000, 3))
    for i in range(3):
        np.save(folder / f"{i}.npy", (cube + [0.01 * i, 0, 2]).astype(np.float32))
    return folder


def test_the_whole_way_on_a_server(
    served: Served,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setenv("POINTBRUSH_SERVER", served.url)
    monkeypatch.setenv("POINTBRUSH_TOKEN", TOKEN)

    def run(*arguments: object) -> str:
        assert main([str(argument) for argument in arguments]) == 0, capsys.readouterr().err
        return capsys.readouterr().out

    folder = drift(tmp_path / "drift")
    assert "frames     3, by number" in run("import", folder, "--dry-run")
    assert run("info") == ""
    assert run("import", folder, "--fps", "5") == "imported drift: 3 frames, 6,000 points\n"
    assert run("info").startswith("drift\t3 frames\t5 fps\t6,000 points")
    np.full(2000, 40, "<u4").tofile(tmp_path / "000000.label")
    named = tmp_path / "names.txt"
    named.write_text("40 cube\n")
    labels = ("import-labels", "drift", tmp_path / "000000.label", "--map", named)
    assert "found 2,000 labelled points in 1 of 3 frames" in run(*labels, "--dry-run")
    assert "imported 2,000" in run(*labels)
    assert "cube" in run("info", "drift")
    tracked = run("track", "drift", "--from", 0, "--to", 2, "--labels", "cube", "--method", "icp")
    assert tracked.startswith("tracked 3 frames, 4,000 points")
    run("export", "drift", "--format", "semantickitti", "--out", tmp_path / "out")
    assert len(list((tmp_path / "out").rglob("*.label"))) == 3
    run("export", "drift", "--format", "npz", "--out", tmp_path / "out.zip", "--frames", "0:1")
    assert (tmp_path / "out.zip").read_bytes().startswith(b"PK")
    with Client(served.url, TOKEN) as client:
        client.projects["default"].snapshot("As imported")
        client["drift"].frames[1].clear([label.id for label in client["drift"].labels()])
    was = ("export", "drift", "--format", "npz", "--frames", "1:2", "--out")
    run(*was, tmp_path / "now.zip")
    run(*was, tmp_path / "then", "--snapshot", "As imported")
    run(*was, tmp_path / "then.zip", "--snapshot", "as-imported")
    then = dict(np.load(next((tmp_path / "then").rglob("*.npz"))))
    assert then["label"].any()
    with (
        zipfile.ZipFile(tmp_path / "now.zip") as now,
        zipfile.ZipFile(tmp_path / "then.zip") as old,
    ):
        name = next(each for each in now.namelist() if each.endswith(".npz"))
        assert not np.load(io.BytesIO(now.read(name)))["label"].any()
        assert np.array_equal(np.load(io.BytesIO(old.read(name)))["label"], then["label"])
    training = ("export", "drift", "--format", "pointcept", "--out", tmp_path / "training")
    run(*training, "--val", "2:3")
    assert len(list((tmp_path / "training" / "val").iterdir())) == 1
    assert run("report", "drift", "--out", tmp_path / "drift.html").startswith("wrote")
    assert "suspicious" in run("check-labels", "drift")
    assert "source     drift\n" in run("info", "drift"), "no path of the server's"
    assert run("labels", "drift").split("\t")[2] == "cube"
    run("rename", "drift", "Drifting cube")
    assert json.loads(run("info", "--json"))[0]["name"] == "Drifting cube"
    run("delete", "drift")
    assert run("info") == ""
    assert run("undelete", "drift") == "drift is back\n"
    assert not (tmp_path / "here").exists()


def test_every_command_that_works_on_a_server_can_be_told_its_address() -> None:
    made = {
        name.removesuffix("_").replace("_", "-")
        for name, each in vars(remote).items()
        if isfunction(each) and [*signature(each).parameters] == ["given", "settings"]
    }
    assert made == set(REMOTE)


def test_what_is_wrong_is_one_line(
    served: Served, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    printed = f"{served.url}/?token={TOKEN}"
    with Client(served.url, TOKEN) as client:
        client.import_files([drift(tmp_path / "drift")])
    assert main(["info", "--server", printed]) == 0
    full = tmp_path / "full"
    full.mkdir()
    (full / "kept").write_text("mine")
    export = ["export", "drift", "--format", "npz", "--out", str(full)]
    wrong = {
        "expected one for the server": ["info", "--server", served.url],
        "expected http": ["info", "--server", "example"],
        "nothing": ["info", "nothing", "--server", printed],
        "new or empty": [*export, "--server", printed],
        "names or ids": [
            *("track", "drift", "--from", "0", "--to", "1"),
            *("--labels", "cube", "--server", printed),
        ],
    }
    for sentence, arguments in wrong.items():
        assert main(arguments) == 1
        error = capsys.readouterr().err
        assert (error.count("\n"), sentence in error) == (1, True), error
    assert (full / "kept").read_text() == "mine"
