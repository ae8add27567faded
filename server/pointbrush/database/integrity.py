"""Integrity checks of the database file and its tables, without the meaning of the rows."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from sqlalchemy import Connection, Table, Text, cast, func, select, text

from pointbrush.database.database import Database
from pointbrush.database.schema import metadata
from pointbrush.errors import UnavailableError

MOST_FINDINGS = 100


def integrity(database: Database) -> list[str]:
    """Return the faults of the database, one sentence each, after reading all of it.

    SQLite checks its pages, indexes and references.  For PostgreSQL every row is read, in the order
    of the table and of its primary key, which finds unreadable pages and rows that an index has
    lost; the extension ``amcheck``, if installed, checks tables and indexes too.
    """
    if database.path is not None:
        return [f"database: {database.path.name}: {line}" for line in _sqlite(database)]
    return [f"database: {line}" for line in _postgres(database)]


def check_database(url: str) -> list[str]:
    """Return the faults of the database at ``url``, even if a store cannot open it."""
    database = Database(url)
    try:
        return integrity(database)
    finally:
        database.close()


def rebuild_indexes(database: Database) -> None:
    """Rebuild all indexes from the rows; raises ReadOnlyError, UnavailableError."""
    with database.write() as connection:
        if database.sqlite:
            connection.execute(text("REINDEX"))
            return
        for table in metadata.sorted_tables:
            connection.execute(text(f'REINDEX TABLE "{table.name}"'))


def _sqlite(database: Database) -> Iterator[str]:
    try:
        with database.read() as connection:
            found = connection.execute(text(f"PRAGMA integrity_check({MOST_FINDINGS})")).scalars()
            yield from (str(line) for line in found if line != "ok")
            for row in connection.execute(text("PRAGMA foreign_key_check")):
                yield f"row {row[1]} of {row[0]} refers to a row of {row[2]} that is not there"
    except UnavailableError as error:
        yield str(error)


def _postgres(database: Database) -> Iterator[str]:
    with database.read() as connection:
        query = text("SELECT 1 FROM pg_extension WHERE extname = 'amcheck'")
        amcheck = connection.execute(query).scalar()
    for table in metadata.sorted_tables:
        findings: list[str] = []
        counts = [*_read_rows(database, table, findings), *_read_index(database, table, findings)]
        yield from findings
        if len(set(counts)) > 1:
            yield f"{table.name}: its primary key lists {counts[1]} rows, it has {counts[0]}"
        if amcheck:
            yield from _amcheck(database, table.name)


@contextlib.contextmanager
def _telling(database: Database, findings: list[str], name: str) -> Iterator[Connection]:
    """Open a transaction without a timeout; its UnavailableError becomes a finding on ``name``."""
    try:
        with database.read() as connection:
            connection.execute(text("SET LOCAL statement_timeout = 0"))
            yield connection
    except UnavailableError as error:
        findings.append(f"{name}: {error}")


def _read_rows(database: Database, table: Table, findings: list[str]) -> Iterator[int]:
    """Read all rows, including values in TOAST storage, and yield their number."""
    with _telling(database, findings, table.name) as connection:
        connection.execute(text("SET LOCAL enable_indexscan = off"))
        connection.execute(text("SET LOCAL enable_indexonlyscan = off"))
        whole = func.sum(func.length(cast(func.row(*table.c), Text)))
        query = select(func.count(), whole).select_from(table)
        yield int(connection.execute(query).one()[0])


def _read_index(database: Database, table: Table, findings: list[str]) -> Iterator[int]:
    """Read all rows by the primary key and yield their number."""
    with _telling(database, findings, table.name) as connection:
        for other in ("seqscan", "bitmapscan", "indexonlyscan", "sort"):
            connection.execute(text(f"SET LOCAL enable_{other} = off"))
        first, *_ = table.primary_key
        rows = select(table).order_by(*table.primary_key).offset(0).subquery()
        yield int(connection.execute(select(func.count(rows.c[first.name]))).scalar_one())


def _amcheck(database: Database, table: str) -> Iterator[str]:
    findings: list[str] = []
    with _telling(database, findings, table) as connection:
        query = text("SELECT msg FROM verify_heapam(CAST(:name AS regclass))")
        rows = connection.execute(query, {"name": table}).scalars()
        findings += [f"{table}: {message}" for message in rows]
    with database.read() as connection:
        query = text(
            "SELECT CAST(indexrelid::regclass AS text) FROM pg_index "
            "WHERE indrelid = CAST(:name AS regclass)"
        )
        names = connection.execute(query, {"name": table}).scalars().all()
    for name in names:
        with _telling(database, findings, name) as connection:
            query = text("SELECT bt_index_check(CAST(:name AS regclass), true)")
            connection.execute(query, {"name": name})
    yield from findings
