"""The last change of each frame: of databases from before it was kept, and what disagrees."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from alembic import command
from alembic.config import Config
from sqlalchemy import MetaData, insert, select, text

from pointbrush.database.database import Database
from pointbrush.database.schema import MIGRATIONS
from pointbrush.teamwork.store import WorkspaceStore

OLD = Path(__file__).parents[1] / "golden" / "workspace_0010"


@pytest.fixture(params=["sqlite", "postgresql"])
def old(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """The URL of a database as schema 0010 has it."""
    file = tmp_path / "old.sqlite"
    shutil.copy(OLD / "labels.sqlite", file)
    if request.param == "sqlite":
        return f"sqlite:///{file}"
    url = str(request.getfixturevalue("postgres_url"))
    source, target = Database(f"sqlite:///{file}"), Database(url)
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    config.set_main_option("path_separator", "os")
    with source.read() as reader, target.write() as writer:
        config.attributes["connection"] = writer
        command.upgrade(config, "0010")
        known = MetaData()
        known.reflect(reader)
        for table in known.sorted_tables:
            rows = [dict(row) for row in reader.execute(select(table)).mappings()]
            if rows and table.name != "alembic_version":
                writer.execute(insert(table), rows)
    source.close()
    target.close()
    return url


@pytest.fixture
def store(old: str) -> Iterator[WorkspaceStore]:
    opened = WorkspaceStore(old)
    yield opened
    opened.close()


def test_an_old_database_knows_when_each_frame_changed_last(store: WorkspaceStore) -> None:
    expected = json.loads((OLD / "expected.json").read_text())["sequences"]
    assert store.sequences().keys() == expected.keys()
    for sequence, then in expected.items():
        assert store.check(sequence) == []
        assert store.revision(sequence) == then["revision"]
        last = dict.fromkeys(range(len(then["points"])), 0)
        for edit in reversed(store.edits(sequence)):
            last.update(dict.fromkeys(edit.frames, edit.revision))
        assert {frame: store.changed(sequence, frame) for frame in last} == last
        assert any(last.values())


def test_an_old_database_goes_on_as_it_was(store: WorkspaceStore) -> None:
    before = store.values("ball", 1).label
    undone = store.undo("ball", "ada")
    assert store.values("ball", 1).changed == undone.revision
    assert (store.values("ball", 1).label != before).any()
    store.redo("ball", "ada")
    assert (store.values("ball", 1).label == before).all()
    assert store.check("ball") == []


def test_a_last_change_that_disagrees_is_told(old: str, store: WorkspaceStore) -> None:
    number = store.changed("ball", 1)
    database = Database(old)
    with database.write() as connection:
        connection.execute(text("UPDATE frame_changes SET revision = 1 WHERE frame = 1"))
    database.close()
    told = f"last change of frame 1: expected revision {number}, the database has 1"
    assert told in store.check("ball")
