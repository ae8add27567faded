"""A database that may not be written is copied as it is, whatever state it was left in."""

from __future__ import annotations

import shutil
import sqlite3
from pathlib import Path

import numpy as np
import pytest

from pointbrush.database import database
from pointbrush.database.private_copy import PrivateCopy
from pointbrush.errors import ReadOnlyError, UnavailableError
from pointbrush.labels import Write
from pointbrush.teamwork.store import WorkspaceStore

SEQ = "juggling"


def paint(store: WorkspaceStore, edit: str) -> None:
    write = Write(np.arange(10), label=1, provenance=1)
    store.apply(SEQ, edit_id=edit, author="ann", kind="paint", writes={0: write}, summary="")


@pytest.fixture
def live(tmp_path: Path) -> WorkspaceStore:
    store = WorkspaceStore(f"sqlite:///{tmp_path / 'labels.sqlite'}")
    store.recordings.register(SEQ, [100])
    store.create_label(SEQ, "ann", name="pin")
    paint(store, "one")
    return store


def edits_in(copy: PrivateCopy) -> int:
    store = WorkspaceStore(f"sqlite:///{copy.path}")
    assert store.check(SEQ) == []
    found = len(store.edits(SEQ))
    store.close()
    return found


def test_beside_a_writer_whose_log_was_not_taken_in(live: WorkspaceStore, tmp_path: Path) -> None:
    assert (tmp_path / "labels.sqlite-wal").stat().st_size > 0
    copy = PrivateCopy(tmp_path / "labels.sqlite")
    paint(live, "two")  # whoever writes is not held up
    assert edits_in(copy) == 2
    copy.close()
    assert not copy.path.exists()
    live.close()


def test_after_a_clean_end_and_after_a_crash(live: WorkspaceStore, tmp_path: Path) -> None:
    crashed = tmp_path / "crashed"
    crashed.mkdir()
    for suffix in ("", "-wal"):
        shutil.copy(tmp_path / f"labels.sqlite{suffix}", crashed)
    live.close()
    assert not (tmp_path / "labels.sqlite-wal").exists()
    for source in (tmp_path / "labels.sqlite", crashed / "labels.sqlite"):
        before = {path.name: path.read_bytes() for path in source.parent.glob("labels*")}
        copy = PrivateCopy(source)
        assert edits_in(copy) == 2
        copy.close()
        assert {path.name: path.read_bytes() for path in source.parent.glob("labels*")} == before


def test_no_database_is_an_empty_one_and_junk_is_told(tmp_path: Path) -> None:
    copy = PrivateCopy(tmp_path / "labels.sqlite")
    store = WorkspaceStore(f"sqlite:///{copy.path}")
    assert store.sequences() == {}
    store.close()
    copy.close()
    (tmp_path / "labels.sqlite").write_bytes(b"junk" * 1000)
    with pytest.raises(UnavailableError, match="not a database"):
        PrivateCopy(tmp_path / "labels.sqlite")


def test_an_older_one_is_brought_up_to_date_in_the_copy_and_then_sealed(
    live: WorkspaceStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    live.close()
    path = tmp_path / "labels.sqlite"
    before = path.read_bytes()
    monkeypatch.setattr(database, "file_writable", lambda path: path != tmp_path / path.name)
    store = WorkspaceStore(f"sqlite:///{path}")
    store.recordings.register("another", [3])
    store.seal()
    with pytest.raises(ReadOnlyError, match="read-only"):
        paint(store, "two")
    with pytest.raises(ReadOnlyError, match="read-only"):
        store.require_writable()
    assert len(store.edits(SEQ)) == 2
    store.close()
    assert path.read_bytes() == before
    with sqlite3.connect(path) as connection:
        assert connection.execute("SELECT count(*) FROM sequences").fetchone() == (1,)
