"""Backups of a live database as one SQLite file, and restoring them."""

from __future__ import annotations

import contextlib
import json
import os
import sqlite3
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Select, Table, delete, func, insert, select, text

from pointbrush.database.class_names import read_names, with_category
from pointbrush.database.database import Database
from pointbrush.database.job_records import INTERRUPTED, UNDER_WAY
from pointbrush.database.project_tables import metadata, projects
from pointbrush.database.schema import (
    LIVE,
    PER_SEQUENCE,
    categories,
    dataset_numbers,
    migrate,
    sequences,
    signing_keys,
    tokens,
)
from pointbrush.errors import BadInputError, ConflictError, NotFoundError, UnavailableError
from pointbrush.formats.tables.datasets import DATASETS
from pointbrush.names import is_plain

ROWS = 256
"""Rows copied at once: they hold up to a few hundred kilobytes each."""
_CONTINUE_NUMBERS = (
    "SELECT setval(pg_get_serial_sequence('sequences', 'number'), "
    "(SELECT coalesce(max(number), 1) FROM sequences))"
)

_INTERRUPT = "UPDATE jobs SET state = 'failed', error = ? WHERE state IN (?, ?)"
"""End the jobs in a copy that were running when it was made."""


def back_up(database: Database, target: Path) -> None:
    """Write a consistent copy of a database in use to ``target``, a new SQLite file.

    The file appears complete or not at all.  Raises ConflictError when ``target`` exists,
    UnavailableError when it cannot be written.
    """
    if target.exists():
        raise ConflictError(f"backup: expected a file that does not exist yet, got {target}")
    partial = target.with_name(f".{target.name}.partial")
    partial.unlink(missing_ok=True)
    try:
        if database.path is not None:
            _copy_file(database.path, partial)
        else:
            _copy_to_file(database, partial)
        with contextlib.closing(sqlite3.connect(partial)) as copy:
            copy.execute("PRAGMA journal_mode=DELETE")  # no files beside the database
            copy.execute(_INTERRUPT, (INTERRUPTED, *UNDER_WAY))
            copy.execute("DELETE FROM works")
            copy.commit()
        with partial.open("rb+") as file:
            os.fsync(file.fileno())
        partial.rename(target)
    except (sqlite3.Error, OSError) as error:
        raise UnavailableError(f"backup: {target} cannot be written: {error}") from error
    finally:
        for leftover in target.parent.glob(f"{partial.name}*"):
            leftover.unlink(missing_ok=True)


def move(source_url: str, target_url: str) -> None:
    """Copy the database at one URL into the empty database at another, in one transaction.

    A SQLite source is locked for writing meanwhile.  Raises ConflictError when the target has
    sequences or tokens already, UnavailableError.
    """
    source, target = Database(source_url), Database(target_url)
    try:
        migrate(source)
        migrate(target)
        with source.write() if source.sqlite else source.read() as reader:
            _fill(target, reader)
    finally:
        source.close()
        target.close()


def _fill(target: Database, reader: Connection) -> None:
    with target.write() as writer:
        _copy_rows(reader, writer)
        if not target.sqlite:
            writer.execute(text(_CONTINUE_NUMBERS))


def restore_sequence(
    source: Path,
    database: Database,
    sequence: str,
    target: str,
    identity: str,
    put: Callable[[], object],
) -> dict[str, dict[str, int]]:
    """Restore one sequence of a backup with its history as the separate import ``target``.

    Its labels get the classes with the same key in this database, or else with the same name.
    Returns the numbers of these classes in known datasets in the backup, by their names in this
    database.  ``put`` runs before the commit; an error it raises rolls the restore back.  Raises
    BadInputError when ``source`` is no backup, NotFoundError when the sequence is not in it.
    """
    with _opened(source) as original, original.read() as reader, database.write() as writer:
        query = select(sequences).where(sequences.c.id == sequence, LIVE)
        row = reader.execute(query).mappings().one_or_none()
        if row is None:
            raise NotFoundError(f"backup: expected labels of {sequence!r}, there are none")
        fields = {name: value for name, value in row.items() if name != "number"}
        there = select(projects.c.id).where(projects.c.id == row["project"])
        fields |= {"copy_of": None, "copy_kind": None}  # they refer to the other database
        fields["project"] = writer.execute(there).scalar()  # None: the first project
        made = writer.execute(insert(sequences), fields | {"id": target, "identity": identity})
        key = made.inserted_primary_key
        assert key is not None  # noqa: S101 - of an autoincrement column
        theirs, ours = read_names(reader), read_names(writer)
        used: dict[str, str] = {}

        def key_of(there: str) -> str:
            named = ours.key(ours.meaning(theirs.name(there)))
            return used.setdefault(there, there if there in ours.shown else named)

        def moved(row: Mapping[str, Any]) -> dict[str, Any]:
            row_here = {**with_category(row, key_of), "sequence": key[0]}
            if "fields" in row:
                row_here["fields"] = json.dumps(with_category(json.loads(row["fields"]), key_of))
            return row_here

        for table in reversed(PER_SEQUENCE):
            wanted = select(table).where(table.c.sequence == row["number"])
            _copy_table(reader, writer, table, wanted, moved)
        put()
        return _numbers_of(reader, {there: ours.name(ours_key) for there, ours_key in used.items()})


def _numbers_of(reader: Connection, names: dict[str, str]) -> dict[str, dict[str, int]]:
    """Read the numbers of classes in known datasets; ``names``: class names by key."""
    found: dict[str, dict[str, int]] = {}
    rows = select(categories.c.key, dataset_numbers.c.dataset, dataset_numbers.c.number).join(
        dataset_numbers, dataset_numbers.c.category == categories.c.number
    )
    for key, dataset, number in reader.execute(rows):
        if key in names and dataset in DATASETS:
            found.setdefault(dataset, {})[names[key]] = number
    return found


def restore(source: Path, url: str) -> None:
    """Fill the database at ``url``, which must be empty or new, from a backup.

    Raises BadInputError when ``source`` is no backup, ConflictError when the database has
    sequences or tokens already, UnavailableError.
    """
    with _opened(source) as original:
        target = Database(url)
        try:
            migrate(target)
            with original.read() as reader:
                _fill(target, reader)
        finally:
            target.close()


def restore_file(source: Path, target: Path) -> None:
    """Copy a backup to the new SQLite file ``target`` and migrate it; raises BadInputError."""
    _copied(source, target).close()


@contextlib.contextmanager
def _opened(source: Path) -> Iterator[Database]:
    """Yield a migrated copy of a backup; the backup itself is not changed."""
    with tempfile.TemporaryDirectory() as folder:
        original = _copied(source, Path(folder) / "copy.sqlite")
        try:
            yield original
        finally:
            original.close()


def _copied(source: Path, target: Path) -> Database:
    """Copy a backup, migrate the copy and end its jobs.

    Raises BadInputError for a file that is no backup, or for ids in it that escape the folder.
    """
    _require_backup(source)
    try:
        _copy_file(source, target)
    except sqlite3.Error as error:
        raise BadInputError(f"backup: {source} is damaged: {error}") from None
    copy = Database(f"sqlite:///{target}")
    try:
        migrate(copy)
        with copy.write() as connection:
            connection.exec_driver_sql(_INTERRUPT, (INTERRUPTED, *UNDER_WAY))
            for row in connection.execute(select(sequences.c.id, sequences.c.identity)):
                if not (is_plain(row.id) and is_plain(row.identity)):
                    raise BadInputError(f"backup: expected the id of a recording, got {row.id!r}")
    except BaseException:
        copy.close()
        raise
    return copy


def _require_backup(source: Path) -> None:
    if not source.is_file():
        raise BadInputError(f"backup: expected a file, {source} does not exist")
    try:
        with contextlib.closing(sqlite3.connect(f"file:{source}?mode=ro", uri=True)) as file:
            file.execute("SELECT version_num FROM alembic_version").fetchone()
    except sqlite3.Error as error:
        raise BadInputError(f"backup: expected a label database, got {source}: {error}") from None


def _copy_file(source: Path, target: Path) -> None:
    with (
        contextlib.closing(sqlite3.connect(source)) as live,
        contextlib.closing(sqlite3.connect(target)) as copy,
    ):
        live.backup(copy)


def _copy_to_file(database: Database, target: Path) -> None:
    copy = Database(f"sqlite:///{target}")
    try:
        migrate(copy)
        with database.read() as reader, copy.write() as writer:
            _copy_rows(reader, writer)
    finally:
        copy.close()


def _copy_rows(reader: Connection, writer: Connection) -> None:
    for table in (sequences, tokens):
        if writer.execute(select(func.count()).select_from(table)).scalar():
            raise ConflictError(f"restore: expected an empty database, it has {table.name}")
    # The target may have a signing key and has the first project; the source's rows replace both,
    # as its browsers use its key.
    for table in (signing_keys, projects):
        writer.execute(delete(table))
    for table in metadata.sorted_tables:
        _copy_table(reader, writer, table, select(table), dict)


def _copy_table(
    reader: Connection,
    writer: Connection,
    table: Table,
    wanted: Select[Any],
    changed: Callable[[Any], dict[str, Any]],
) -> None:
    """Copy the ``wanted`` rows, with ``changed`` applied to each."""
    rows = reader.execution_options(yield_per=ROWS).execute(wanted)
    for part in rows.mappings().partitions(ROWS):
        writer.execute(insert(table), list(map(changed, part)))
