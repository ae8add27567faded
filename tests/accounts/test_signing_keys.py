"""The keys that sign what browsers keep: one for all servers on a database, kept in its copies."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from sqlalchemy import text

from pointbrush.database.backup import back_up, restore
from pointbrush.database.database import Database
from pointbrush.teamwork.store import WorkspaceStore


def test_all_servers_and_later_ones_have_one_key(url: str) -> None:
    with closing(WorkspaceStore(url)) as one, closing(WorkspaceStore(url)) as other:
        key = one.signing_keys.get("test")
        assert len(key) == 32
        assert other.signing_keys.get("test") == key
        assert one.signing_keys.get("another purpose") != key
    with closing(WorkspaceStore(url)) as later:
        assert later.signing_keys.get("test") == key


def test_a_restored_database_has_the_key_of_the_backup(url: str, tmp_path: Path) -> None:
    with closing(WorkspaceStore(url)) as store:
        key = store.signing_keys.get("test")
        back_up(store.database, tmp_path / "backup.sqlite")
    target = f"sqlite:///{tmp_path / 'restored.sqlite'}"
    with closing(WorkspaceStore(target)) as used_before:
        assert used_before.signing_keys.get("test") != key
    restore(tmp_path / "backup.sqlite", target)
    with closing(WorkspaceStore(target)) as restored:
        assert restored.signing_keys.get("test") == key


def test_a_database_that_may_not_be_written_still_signs(labels_url: str) -> None:
    with closing(WorkspaceStore(labels_url)), closing(Database(labels_url)) as database:
        name = database.url.database
        with database.write() as connection:
            change = f'ALTER DATABASE "{name}" SET default_transaction_read_only = on'
            connection.execute(text(change))
    with closing(WorkspaceStore(labels_url)) as reader:
        key = reader.signing_keys.get("test")
        assert len(key) == 32
        assert reader.signing_keys.get("test") == key
