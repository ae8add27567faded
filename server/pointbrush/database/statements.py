"""Frequent statements: compiled once and run directly by the database's driver.

Composing a statement and fetching its rows through SQLAlchemy takes ten times as long as SQLite
takes to run it.  ``Look`` runs single queries outside transactions, for example for a newer
revision of a recording.
"""

from __future__ import annotations

import contextlib
import sqlite3
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from importlib import import_module
from types import SimpleNamespace
from typing import Any

from sqlalchemy import Connection, Table, make_url
from sqlalchemy.sql import ClauseElement, Select

Driver = Any
"""A connection of the driver: ``sqlite3.Connection`` or ``psycopg.Connection``."""
Values = Mapping[str, Any]
KEPT = 8
"""Limit of idle connections; more are open while more threads run queries."""


@cache
def dialect_of(*, sqlite: bool) -> Any:
    """Return a dialect of SQLAlchemy, with the drivers' style of named parameters."""
    how = {"paramstyle": "named"} if sqlite else {}
    return make_url("sqlite://" if sqlite else "postgresql+psycopg://").get_dialect()(**how)


def insert(table: Table, *, sqlite: bool) -> Any:
    """Return an INSERT with support for ON CONFLICT."""
    # Imported here, as a server needs only one, and PostgreSQL's is slow to import.
    name = "sqlite" if sqlite else "postgresql"
    return import_module(f"sqlalchemy.dialects.{name}").insert(table)


class Statement:
    """One statement with named parameters."""

    def __init__(self, make: ClauseElement | Callable[[bool], ClauseElement]) -> None:
        """``make``: the statement, or a function of it for SQLite (True) or PostgreSQL (False)."""
        self._make = make
        self._compiled: dict[bool, tuple[str, dict[str, Any]]] = {}
        self._columns: list[str] = []

    def run(self, driver: Driver, values: Values) -> Any:
        """Run the statement and return the driver's cursor."""
        text, constants = self._text(of_sqlite=_is_sqlite(driver))
        return driver.execute(text, {**constants, **values})

    def run_each(self, driver: Driver, rows: Sequence[Values]) -> None:
        """Run the statement for each of ``rows``."""
        if rows:
            text, constants = self._text(of_sqlite=_is_sqlite(driver))
            driver.cursor().executemany(text, [{**constants, **row} for row in rows])

    def one(self, cursor: Any) -> Any:
        """Return the row of this statement's cursor, by column names, or None."""
        row = cursor.fetchone()
        return (
            None if row is None else SimpleNamespace(**dict(zip(self._columns, row, strict=True)))
        )

    def ask(self, driver: Driver, values: Values) -> Any:
        """Run the statement and return its row, or None."""
        return self.one(self.run(driver, values))

    def _text(self, *, of_sqlite: bool) -> tuple[str, dict[str, Any]]:
        found = self._compiled.get(of_sqlite)
        if found is None:
            made: Any = self._make
            statement = made if isinstance(made, ClauseElement) else made(of_sqlite)
            if isinstance(statement, Select):
                self._columns = [str(column.key) for column in statement.selected_columns]
            compiled = statement.compile(dialect=dialect_of(sqlite=of_sqlite))
            constants = {k: v for k, v in compiled.params.items() if v is not None}
            found = self._compiled[of_sqlite] = (str(compiled), constants)
        return found


def upsert(table: Table) -> Statement:
    """Return a statement that inserts rows or replaces rows with the same primary key."""
    keys = [column.name for column in table.primary_key]

    def make(of_sqlite: bool) -> ClauseElement:
        statement = insert(table, sqlite=of_sqlite)
        rest = {c.name: statement.excluded[c.name] for c in table.c if c.name not in keys}
        made: ClauseElement = statement.on_conflict_do_update(index_elements=keys, set_=rest)
        return made

    return Statement(make)


def driver_of(connection: Connection) -> Driver:
    """Return the driver's connection of an SQLAlchemy connection, in the same transaction."""
    return connection.connection.dbapi_connection


def begin(driver: Driver) -> None:
    """Begin a transaction of ``Database.write``; for SQLite it has already begun."""
    if not _is_sqlite(driver):
        driver.execute("BEGIN")


def commit(driver: Driver) -> None:
    """Commit a transaction; it is durable after ``together`` ends."""
    if _is_sqlite(driver):
        driver.commit()
    else:
        driver.execute("COMMIT")


@contextlib.contextmanager
def together(driver: Driver) -> Iterator[None]:
    """Send the statements of this context together, and wait for the database once.

    Their results can be fetched after the context ends.
    """
    with contextlib.nullcontext() if _is_sqlite(driver) else driver.pipeline():
        yield


def _is_sqlite(driver: Driver) -> bool:
    return isinstance(driver, sqlite3.Connection)


class Look:
    """Separate connections for single queries; thread-safe."""

    def __init__(self, connect: Callable[[], Driver], failure: type[Exception]) -> None:
        """``connect``: opens a connection of the driver that commits each statement by itself.

        ``failure``: the driver's error for a lost connection.
        """
        self._connect = connect
        self._failure = failure
        self._lock = threading.Lock()
        self._idle: list[Driver] = []

    def one(self, statement: Statement, values: Values) -> object:
        """Return the row of a statement, or None; raises the driver's errors.

        If an idle connection was lost, the query is repeated on a new one.
        """
        with self._lock:
            driver = self._idle.pop() if self._idle else None
        if driver is not None:
            try:
                return self._run(driver, statement, values)
            except self._failure:
                self.close()
        return self._run(self._connect(), statement, values)

    def _run(self, driver: Driver, statement: Statement, values: Values) -> object:
        try:
            row = statement.ask(driver, values)
        except BaseException:
            with contextlib.suppress(Exception):
                driver.close()
            raise
        with self._lock:
            keep = len(self._idle) < KEPT
            if keep:
                self._idle.append(driver)
        if not keep:
            driver.close()
        return row

    def close(self) -> None:
        """Close the idle connections."""
        with self._lock:
            idle, self._idle = self._idle, []
        for driver in idle:
            with contextlib.suppress(Exception):
                driver.close()
