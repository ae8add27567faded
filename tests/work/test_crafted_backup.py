"""Backups made by an attacker: refused in words, and nothing outside the workspace is touched."""

from __future__ import annotations

import json
import os
import shutil
import socket
import sqlite3
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from pointbrush.cli import main
from pointbrush.labels.recordings import KEPT_SECONDS
from pointbrush.sequences.storage.manifest import checksum
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.serving import add_sequence, settings_in

Craft = Callable[[Path, Path], object]
"""Change a backup; the second path is a folder of others."""
FRAME = Path("sequences", "ball", "frames", "000000.points")
MANIFEST = Path("sequences", "ball", "manifest.json")
SPARSE_BYTES = 1 << 43


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sound backup of one recording."""
    folder = tmp_path_factory.mktemp("made")
    settings = settings_in(folder)
    add_sequence(settings, "ball", frames=2, points=300)
    with closing(Workspace(settings)) as workspace:
        workspace.labels.create_label("ball", "ada", name="pin")
        workspace.back_up(folder / "backup")
    return folder / "backup"


@pytest.fixture
def others(tmp_path: Path) -> Path:
    """A folder outside of everything, with a file."""
    folder = tmp_path / "others"
    folder.mkdir()
    (folder / "kept.txt").write_text("not yours")
    return folder


def replaced(make: Callable[[Path, Path], object]) -> Craft:
    """Put something else in the place of a frame's file."""

    def craft(backup: Path, others: Path) -> None:
        (backup / FRAME).unlink()
        make(backup / FRAME, others)

    return craft


def bind(path: Path, _: Path) -> None:
    folder = os.open(path.parent, os.O_RDONLY)
    with socket.socket(socket.AF_UNIX) as unix:
        unix.bind(f"/proc/self/fd/{folder}/{path.name}")
    os.close(folder)


def link_part(backup: Path, others: Path) -> None:
    shutil.rmtree(backup / "classifiers", ignore_errors=True)
    (backup / "classifiers").symlink_to(others)


LINKS: dict[str, Craft] = {
    "a link to a file": replaced(lambda path, others: path.symlink_to(others / "kept.txt")),
    "a link to an endless device": replaced(lambda path, _: path.symlink_to("/dev/zero")),
    "a link to its own folder": replaced(lambda path, _: path.symlink_to(".")),
    "a pipe": replaced(lambda path, _: os.mkfifo(path)),
    "a socket": replaced(bind),
    "a link in place of a part": link_part,
}


def craft_in(made: Path, others: Path, tmp_path: Path, craft: Craft) -> Path:
    backup = tmp_path / "backup"
    shutil.copytree(made, backup)
    craft(backup, others)
    return backup


def require_untouched(others: Path) -> None:
    assert {path.name: path.read_text() for path in others.iterdir()} == {"kept.txt": "not yours"}


def refusal(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    capsys.readouterr()
    assert main([str(each) for each in arguments]) == 1
    return capsys.readouterr().err


@pytest.mark.parametrize("craft", LINKS.values(), ids=LINKS)
def test_only_plain_files_are_restored(
    made: Path, others: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], craft: Craft
) -> None:
    backup, target = craft_in(made, others, tmp_path, craft), tmp_path / "workspace"
    said = refusal(capsys, "restore", backup, "--workspace", target)
    assert "expected folders and files, got a link or a special file" in said
    assert not target.exists()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["backup", "others"]
    require_untouched(others)


def test_files_larger_than_the_disk_are_not_begun(
    made: Path, others: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        backup = craft_in(
            made, others, tmp_path, lambda backup, _: os.truncate(backup / FRAME, SPARSE_BYTES)
        )
    except OSError:
        pytest.skip("the disk has no files of this size")
    target = tmp_path / "workspace"
    assert "the disk has" in refusal(capsys, "restore", backup, "--workspace", target)
    assert not target.exists()


def set_id(backup: Path, name: str) -> None:
    """Name a recording of the database, which was deleted long ago, by a path."""
    gone = time.time() - 2 * KEPT_SECONDS
    with closing(sqlite3.connect(backup / "labels.sqlite")) as connection, connection:
        connection.execute("UPDATE sequences SET id = ?, deleted = ?, expired = 1", (name, gone))


@pytest.mark.parametrize("name", ["../../others", "{others}", "..", ".deleted"])
def test_ids_in_a_database_lead_nowhere_else(
    made: Path, others: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    name = name.format(others=others)
    backup = craft_in(made, others, tmp_path, lambda backup, _: set_id(backup, name))
    target = tmp_path / "workspace"
    said = refusal(capsys, "restore", backup, "--workspace", target)
    assert f"expected the id of a recording, got {name!r}" in said
    assert not target.exists()
    # A whole workspace from an attacker is opened as it is.
    for command in ("info", "check"):
        main([command, "--workspace", str(backup)])
        require_untouched(others)
    with closing(Workspace(Settings(workspace=backup, workers=1))) as workspace:
        workspace.deletion.deleted()
    require_untouched(others)
    assert (backup / "sequences" / "ball").is_dir()


WRONG: dict[str, dict[str, Any]] = {
    "id": {"id": "../../others"},
    "frames": {"frames": 10**9},
    "points": {"points": [10**15, -1]},
    "types": {"points": "many"},
    "room": {"room": [1.0]},
    "shift": {"shift": None},
    "nan": {"lo": [float("nan")] * 3},
}


def test_wrong_manifests_are_told(
    made: Path, others: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    backup = craft_in(made, others, tmp_path, lambda *_: None)
    target = tmp_path / "workspace"
    assert main(["restore", str(backup), "--workspace", str(target)]) == 0
    where = ("--workspace", target)
    sound = json.loads((backup / MANIFEST).read_text())
    for name, fields in WRONG.items():
        content = {key: value for key, value in (sound | fields).items() if key != "checksum"}
        content["checksum"] = checksum(content)
        (target / MANIFEST).write_text(json.dumps(content))
        assert "manifest.json" in refusal(capsys, "info", "ball", *where), name
    shutil.copy2(target / MANIFEST, backup / MANIFEST)
    assert main(["check", "--workspace", str(target)]) == 1
    assert "ball: " in capsys.readouterr().out
    assert "manifest.json" in refusal(capsys, "restore", backup, "--only", "ball", *where)
    assert "expected a recording" in refusal(capsys, "restore", backup, "--only", "..", *where)
    require_untouched(others)
