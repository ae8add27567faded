"""Participants of studies go where the database goes, and into workspaces of before."""

from __future__ import annotations

import threading
from contextlib import closing
from pathlib import Path

import pytest

from pointbrush.database.backup import back_up, restore
from pointbrush.errors import ConflictError
from pointbrush.sequences.storage.manifest import VERSION
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.workspace import Workspace
from tests.old_workspace import make_older, old_workspace

RECORDS = [{"kind": "label", "step": 0, "t": n, "label": n} for n in range(4)]


def test_a_restored_database_has_the_participants(url: str, tmp_path: Path) -> None:
    with closing(WorkspaceStore(url)) as store:
        session, code = store.studies.add("halves", lambda number: [f"way {number}"])
        store.studies.append(session.account, 0, RECORDS)
        store.studies.begin(session.account)
        store.studies.finish(session.account, 0, [3, 1])
        kept = store.studies.session(session.account), store.studies.log(session.account)
        back_up(store.database, tmp_path / "backup.sqlite")
    target = f"sqlite:///{tmp_path / 'restored.sqlite'}"
    restore(tmp_path / "backup.sqlite", target)
    with closing(WorkspaceStore(target)) as restored:
        assert restored.studies.account_of(code) == session.account
        own = restored.studies.session(session.account), restored.studies.log(session.account)
        assert own == kept
        assert (kept[0].number, kept[0].conditions) == (1, ("way 1",))
        assert [each.answers for each in kept[0].finished] == [[3, 1]]


def test_calls_at_once_store_each_record_once(url: str) -> None:
    with closing(WorkspaceStore(url)) as store:
        account = store.studies.add("halves", lambda _: ["desk"])[0].account
        ends: list[int | str] = []

        def send(first: int) -> None:
            try:
                ends.append(store.studies.append(account, first, RECORDS[first:]))
            except ConflictError as error:
                ends.append(str(error))

        store.studies.append(account, 0, RECORDS[:2])
        threads = [threading.Thread(target=send, args=(first,)) for first in (0, 1, 2, 2, 1)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert ends == [4] * 5
        stored = [{**record, "received": 0} for record in store.studies.log(account)]
        assert stored == [{**record, "received": 0} for record in RECORDS]


@pytest.mark.parametrize("database", ["sqlite", "postgresql"])
def test_a_workspace_of_the_version_before_takes_studies(
    database: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    postgres = database == "postgresql"
    settings = old_workspace(
        tmp_path, str(request.getfixturevalue("postgres_url")) if postgres else ""
    )
    with closing(Workspace(settings)) as workspace:
        palette = workspace.labels.palette("ball")
    make_older(settings, "0023", VERSION, ())
    with closing(Workspace(settings)) as workspace:
        assert workspace.labels.palette("ball") == palette
        session, code = workspace.labels.studies.add("halves", lambda _: ["desk"])
        assert workspace.labels.studies.account_of(code) == session.account
        workspace.labels.studies.append(session.account, 0, RECORDS)
