"""The database engine: SQLite or PostgreSQL by URL, durable transactions, translated errors."""

from __future__ import annotations

import contextlib
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from sqlalchemy import (
    Connection,
    Engine,
    Index,
    Table,
    create_engine,
    event,
    exc,
    make_url,
    text,
)
from sqlalchemy.engine import URL

from pointbrush.database.private_copy import PrivateCopy
from pointbrush.database.statements import (
    Driver,
    Look,
    Statement,
    Values,
    dialect_of,
    driver_of,
    insert,
)
from pointbrush.errors import BadInputError, ReadOnlyError, UnavailableError
from pointbrush.system.permissions import file_writable, writable

if TYPE_CHECKING:
    import psycopg  # slow to import; SQLAlchemy imports it for PostgreSQL

BUSY_SECONDS = 10.0
"""Longest wait of a SQLite writer for another process's transaction."""
KEEPALIVE_PROBES = 3
READ_ONLY_TRANSACTION = "25006"
"""SQLSTATE of a write to a read-only database."""
READ_ONLY = "the labels are read-only: they can be viewed and exported, not changed"
CHUNK = 500
"""Values in one IN list; SQLite allows 32,766 parameters, older builds 999."""

# FULL: every commit waits until the write-ahead log is on the disk (fsync), so that an acknowledged
# edit survives a power loss.  The upkeep thread makes checkpoints; the automatic one only limits
# the log if that thread could not run.
BUSY_PAUSE_SECONDS = 0.01
WRITE_AHEAD = "PRAGMA journal_mode=WAL"
SQLITE_PRAGMAS = (
    "PRAGMA synchronous=FULL",
    "PRAGMA fullfsync=ON",  # macOS: flushes the drive's cache; no effect on other systems
    "PRAGMA wal_autocheckpoint=16384",
    "PRAGMA cache_size=-8192",
    "PRAGMA temp_store=MEMORY",
)


@dataclass(frozen=True)
class Limits:
    """Timeouts for PostgreSQL; a parameter in the URL has precedence."""

    statement_seconds: int = 60
    """Timeout of a statement, including the time it waits for locks."""
    keepalive_seconds: int = 30
    """Idle time until a connection is probed; it counts as lost after twice this time."""


class Database:
    """Connections and transactions of one label database; thread-safe."""

    def __init__(self, url: str, limits: Limits | None = None) -> None:
        """Open ``sqlite:///path`` or ``postgresql://…``.

        A SQLite file without write permission is opened as a private copy, which can be migrated;
        ``seal`` it before edits are accepted.

        Raises BadInputError for another URL, UnavailableError when it cannot be reached.
        """
        self.url = _parse(url)
        self.sqlite = self.url.get_backend_name() == "sqlite"
        self._copy = _private_copy(Path(str(self.url.database))) if self.sqlite else None
        self._sealed = False
        if self._copy is not None:
            self.url = self.url.set(database=str(self._copy.path))
        # SQLite allows one writer.  This lock wakes the next thread at once; SQLite itself polls.
        self._writer: contextlib.AbstractContextManager[Any] = (
            threading.Lock() if self.sqlite else contextlib.nullcontext()
        )
        self.timed: Callable[[str, float], None] | None = None
        """Callback for each transaction: "read" or "write", and its duration in seconds."""
        self.limits = limits or Limits()
        self.engine = (
            _sqlite_engine(self.url) if self.sqlite else _postgres_engine(self.url, self.limits)
        )
        dbapi: Any = self.engine.dialect.loaded_dbapi
        self.driver_error: type[Exception] = dbapi.Error
        """Base class of the driver's errors."""
        self.failures = (exc.DBAPIError, exc.TimeoutError, self.driver_error)
        """Errors of the database itself, which make the transaction unusable."""
        self._look = Look(self._driver, self.driver_error)

    def ping(self) -> None:
        """Read one row; raises UnavailableError."""
        with self.read() as connection:
            connection.execute(text("SELECT 1")).scalar()

    @property
    def path(self) -> Path | None:
        """The SQLite file, or None."""
        return Path(str(self.url.database)) if self.sqlite else None

    def listener(self) -> psycopg.Connection[Any]:
        """Return a separate connection to PostgreSQL in autocommit mode, for ``LISTEN``."""
        args, fields = self.engine.dialect.create_connect_args(self.url)
        waits = patience(self.url, self.limits)
        dbapi: Any = self.engine.dialect.loaded_dbapi
        listener: psycopg.Connection[Any] = dbapi.connect(
            *args, **{**fields, **waits}, autocommit=True
        )
        return listener

    def look(self, statement: Statement, values: Values) -> Any:
        """Return the current row of a short query, or None; raises UnavailableError."""
        with self._translated():
            return self._look.one(statement, values)

    def _driver(self) -> Driver:
        """Return a connection of the driver in autocommit mode."""
        if self.sqlite:
            return sqlite3.connect(
                str(self.url.database),
                timeout=BUSY_SECONDS,
                isolation_level=None,
                check_same_thread=False,
            )
        connection = self.listener()
        connection.execute(f"SET statement_timeout TO '{self.limits.statement_seconds}s'")
        return connection

    def seal(self) -> None:
        """Refuse writes to a private copy from now on, as they would be lost."""
        self._sealed = self._copy is not None

    def require_writable(self) -> None:
        """Raise ReadOnlyError if the database is read-only; raises UnavailableError."""
        if self._sealed:
            raise ReadOnlyError(READ_ONLY)
        if not self.sqlite:
            with self.read() as connection:
                if connection.execute(text("SHOW transaction_read_only")).scalar() == "on":
                    raise ReadOnlyError(READ_ONLY)

    @contextlib.contextmanager
    def read(self) -> Iterator[Connection]:
        """Open a transaction with a consistent snapshot; raises UnavailableError."""
        options = {} if self.sqlite else {"isolation_level": "REPEATABLE READ"}
        with self._timed("read"), self._translated(), self.engine.connect() as connection:
            connection = connection.execution_options(**options)
            with connection.begin():
                yield connection

    @contextlib.contextmanager
    def write(self, *, begun: bool = True, erases: bool = False) -> Iterator[Connection]:
        """Open a transaction that is durable when the context ends; raises UnavailableError.

        Any error rolls it back.  ``begun`` False: it begins with ``statements.begin`` and commits
        with ``statements.commit``, so that both can be sent with other statements; uncommitted
        changes are rolled back.  ``erases``: SQLite overwrites the rows that are deleted.  Raises
        ReadOnlyError if the database is read-only.
        """
        if self._sealed:
            raise ReadOnlyError(READ_ONLY)
        with (
            self._timed("write"),
            self._writer,
            self._translated(),
            self.engine.connect() as connection,
        ):
            by_hand = not begun and not self.sqlite
            how = {"isolation_level": "AUTOCOMMIT"} if by_hand else {}
            connection = connection.execution_options(writes=True, **how)
            try:
                with connection.begin():
                    try:
                        if erases and self.sqlite:
                            driver_of(connection).execute("PRAGMA secure_delete=ON")
                        yield connection
                    finally:
                        if by_hand and not connection.invalidated:
                            driver_of(connection).rollback()
            except (exc.DBAPIError, self.driver_error):
                # After a full disk or a lost server the state of the connection is unknown.
                connection.invalidate()
                raise

    @contextlib.contextmanager
    def _translated(self) -> Iterator[None]:
        try:
            yield
        except self.failures as error:
            cause = getattr(error, "orig", error)
            if getattr(cause, "sqlstate", None) == READ_ONLY_TRANSACTION:
                raise ReadOnlyError(READ_ONLY) from error
            raise _unavailable(error) from error

    @contextlib.contextmanager
    def _timed(self, kind: str) -> Iterator[None]:
        begun = time.perf_counter()
        try:
            yield
        finally:
            if self.timed is not None:
                self.timed(kind, time.perf_counter() - begun)

    def now(self, connection: Connection) -> float:
        """Return the time, seconds since the epoch, by a clock that all servers share."""
        if self.sqlite:
            return time.time()
        return float(connection.execute(text("SELECT extract(epoch FROM now())")).scalar_one())

    def insert_new(self, connection: Connection, index: Index, row: dict[str, Any]) -> bool:
        """Insert a row unless it violates the unique ``index``; return whether it was inserted."""
        table = cast(Table, index.table)
        where = index.dialect_options[dialect_of(sqlite=self.sqlite).name]["where"]
        statement: Any = insert(table, sqlite=self.sqlite)
        columns = [column.name for column in index.columns]
        statement = statement.on_conflict_do_nothing(index_elements=columns, index_where=where)
        done = connection.execute(
            statement.values(row), execution_options={"preserve_rowcount": True}
        )
        return done.rowcount > 0

    def empty_log(self) -> None:
        """Write SQLite's write-ahead log to the database and empty it; raises UnavailableError.

        Readers of other processes can prevent it; the log is then emptied later.
        """
        if self.sqlite and not self._sealed:
            with self._translated(), contextlib.closing(self._driver()) as driver:
                driver.execute("PRAGMA wal_checkpoint(TRUNCATE)")

    def close(self) -> None:
        """Close all connections."""
        self._look.close()
        self.engine.dispose()
        if self._copy is not None:
            self._copy.close()


def _private_copy(path: Path) -> PrivateCopy | None:
    """Return a copy of a database without write permission; None if it is writable."""
    if path.exists():
        return None if file_writable(path) else PrivateCopy(path)
    return PrivateCopy(path) if path.parent.is_dir() and not writable(path.parent) else None


def _unavailable(error: Exception) -> UnavailableError:
    """Translate an error; the address of an unreachable server is only for its operator."""
    cause = getattr(error, "orig", None) or error
    reason = str(cause).strip().splitlines()[0] if str(cause).strip() else type(cause).__name__
    public, private = reason, ""
    if getattr(cause, "sqlstate", "") is None:  # an error of psycopg itself
        public, private = "its server cannot be reached", reason
    return UnavailableError(
        f"the label database cannot be used now, nothing was changed: {public}", private=private
    )


def _parse(url: str) -> URL:
    try:
        parsed = make_url(url)
        backend = parsed.get_backend_name()
    except (exc.ArgumentError, ValueError):  # the error's text may quote a part of the password
        backend = ""
    if backend == "sqlite" and parsed.database and parsed.database != ":memory:":
        return parsed.set(drivername="sqlite+pysqlite")
    if backend in ("postgresql", "postgres"):
        return parsed.set(drivername="postgresql+psycopg")
    raise BadInputError(
        "database: expected sqlite:///path or postgresql://host/name, got "
        f"{url.partition('://')[0][:40]!r} and something else"
    )


def _sqlite_engine(url: URL) -> Engine:
    engine = create_engine(
        url,
        connect_args={"timeout": BUSY_SECONDS, "check_same_thread": False},
        pool_size=8,
        max_overflow=24,
    )

    @event.listens_for(engine, "connect")
    def configure(connection: Any, _: Any) -> None:
        connection.isolation_level = None  # transactions begin below, not in the driver
        _write_ahead(connection)
        for pragma in SQLITE_PRAGMAS:
            connection.execute(pragma)

    @event.listens_for(engine, "begin")
    def begin(connection: Connection) -> None:
        writes = connection.get_execution_options().get("writes")
        driver_of(connection).execute("BEGIN IMMEDIATE" if writes else "BEGIN")

    return engine


def _write_ahead(connection: sqlite3.Connection) -> None:
    """Enable the write-ahead log; SQLite does not wait if another process enables it meanwhile."""
    end = time.monotonic() + BUSY_SECONDS
    while True:
        try:
            connection.execute(WRITE_AHEAD)
        except sqlite3.OperationalError as error:
            busy = error.sqlite_errorcode & 0xFF == sqlite3.SQLITE_BUSY
            if not busy or time.monotonic() > end:
                raise
            time.sleep(BUSY_PAUSE_SECONDS)
        else:
            return


def patience(url: URL, limits: Limits) -> dict[str, int]:
    """Return libpq's parameters for timeouts of a connection without an answer."""
    probes = {
        "connect_timeout": 10,
        "keepalives": 1,
        "keepalives_idle": limits.keepalive_seconds,
        "keepalives_interval": max(1, limits.keepalive_seconds // KEEPALIVE_PROBES),
        "keepalives_count": KEEPALIVE_PROBES,
        "tcp_user_timeout": 2000 * limits.keepalive_seconds,  # milliseconds
    }
    return {name: value for name, value in probes.items() if name not in url.query}


def _postgres_engine(url: URL, limits: Limits) -> Engine:
    engine = create_engine(
        url,
        connect_args=patience(url, limits),
        pool_pre_ping=True,
        pool_size=8,
        max_overflow=24,
    )

    @event.listens_for(engine, "connect")
    def configure(connection: Any, _: Any) -> None:
        row = connection.execute("SHOW synchronous_commit").fetchone()
        if row[0] == "off":  # an acknowledged edit must be durable, despite the server's default
            connection.execute("SET synchronous_commit TO on")
        connection.execute(f"SET statement_timeout TO '{limits.statement_seconds}s'")
        connection.commit()

    return engine
