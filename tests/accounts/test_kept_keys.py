"""Keys of commands are kept with an account, and go where the database goes."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from pointbrush.database.backup import back_up, restore
from pointbrush.teamwork.store import WorkspaceStore


def test_a_restored_database_has_peoples_keys(url: str, tmp_path: Path) -> None:
    with closing(WorkspaceStore(url)) as store:
        store.own_keys.put("ada", {"Loop": "v"})
        store.own_keys.put("ada", {"Größer": "ctrl+ö"})
        back_up(store.database, tmp_path / "backup.sqlite")
    target = f"sqlite:///{tmp_path / 'restored.sqlite'}"
    restore(tmp_path / "backup.sqlite", target)
    with closing(WorkspaceStore(target)) as restored:
        assert restored.own_keys.get("ada") == {"Größer": "ctrl+ö"}
        assert restored.own_keys.get("bob") is None
