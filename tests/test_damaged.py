"""A damaged recording is listed with what is wrong, and keeps nothing else from working."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import httpx
import pytest

from pointbrush.cli import main
from pointbrush.errors import DamagedError
from pointbrush.settings import Settings
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
