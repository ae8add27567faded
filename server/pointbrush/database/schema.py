"""The tables, and the migrations of older databases to them.

The journal (``edits`` and ``edit_*``) is authoritative; the other tables are derived from it.
Every change here needs a migration (``migrations/versions``); a test compares the two.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    Connection,
    Double,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    SmallInteger,
    String,
    Table,
    Text,
    UniqueConstraint,
    false,
    func,
    inspect,
    text,
)

from pointbrush.database.database import Database
from pointbrush.database.project_tables import FIRST
from pointbrush.database.study_tables import metadata as metadata
from pointbrush.errors import BadInputError

BASELINE, HEAD = "0010", "0024"
"""The migration that makes the tables of a new database, and the one that results in these."""

# States of an edit.  Only ACTIVE ones can be undone, only UNDONE ones redone.
ACTIVE = 0
UNDONE = 1
DROPPED = 2
"""Undone, and followed by a new edit of its author: it cannot be redone."""
KEPT = 3
"""In force, but its author can no longer undo it (a label that others use)."""
INERT = 4
"""Nothing to undo: it changed nothing, or it is itself an undo or redo."""

IN_FORCE = (ACTIVE, KEPT)

MIGRATIONS = Path(__file__).parent / "migrations"
_ADVISORY_LOCK = 0x706F696E74  # "point": one process migrates a PostgreSQL database at a time


def _sequence() -> Column[int]:
    return Column("sequence", Integer, ForeignKey("sequences.number"), primary_key=True)


LIVE = text("deleted IS NULL")
_IMPORTS = text("kind = 'import'")

sequences = Table(
    "sequences",
    metadata,
    Column("number", Integer, primary_key=True, autoincrement=True),
    Column("id", String(128), nullable=False),
    Column("revision", BigInteger, nullable=False),
    Column("highest_label", Integer, nullable=False),
    Column("points", LargeBinary, nullable=False),
    Column("identity", String(16)),  # of the import; NULL until it is registered
    Column("deleted", Double),  # seconds since the epoch, or NULL
    Column("expired", Double),  # when its expiry was first seen, or NULL
    Column("project", String(64)),  # NULL: the first one, "default"
    Column("copy_of", Integer),  # here and below: for a copy for one person; else NULL
    Column("copy_kind", String(16)),
    Index("sequences_project", "project"),
    Index("sequences_live", "id", unique=True, sqlite_where=LIVE, postgresql_where=LIVE),
    sqlite_autoincrement=True,
)

PROJECT_OF: Any = func.coalesce(sequences.c.project, FIRST)
"""Project of a row of ``sequences``."""
WHOLE = sequences.c.copy_of.is_(None)
"""A row of ``sequences`` is no copy for one person."""

edits = Table(
    "edits",
    metadata,
    _sequence(),
    Column("revision", BigInteger, primary_key=True, autoincrement=False),
    Column("id", String(128), nullable=False),
    Column("author", String(256), nullable=False),
    Column("time", Double, nullable=False),
    Column("kind", String(32), nullable=False),
    Column("summary", Text, nullable=False),
    Column("points", BigInteger, nullable=False),
    Column("frames", Text, nullable=False),  # JSON list of frame numbers
    Column("labels", Text, nullable=False),  # JSON list of palette entries it changed
    Column("tracks", Boolean, nullable=False),
    Column("target", BigInteger),  # revision that an undo or redo reverses
    Column("state", SmallInteger, nullable=False),
    Column("redone", BigInteger, nullable=False),  # revision of its last redo, or 0
    Column("boxes", Boolean, nullable=False, server_default=false()),  # whether it changed any
    UniqueConstraint("sequence", "id", name="edits_id"),
    Index("edits_stack", "sequence", "author", "state", "revision"),
    Index("edits_redone", "sequence", "redone"),
)

edit_blocks = Table(
    "edit_blocks",
    metadata,
    _sequence(),
    Column("revision", BigInteger, primary_key=True, autoincrement=False),
    Column("frame", Integer, primary_key=True, autoincrement=False),
    Column("layer", SmallInteger, primary_key=True, autoincrement=False),
    Column("block", Integer, primary_key=True, autoincrement=False),
    Column("data", LargeBinary, nullable=False),
    Index("edit_blocks_place", "sequence", "frame", "layer", "block", "revision"),
)

edit_labels = Table(
    "edit_labels",
    metadata,
    _sequence(),
    Column("revision", BigInteger, primary_key=True, autoincrement=False),
    Column("label", Integer, primary_key=True, autoincrement=False),
    Column("fields", Text, nullable=False),  # JSON object of the fields it set
    Index("edit_labels_label", "sequence", "label", "revision"),
)

edit_tracks = Table(
    "edit_tracks",
    metadata,
    _sequence(),
    Column("revision", BigInteger, primary_key=True, autoincrement=False),
    Column("frame", Integer, primary_key=True, autoincrement=False),
    Column("label", Integer, primary_key=True, autoincrement=False),
    Column("data", Text, nullable=False),  # JSON object
    Index("edit_tracks_place", "sequence", "frame", "label", "revision"),
)

edit_boxes = Table(
    "edit_boxes",
    metadata,
    _sequence(),
    Column("revision", BigInteger, primary_key=True, autoincrement=False),
    Column("box", Integer, primary_key=True, autoincrement=False),
    Column("data", Text, nullable=False),  # JSON object of the changes
    Index("edit_boxes_box", "sequence", "box", "revision"),
)

snapshots = Table(
    "snapshots",
    metadata,
    _sequence(),
    Column("frame", Integer, primary_key=True, autoincrement=False),
    Column("layer", SmallInteger, primary_key=True, autoincrement=False),
    Column("block", Integer, primary_key=True, autoincrement=False),
    Column("revision", BigInteger, nullable=False),
    Column("data", LargeBinary, nullable=False),
)

labels = Table(
    "labels",
    metadata,
    _sequence(),
    Column("id", Integer, primary_key=True, autoincrement=False),
    Column("name", Text, nullable=False),
    Column("category", Text, nullable=False),  # the key of its class, "" for none
    Column("color", String(7), nullable=False),
    Column("locked", Boolean, nullable=False),
    Column("visible", Boolean, nullable=False),
    Column("instance", Integer, nullable=True),
    Column("position", Integer, nullable=True),
)

tracks = Table(
    "tracks",
    metadata,
    _sequence(),
    Column("frame", Integer, primary_key=True, autoincrement=False),
    Column("label", Integer, primary_key=True, autoincrement=False),
    Column("data", Text, nullable=False),
)

boxes = Table(
    "boxes",
    metadata,
    _sequence(),
    Column("id", Integer, primary_key=True, autoincrement=False),
    Column("label", Integer, nullable=False),
    Column("data", Text, nullable=False),  # JSON object: label, size, poses, …
)

counts = Table(
    "counts",
    metadata,
    _sequence(),
    Column("frame", Integer, primary_key=True, autoincrement=False),
    Column("label", Integer, primary_key=True, autoincrement=False),
    Column("points", BigInteger, nullable=False),
    Column("painted", BigInteger, nullable=False),
    Column("held", BigInteger, nullable=False),  # points, including deleted ones
)

frame_changes = Table(
    "frame_changes",
    metadata,
    _sequence(),
    Column("frame", Integer, primary_key=True, autoincrement=False),
    Column("revision", BigInteger, nullable=False),  # of the last visible change
)

reviews = Table(
    "reviews",
    metadata,
    _sequence(),
    Column("number", Integer, primary_key=True, autoincrement=False),  # 1, 2, … by time
    Column("time", Double, nullable=False),
    Column("author", String(256), nullable=False),
    Column("revision", BigInteger, nullable=False),  # reviewed revision of the sequence
    Column("first", Integer),  # frames first to last; NULL: a label as a whole
    Column("last", Integer),
    Column("label", Integer, nullable=False),  # 0: the frames themselves
    Column("state", String(16)),  # here and below: NULL keeps the value
    Column("note", Text),
    Column("place", Text),  # JSON [x, y, z], position of the note
    Column("assignee", String(256)),
)

tokens = Table(
    "tokens",
    metadata,
    Column("id", String(16), primary_key=True),
    Column("role", String(16), nullable=False),
    Column("name", Text, nullable=False),
    Column("digest", String(64), nullable=False, unique=True),
    Column("created", Double, nullable=False),
    Column("expires", Double),
    Column("revoked", Double),
    Column("account", String(256), nullable=False, server_default=""),
)

accounts = Table(
    "accounts",
    metadata,
    Column("id", String(256), primary_key=True),
    Column("name", Text, nullable=False),
)

categories = Table(
    "categories",
    metadata,
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("name", String(256), nullable=False, unique=True),
    Column("color", String(7), nullable=False),
    Column("size", Text),  # JSON [length, width, height], mean of its objects, or NULL
    Column("spread", Text),  # the same, standard deviation
    Column("key", String(512), nullable=False, server_default=""),  # in labels; the first name
    Column("merged", Integer),  # NULL: no; 0: deleted; else the number of the target
    Column("renamed", BigInteger, nullable=False, server_default="0"),  # number of the last change
    Index("categories_key", "key", unique=True),
)

box_attributes = Table(
    "box_attributes",
    metadata,
    Column("name", String(64), primary_key=True),
    Column("position", Integer, nullable=False),
    Column("kind", String(8), nullable=False),
    Column("scope", String(8), nullable=False),
    Column("choices", Text, nullable=False),  # JSON list of texts
)

dataset_numbers = Table(
    "dataset_numbers",
    metadata,
    Column("dataset", String(64), primary_key=True),
    Column("category", Integer, primary_key=True, autoincrement=False),
    Column("number", Integer, nullable=False),
    Column("stated", Boolean, nullable=False, server_default=false()),  # by a person
    UniqueConstraint("dataset", "number"),
)

sign_ins = Table(
    "sign_ins",
    metadata,
    Column("digest", String(64), primary_key=True),
    Column("token", String(16)),  # of a person; NULL: the server's own
    Column("owner", String(64), nullable=False),  # digest of the server's own token
    Column("account", String(256), nullable=False),
    Column("created", Double, nullable=False),
    Column("expires", Double, nullable=False),
)

signing_keys = Table(
    "signing_keys",
    metadata,
    Column("purpose", String(32), primary_key=True),
    Column("key", LargeBinary, nullable=False),
)

own_keys = Table(
    "own_keys",
    metadata,
    Column("account", String(256), primary_key=True),
    Column("keys", Text, nullable=False),  # JSON object: key by command of the page
)

headset_reports = Table(
    "headset_reports",
    metadata,
    Column("id", String(32), primary_key=True),
    Column("account", String(256), nullable=False),
    Column("received", Double, nullable=False),  # seconds since the epoch
    Column("report", Text, nullable=False),  # JSON
)

works = Table(
    "works",
    metadata,
    Column("id", String(32), primary_key=True),
    Column("sequence", String(128), nullable=False),  # an id that may not exist yet
    Column("kind", String(16), nullable=False),
    Column("host", Text, nullable=False),
    Column("process", Integer, nullable=False),
    Column("owner", String(16), nullable=False),  # random id of the process
    Column("beat", Double, nullable=False),  # last heartbeat, seconds since the epoch
    Index(
        "works_import", "sequence", unique=True, sqlite_where=_IMPORTS, postgresql_where=_IMPORTS
    ),
)

jobs = Table(
    "jobs",
    metadata,
    Column("id", String(36), primary_key=True),
    Column("kind", String(16), nullable=False),
    Column("sequence", String(128)),  # an id that may not exist yet
    Column("state", String(16), nullable=False),
    Column("progress", Double, nullable=False),
    Column("message", Text, nullable=False),
    Column("result", Text),  # JSON object
    Column("error", Text),
    Column("created", Double, nullable=False),
    Column("author", String(256)),
    Column("edit", String(128)),  # id of the edit that it makes
    Column("request", Text),  # JSON object that restarts it, or NULL
    Column("lost", Integer, nullable=False),  # servers that died while it ran
    Column("wish", String(8), nullable=False),  # request from another server
    Column("host", Text, nullable=False),  # here and below as in works
    Column("process", Integer, nullable=False),
    Column("owner", String(16), nullable=False),  # "": none, free to be restarted
    Column("beat", Double, nullable=False),
    Index("jobs_state", "state", "created"),
)

PER_SEQUENCE = (
    edit_blocks,
    edit_labels,
    edit_tracks,
    edit_boxes,
    snapshots,
    labels,
    tracks,
    boxes,
    counts,
    frame_changes,
    reviews,
    edits,
)
"""Tables with rows of a sequence, child tables first."""


def migrate(database: Database) -> None:
    """Run the missing migrations in one transaction.

    Raises BadInputError for a database of a newer pointbrush, or from before ``BASELINE``, and
    UnavailableError.
    """
    with database.read() as connection:
        if _version(connection) == HEAD:
            return
    with database.write() as connection:
        if not database.sqlite:
            # A migration rewrites tables and waits for another process's migration: both can be
            # slow.
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
    # Imported here: an up-to-date database opens without the time to import Alembic.
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
        remedy = "it was written by a newer pointbrush"
        if found < BASELINE:
            remedy = "open it once with pointbrush 0.1.0, which upgrades it"
        raise BadInputError(
            f"database: expected schema version {BASELINE} to {HEAD}, got {found}; {remedy}"
        )
    command.upgrade(config, "head")
