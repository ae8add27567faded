"""Labels that move between databases and come out of backups, with all of their history."""

from __future__ import annotations

import time
import uuid
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from pointbrush.cli import main
from pointbrush.database.backup import restore_sequence
from pointbrush.errors import NotFoundError
from pointbrush.settings import Settings
from pointbrush.work.backups.backup import make_backup
from pointbrush.work.imports.uploads import Uploads
from pointbrush.workspace import Workspace
from tests import forked
from tests.serving import add_sequence, settings_in
from tests.waiting import PATIENCE


@pytest.fixture
def settings(tmp_path: Path) -> Settings:
    found = settings_in(tmp_path)
    add_sequence(found, "wall", frames=2, points=2_000)
    add_sequence(found, "floor", frames=1, points=1_000)
    return found


@pytest.fixture(params=["sqlite", "postgresql"])
def painted(request: pytest.FixtureRequest, settings: Settings) -> Settings:
    """A workspace with work in it, in either database."""
    if request.param == "postgresql":
        url = request.getfixturevalue("postgres_server").new_database()
        settings = replace(settings, database=url)
    paint(settings)
    return settings


def paint(settings: Settings) -> None:
    with closing(Workspace(settings)) as workspace:
        for sequence in ("wall", "floor"):
            workspace.labels.create_label(sequence, "ann", name="pin")
            for x in (0.0, 0.5, 1.0):
                stroke = {"id": str(uuid.uuid4()), "label": 1, "radius": 0.3}
                sample = {"origin": [x, 0, 3]}
                workspace.strokes.apply(sequence, 0, stroke | {"samples": [sample]}, "ann")
        workspace.labels.undo("wall", "ann")


def state(settings: Settings, sequence: str = "wall") -> dict[str, Any]:
    with closing(Workspace(settings)) as workspace:
        assert workspace.listing.problems(sequence) == []
        return {
            "label": workspace.annotations.read(sequence, 0)[0].tolist(),
            "edits": workspace.labels.edits(sequence),
            "palette": workspace.labels.palette(sequence),
            "tracks": workspace.labels.tracks(sequence),
        }


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


def test_labels_move_to_postgres_and_back(
    settings: Settings,
    postgres_url: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    paint(settings)
    before, here = state(settings), ("--workspace", settings.workspace)
    there = replace(settings, database=postgres_url)
    assert run("move", postgres_url, *here) == 0
    assert f"--database {postgres_url}" in capsys.readouterr().out
    assert state(there) == before
    assert run("info", *here) == 1
    assert f"start with --database {postgres_url}" in capsys.readouterr().err
    with closing(Workspace(there)) as workspace:
        workspace.labels.redo("wall", "ann")
        workspace.labels.recordings.register("another", [5])
    after = state(there)
    assert run("move", "sqlite", *here, "--database", postgres_url) == 0
    assert state(settings) == after
    assert run("info", *here, "--database", postgres_url) == 1
    # What was moved from is not emptied, so it is no target.
    assert run("move", postgres_url, *here) == 1
    assert "expected an empty database" in capsys.readouterr().err
    assert state(settings) == after


def test_a_backup_comes_back_into_another_database(
    painted: Settings,
    tmp_path: Path,
    postgres_url: str,
) -> None:
    before, copy, new = state(painted), tmp_path / "copy", tmp_path / "new"
    database = ("--database", painted.database) if painted.database else ()
    assert run("backup", copy, "--workspace", painted.workspace, *database) == 0
    assert run("restore", copy, "--workspace", new, "--database", postgres_url) == 0
    assert state(replace(painted, workspace=new, database=postgres_url)) == before
    other = tmp_path / "other"
    assert run("restore", copy, "--workspace", other, "--database", postgres_url) == 1
    assert not other.exists()


def test_one_recording_comes_back_into_a_workspace_in_use(
    painted: Settings, tmp_path: Path
) -> None:
    before, copy = state(painted), tmp_path / "copy"
    with closing(Workspace(painted)) as workspace:
        make_backup(workspace.labels, workspace.library, copy)
        kept = workspace.annotations.read("floor", 0)[0].tolist()
        workspace.labels.undo("wall", "ann")
        restored = workspace.restore_from_backup(copy, "wall")
        assert restored == "wall-2"
        assert workspace.annotations.read("floor", 0)[0].tolist() == kept
        assert workspace.annotations.read("wall", 0)[0].tolist() != before["label"]
    assert state(painted, restored) == before
    database = ("--database", painted.database) if painted.database else ()
    assert run("restore", copy, "--only", "floor", "--workspace", painted.workspace, *database) == 0
    assert state(painted, "floor-2")["label"] == kept
    with closing(Workspace(painted)) as workspace:
        workspace.labels.redo("wall-2", "ann")
        assert workspace.listing.problems("wall-2") == []
        assert len(workspace.library.manifests()) == 4


def test_nothing_moves_while_a_server_runs_or_halfway(
    settings: Settings,
    postgres_url: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    paint(settings)
    before, here = state(settings), ("--workspace", settings.workspace)
    server = Uploads(settings.workspace)
    server.open()
    assert run("move", postgres_url, *here) == 1
    assert "expected no running server" in capsys.readouterr().err
    server.close()
    with monkeypatch.context() as patch:
        patch.setattr("pointbrush.database.backup._CONTINUE_NUMBERS", "SELECT 1 / 0")
        assert run("move", postgres_url, *here) == 1
    assert state(settings) == before
    assert run("move", postgres_url, *here) == 0  # the target is as empty as it was
    assert state(replace(settings, database=postgres_url)) == before


def keep_uploads(workspace: Path) -> None:
    uploads = Uploads(workspace)
    uploads.open()
    print("open", flush=True)
    time.sleep(PATIENCE)


def test_a_killed_server_keeps_nobody_waiting(
    settings: Settings,
    postgres_url: str,
) -> None:
    paint(settings)
    before, here = state(settings), ("--workspace", settings.workspace)
    with forked.calling(keep_uploads, settings.workspace) as server:
        assert server.stdout.readline() == "open\n"
        assert run("move", postgres_url, *here) == 1
    assert run("move", postgres_url, *here) == 0
    assert state(replace(settings, database=postgres_url)) == before


def test_labels_that_are_missing_are_not_begun_anew_unasked(
    settings: Settings, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    paint(settings)
    before, here = state(settings), ("--workspace", settings.workspace)
    found = settings.workspace / "labels.sqlite"
    taken = found.rename(settings.workspace.parent / "taken.sqlite")
    for call in ("serve", "check"):
        assert run(call, *here) == 1
        told = capsys.readouterr().err
        assert "labels.sqlite is missing beside 2 recordings" in told
        assert "pointbrush restore" in told
        assert "serve --new-labels" in told
    assert not found.exists()
    taken.rename(found)
    assert state(settings) == before
    found.unlink()
    with closing(Workspace(replace(settings, new_labels=True))) as workspace:
        assert workspace.labels.palette("wall") == []
    # Of a workspace from before the note nothing is known but that its labels are not there.
    found.unlink()
    (settings.workspace / "labels.made").unlink()
    with closing(Workspace(settings)) as workspace:
        assert workspace.labels.palette("wall") == []
    assert "labels.sqlite is missing beside 2 recordings" in caplog.text


def test_a_restore_that_ends_halfway_leaves_nothing(painted: Settings, tmp_path: Path) -> None:
    with closing(Workspace(painted)) as workspace:
        make_backup(workspace.labels, workspace.library, tmp_path / "copy")
        known = workspace.labels.sequences()
        folder = workspace.library.folder
        names = sorted(path.name for path in folder.iterdir())

        def fail() -> None:
            raise ZeroDivisionError

        file = tmp_path / "copy" / "labels.sqlite"
        with pytest.raises(ZeroDivisionError):
            restore_sequence(file, workspace.labels.database, "wall", "wall-9", "0" * 16, fail)
        with pytest.raises(NotFoundError):
            workspace.restore_from_backup(tmp_path / "copy", "nothing")
        assert workspace.labels.sequences() == known
        assert sorted(path.name for path in folder.iterdir()) == names
