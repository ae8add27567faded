"""Bring a label database to this version's schema, whatever version it is at."""

from __future__ import annotations

from pathlib import Path

from sqlalchemy import Connection, inspect, text

from pointbrush.errors import BadInputError
from pointbrush.labels.database import Database
from pointbrush.labels.schema import HEAD

MIGRATIONS = Path(__file__).parent / "migrations"
_ADVISORY_LOCK = 0x706F696E74  # "point": one process migrates a PostgreSQL database at a time


def migrate(database: Database) -> None:
    """Run the migrations that are missing, in one transaction.

    Raises BadInputError for a database of a newer pointbrush, UnavailableError.
    """
    with database.read() as connection:
        if _version(connection) == HEAD:
            return
    with database.write() as connection:
        if not database.sqlite:
            # A migration rewrites tables, and waits for another process's: both may take long.
            connection.execute(text("SET LOCAL statement_timeout TO 0"))
            connection.execute(text("SELECT pg_advisory_xact_lock(:n)"), {"n": _ADVISORY_LOCK})
        if _version(connection) != HEAD:
            _upgrade(connection)


def _version(connection: Connection) -> str | None:
    if not inspect(connection).has_table("alembic_version"):
        return None
    found = connection.execute(text("SELECT version_num FROM alembic_version")).scalar()
    return None if found is None else str(found)


def _upgrade(connection: Connection) -> None:
    # Imported here: a database that is up to date opens without Alembic's start-up time.
    from alembic import command
    from alembic.config import Config
    from alembic.script import ScriptDirectory

    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    config.set_main_option("path_separator", "os")
    config.attributes["connection"] = connection
    known = {script.revision for script in ScriptDirectory.from_config(config).walk_revisions()}
    found = _version(connection)
    if found is not None and found not in known:
        raise BadInputError(
            f"database: expected schema version {HEAD} or older, got {found}; "
            "it was written by a newer pointbrush"
        )
    command.upgrade(config, "head")
