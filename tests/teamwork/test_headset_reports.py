"""Reports of headset checks go where the database goes, and into workspaces of before."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import pytest

from pointbrush.database.backup import back_up, restore
from pointbrush.sequences.storage.manifest import VERSION
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.values.headset_checks import HeadsetReportFile
from pointbrush.workspace import Workspace
from tests.old_workspace import make_older, old_workspace

REPORT = HeadsetReportFile(
    format="pointbrush headset report",
    version=1,
    made="2026-01-02T10:00:00Z",
    pointbrush="0.1.0",
    browser="Größer\0",
    trouble="no headset",
    session=None,
    inputs=(),
    pictures=None,
    tasks=(),
)


def test_a_restored_database_has_the_reports(url: str, tmp_path: Path) -> None:
    with closing(WorkspaceStore(url)) as store:
        store.headset_reports.add("ada", REPORT)
        kept = store.headset_reports.all()
        back_up(store.database, tmp_path / "backup.sqlite")
    target = f"sqlite:///{tmp_path / 'restored.sqlite'}"
    restore(tmp_path / "backup.sqlite", target)
    with closing(WorkspaceStore(target)) as restored:
        assert restored.headset_reports.all() == kept


@pytest.mark.parametrize("database", ["sqlite", "postgresql"])
def test_a_workspace_of_the_version_before_takes_reports(
    database: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    postgres = database == "postgresql"
    settings = old_workspace(
        tmp_path, str(request.getfixturevalue("postgres_url")) if postgres else ""
    )
    with closing(Workspace(settings)) as workspace:
        palette = workspace.labels.palette("ball")
        workspace.labels.headset_reports.add("ada", REPORT)
    make_older(settings, "0021", VERSION, ())
    with closing(Workspace(settings)) as workspace:
        assert workspace.labels.palette("ball") == palette
        assert workspace.labels.headset_reports.all() == []
        workspace.labels.headset_reports.add("ada", REPORT)
        (kept,) = workspace.labels.headset_reports.all()
        assert (kept.account, kept.report) == ("ada", REPORT)
