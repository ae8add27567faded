"""What is derived from the journal is made anew; damage to the journal or database is told."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from postgres import PostgresServer
from sqlalchemy import text

from pointbrush.database.integrity import check_database
from pointbrush.labels.packing import encode_states
from pointbrush.teamwork.store import WorkspaceStore

SEQ = "juggling"
PAGE = 8192


def shown(store: WorkspaceStore) -> tuple[object, ...]:
    values = store.values(SEQ, 0)
    return store.palette(SEQ), store.counts(SEQ), store.tracks(SEQ), values.label.tobytes()


DERIVED = [
    "UPDATE counts SET points = points + 1 WHERE label = 2",
    "DELETE FROM counts",
    "UPDATE snapshots SET data = :other",
    "UPDATE snapshots SET data = :junk",
    "UPDATE labels SET name = 'x' WHERE id = 2",
    "DELETE FROM labels WHERE id = 1",
    "DELETE FROM tracks",
]
JOURNAL = [
    "UPDATE edit_blocks SET data = :junk WHERE revision = 4",
    "DELETE FROM edit_blocks WHERE revision = 8",
    "UPDATE edits SET state = 1 WHERE revision = 5",
    "UPDATE edits SET revision = 99 WHERE revision = 3",
]


def harm(store: WorkspaceStore, statement: str) -> None:
    values = {"other": encode_states(np.ones(65_536, np.uint64)), "junk": b"junk"}
    used = {name: value for name, value in values.items() if f":{name}" in statement}
    with store.database.write() as connection:
        connection.execute(text(statement), used)


@pytest.mark.parametrize("statement", DERIVED)
def test_what_is_derived_is_made_anew(url: str, filled: WorkspaceStore, statement: str) -> None:
    before = shown(filled)
    harm(filled, statement)
    fresh = WorkspaceStore(url)
    rebuilt, lost = fresh.repair(SEQ)
    assert rebuilt
    assert lost == []
    assert fresh.check(SEQ) == []
    assert shown(fresh) == before
    assert fresh.repair(SEQ) == ([], [])
    fresh.redo(SEQ, "ann")
    assert fresh.check(SEQ) == []
    fresh.close()


@pytest.mark.parametrize("statement", JOURNAL)
def test_a_damaged_journal_is_told_and_nothing_touched(
    url: str, filled: WorkspaceStore, statement: str
) -> None:
    harm(filled, statement)
    harm(filled, "DELETE FROM tracks")
    fresh = WorkspaceStore(url)
    rebuilt, lost = fresh.repair(SEQ)
    assert rebuilt == []
    assert any("edit" in line for line in lost)
    with fresh.database.read() as connection:
        assert connection.execute(text("SELECT count(*) FROM tracks")).scalar() == 0
        assert connection.execute(text("SELECT count(*) FROM snapshots")).scalar()
    fresh.close()


def test_a_sound_database_is_sound(filled: WorkspaceStore) -> None:
    assert filled.integrity() == []
    filled.rebuild_indexes()
    assert filled.integrity() == []


@pytest.fixture
def sqlite_file(tmp_path: Path) -> Path:
    """A closed database with 2,000 edits in it."""
    path = tmp_path / "labels.sqlite"
    store = WorkspaceStore(f"sqlite:///{path}")
    store.recordings.register(SEQ, [100])
    store.create_label(SEQ, "ann", name="one")
    with store.database.write() as connection:
        for revision in range(2, 2000):
            connection.execute(
                text(
                    "INSERT INTO edits SELECT sequence, :revision, :id, author, time, kind, "
                    "summary, points, frames, labels, tracks, target, 4, redone, boxes FROM edits "
                    "WHERE revision = 1"
                ),
                {"revision": revision, "id": f"edit {revision}"},
            )
        connection.execute(text("UPDATE sequences SET revision = 1999"))
    store.close()
    return path


def spoil(path: Path, name: str, change: Callable[[bytearray], None]) -> None:
    """Change a page in the middle of a table or an index of a SQLite file."""
    with sqlite3.connect(path) as connection:
        size = connection.execute("PRAGMA page_size").fetchone()[0]
        pages = connection.execute(
            "SELECT pageno FROM dbstat WHERE name = ? AND pagetype = 'leaf'", (name,)
        ).fetchall()
    connection.close()
    start = (pages[len(pages) // 2][0] - 1) * size
    content = bytearray(path.read_bytes())
    page = content[start : start + size]
    change(page)
    content[start : start + size] = page
    path.write_bytes(content)


def blank(page: bytearray) -> None:
    page[:] = bytes(len(page))


def test_a_spoilt_page_of_a_table_is_found_and_cannot_be_mended(sqlite_file: Path) -> None:
    try:
        spoil(sqlite_file, "edits", blank)
    except sqlite3.OperationalError:
        pytest.skip("this SQLite has no dbstat")
    assert check_database(f"sqlite:///{sqlite_file}")


def test_a_spoilt_index_is_found_and_made_anew(sqlite_file: Path) -> None:
    def lose_a_row(page: bytearray) -> None:
        count = int.from_bytes(page[3:5], "big")
        page[3:5] = (count - 1).to_bytes(2, "big")

    try:
        spoil(sqlite_file, "edits_stack", lose_a_row)
    except sqlite3.OperationalError:
        pytest.skip("this SQLite has no dbstat")
    store = WorkspaceStore(f"sqlite:///{sqlite_file}")
    assert any("edits_stack" in line for line in store.integrity())
    store.rebuild_indexes()
    assert store.integrity() == []
    store.close()


def test_pages_of_postgresql_that_cannot_be_read_are_found(
    postgres_server: PostgresServer, labels_url: str
) -> None:
    store = WorkspaceStore(labels_url)
    store.recordings.register(SEQ, [100])
    store.create_label(SEQ, "ann", name="one")
    with store.database.write() as connection:
        path = connection.execute(text("SELECT pg_relation_filepath('edit_labels')")).scalar_one()
        connection.execute(text("CREATE EXTENSION amcheck"))
    assert store.integrity() == []
    with store.database.engine.connect() as connection:
        connection.execution_options(isolation_level="AUTOCOMMIT").execute(text("CHECKPOINT"))
    store.close()
    postgres_server.stop()
    try:
        with (postgres_server.data / path).open("r+b") as file:
            file.write(b"\xff" * PAGE)
    finally:
        postgres_server.start()
    found = check_database(labels_url)
    assert any("edit_labels" in line for line in found), found
