"""A workspace of schema 0010, copied to a folder where a test may open it."""

from __future__ import annotations

import json
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

from alembic import command
from alembic.config import Config
from sqlalchemy import Connection, Table, inspect, select

from pointbrush.database.database import Database
from pointbrush.database.schema import MIGRATIONS, metadata
from pointbrush.sequences.storage.manifest import checksum
from pointbrush.settings import Settings
from tests.serving import settings_in

GOLDEN = Path(__file__).parent / "golden" / "workspace_0010"
EXPECTED: dict[str, Any] = json.loads((GOLDEN / "expected.json").read_text())


def old_workspace(folder: Path, database: str = "") -> Settings:
    """Settings of a copy in ``folder``; its labels go into the empty PostgreSQL ``database``."""
    settings = settings_in(folder, database=database)
    shutil.copytree(GOLDEN, settings.workspace, dirs_exist_ok=True)
    if database:
        _copy_rows(settings.workspace / "labels.sqlite", database)
        (settings.workspace / "labels.sqlite").unlink()
    return settings


def _copy_rows(source: Path, url: str) -> None:
    target = Database(url)
    with target.write() as connection:
        command.upgrade(_config(connection), "0010")
    with closing(sqlite3.connect(source)) as old, target.write() as connection:
        old.row_factory = sqlite3.Row
        there = inspect(connection)
        for table in metadata.sorted_tables:
            if not there.has_table(table.name):
                continue
            rows = [dict(row) for row in old.execute(f"SELECT * FROM {table.name}")]
            if rows:
                was = Table(table.name, type(metadata)(), autoload_with=connection)
                connection.execute(was.insert(), [_typed(was, row) for row in rows])
        numbers = select(metadata.tables["sequences"].c.number)
        highest = max(connection.execute(numbers).scalars())
        connection.exec_driver_sql(
            f"SELECT setval(pg_get_serial_sequence('sequences', 'number'), {highest})"
        )
    target.close()


def make_older(settings: Settings, schema: str, manifest: int, without: tuple[str, ...]) -> None:
    """Make what this version wrote what the one of ``schema`` and ``manifest`` would have written.

    ``without``: the fields that manifests did not have then.
    """
    with closing(Database(settings.database_url)) as database, database.write() as connection:
        command.downgrade(_config(connection), schema)
    for path in settings.workspace.glob("sequences/*/manifest.json"):
        content = json.loads(path.read_text())
        content = {k: v for k, v in content.items() if k not in (*without, "checksum")}
        content["version"] = manifest
        path.write_text(json.dumps(content | {"checksum": checksum(content)}))


def _config(connection: Connection) -> Config:
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    config.set_main_option("path_separator", "os")
    config.attributes["connection"] = connection
    return config


def _typed(table: Table, row: dict[str, Any]) -> dict[str, Any]:
    """SQLite keeps truth as 0 and 1."""
    truths = {column.name for column in table.c if column.type.python_type is bool}
    return {name: bool(value) if name in truths else value for name, value in row.items()}
