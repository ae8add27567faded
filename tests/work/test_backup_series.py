"""Backups in one folder: recordings copied once, the oldest removed, none of them half."""

from __future__ import annotations

import os
import signal
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import httpx
import pytest

from pointbrush.cli import main
from pointbrush.errors import BadInputError, ConflictError
from pointbrush.settings.settings import Settings, variables
from pointbrush.web.app import create_app
from pointbrush.work.backups import backup
from pointbrush.work.backups.series import BackupSchedule, BackupSeries
from pointbrush.workspace import Workspace
from tests import forked
from tests.serving import TOKEN, add_sequence, serving, settings_in
from tests.waiting import eventually
from tests.work.test_moving import paint, painted, settings, state  # noqa: F401  # fixtures


def killed() -> None:
    """Be the command, killed once it has copied the recordings."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(backup, "back_up", lambda *_: os.kill(os.getpid(), signal.SIGKILL))
        main(["backup"])


def data_of(backup: Path) -> dict[str, Path]:
    """Files of a backup's recordings that say what the points are."""
    found = (path for path in (backup / "sequences").rglob("*") if path.parent.name == "frames")
    return {str(path.relative_to(backup)): path for path in found}


def restored(settings: Settings, backup: Path) -> Settings:  # noqa: F811
    there = replace(settings, workspace=backup.parent / f"from-{backup.name}", database="")
    assert main(["restore", str(backup), "--workspace", str(there.workspace)]) == 0
    return there


def test_recordings_are_copied_once_and_any_kept_backup_comes_back(
    painted: Settings,  # noqa: F811
    tmp_path: Path,
) -> None:
    series = BackupSeries(tmp_path / "kept", keep=2)
    states, made = [], []
    for name in ("Wall", "West wall", "White wall"):
        with closing(Workspace(painted)) as workspace:
            workspace.update_sequence("wall", name=name)
            workspace.labels.create_label("wall", "ann", name=name)
            made.append(series.add(workspace.back_up))
        states.append(state(painted))
    assert series.made() == made[1:]
    first, second = (data_of(backup) for backup in made[1:])
    assert first.keys() == second.keys() > set()
    assert all(second[name].samefile(first[name]) for name in first)
    for one, expected in zip(made[1:], states[1:], strict=True):
        there = restored(painted, one)
        assert state(there) == expected
    with closing(Workspace(there)) as workspace:
        assert workspace.recording("wall").manifest.name == "White wall"


def test_a_recording_that_is_another_is_copied(settings: Settings, tmp_path: Path) -> None:  # noqa: F811
    series = BackupSeries(tmp_path / "kept", keep=2)
    with closing(Workspace(settings)) as workspace:
        first = series.add(workspace.back_up)
        workspace.deletion.delete("floor")
    add_sequence(settings, "floor", frames=1, points=900)
    with closing(Workspace(settings)) as workspace:
        second = series.add(workspace.back_up)
    files = data_of(first), data_of(second)
    shared = {name.split("/")[1] for name in files[1] if files[1][name].samefile(files[0][name])}
    assert shared == {"wall"}
    assert state(restored(settings, second), "floor") == state(settings, "floor")


def test_a_backup_that_was_killed_is_none(
    settings: Settings,  # noqa: F811
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    series = BackupSeries(tmp_path / "kept", keep=1)
    asked = replace(settings, backup_to=str(series.folder), backup_keep=1)
    for name, value in variables(asked, "backup").items():
        monkeypatch.setenv(name, value)
    paint(settings)
    assert main(["backup"]) == 0
    kept = series.made()
    assert forked.call(killed) == -signal.SIGKILL
    assert any((series.folder / ".unfinished").rglob("manifest.json"))
    assert series.made() == kept
    assert main(["backup"]) == 0
    assert [path.name for path in series.folder.iterdir() if path.is_dir()] == [
        path.name for path in series.made()
    ]
    assert series.made() != kept
    assert state(restored(settings, series.made()[0])) == state(settings)


def test_two_servers_make_one_backup_when_it_is_due(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = tmp_path / "kept"
    asked = settings_in(tmp_path, backup_to=str(kept))
    add_sequence(asked, "wall", frames=1, points=500)
    monkeypatch.setattr(BackupSchedule, "first_seconds", 0.0)
    with serving(asked) as here, serving(asked):
        headers = {"Authorization": f"Bearer {TOKEN}"}

        def told() -> dict[str, float]:
            lines = httpx.get(f"{here.url}/metrics", headers=headers).text.splitlines()
            found = (line.split() for line in lines if line.startswith("pointbrush_backup"))
            return {name: float(value) for name, value in found}

        eventually(lambda: told()["pointbrush_backup_timestamp_seconds"] > 0, every=0.2)
        series = BackupSeries(kept, keep=1)
        eventually(lambda: not series.is_busy(), every=0.2)
        assert len(series.made()) == 1, "not one by each"
        assert told()["pointbrush_backup_failures"] == 0
    assert state(restored(asked, series.made()[0])) == state(asked)


def test_only_one_is_made_at_a_time_and_a_failure_is_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    series = BackupSeries(tmp_path / "kept", keep=1)
    with pytest.raises(ConflictError, match="being made"):
        series.add(lambda *_: series.add(lambda *_: None) and None)
    monkeypatch.setattr(BackupSchedule, "first_seconds", 0.0)
    (tmp_path / "file").touch()
    wrong = BackupSchedule(BackupSeries(tmp_path / "file" / "kept", keep=1), "1h", {})
    wrong.begin()
    eventually(lambda: wrong.failures == 1)
    wrong.close()
    assert "no backup was made" in caplog.text
    with (
        closing(Workspace(settings_in(tmp_path))) as workspace,
        pytest.raises(BadInputError, match="90m, 24h or 7d"),
    ):
        create_app(workspace, settings_in(tmp_path, backup_to="kept", backup_every="daily"))
