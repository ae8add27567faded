from __future__ import annotations

import sqlite3
from contextlib import ExitStack
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import text

from pointbrush.database.database import Database
from pointbrush.database.schema import HEAD, MIGRATIONS, metadata, migrate
from pointbrush.errors import BadInputError
from pointbrush.teamwork.store import WorkspaceStore
from tests import forked


def test_the_migrations_make_the_schema(empty_url: str) -> None:
    database = Database(empty_url)
    migrate(database)
    migrate(database)
    with database.read() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        assert compare_metadata(context, metadata) == []
        assert context.get_current_revision() == HEAD
    database.close()


def test_head_is_the_last_migration() -> None:
    assert ScriptDirectory(MIGRATIONS).get_heads() == [HEAD]


@pytest.mark.parametrize(
    ("version", "remedy"),
    [("9999", "written by a newer pointbrush"), ("0009", "open it once with pointbrush 0.1.0")],
)
def test_a_database_of_an_unknown_version_is_left_alone(
    url: str, version: str, remedy: str
) -> None:
    WorkspaceStore(url).close()
    database = Database(url)
    with database.write() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = :n"), {"n": version})
    with pytest.raises(BadInputError, match=f"got {version}; .*{remedy}"):
        WorkspaceStore(url)
    with database.read() as connection:
        kept = connection.execute(text("SELECT version_num FROM alembic_version")).scalar()
    database.close()
    assert kept == version


def open_store(url: str) -> None:
    WorkspaceStore(url).close()


def test_two_processes_that_start_at_once(empty_url: str) -> None:
    with ExitStack() as stack:
        started = [stack.enter_context(forked.calling(open_store, empty_url)) for _ in range(3)]
        assert [process.wait() for process in started] == [0, 0, 0]
    WorkspaceStore(empty_url).close()


def test_a_file_that_is_no_database(tmp_path: Path) -> None:
    path = tmp_path / "labels.sqlite"
    path.write_bytes(b"this is not a database" * 100)
    with pytest.raises(Exception, match="not a database") as caught:
        WorkspaceStore(f"sqlite:///{path}")
    assert not isinstance(caught.value, sqlite3.Error)
