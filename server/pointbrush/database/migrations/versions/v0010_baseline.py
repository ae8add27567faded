"""The tables of schema 0010, which earlier migrations made step by step."""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = None

Kind = type[sa.types.TypeEngine[Any]] | sa.types.TypeEngine[Any]


def _sequence() -> sa.Column[int]:
    return sa.Column("sequence", sa.Integer, sa.ForeignKey("sequences.number"), primary_key=True)


def _key(name: str, kind: type[sa.types.TypeEngine[int]] = sa.Integer) -> sa.Column[int]:
    return sa.Column(name, kind, primary_key=True, autoincrement=False)


def _name(length: int, name: str = "id") -> sa.Column[str]:
    return sa.Column(name, sa.String(length), primary_key=True)


def _need(name: str, kind: Kind) -> sa.Column[Any]:
    return sa.Column(name, kind, nullable=False)


def _unique(name: str, length: int) -> sa.Column[str]:
    return sa.Column(name, sa.String(length), nullable=False, unique=True)


def _unique_where(name: str, table: str, column: str, condition: str) -> None:
    where = sa.text(condition)
    op.create_index(name, table, [column], unique=True, sqlite_where=where, postgresql_where=where)


def _process() -> tuple[sa.Column[Any], ...]:
    """Return the columns of the process that does a row's work."""
    return (
        _need("host", sa.Text),
        _need("process", sa.Integer),
        _need("owner", sa.String(16)),
        _need("beat", sa.Double),
    )


def upgrade() -> None:
    _create_journal()
    _create_state()
    _create_people()
    _create_work()


def _create_journal() -> None:
    op.create_table(
        "sequences",
        sa.Column("number", sa.Integer, primary_key=True, autoincrement=True),
        _need("id", sa.String(128)),
        _need("revision", sa.BigInteger),
        _need("highest_label", sa.Integer),
        _need("points", sa.LargeBinary),
        sa.Column("identity", sa.String(16)),
        sa.Column("deleted", sa.Double),
        sqlite_autoincrement=True,
    )
    _unique_where("sequences_live", "sequences", "id", "deleted IS NULL")
    op.create_table(
        "edits",
        _sequence(),
        _key("revision", sa.BigInteger),
        _need("id", sa.String(128)),
        _need("author", sa.String(256)),
        _need("time", sa.Double),
        _need("kind", sa.String(32)),
        _need("summary", sa.Text),
        _need("points", sa.BigInteger),
        _need("frames", sa.Text),
        _need("labels", sa.Text),
        _need("tracks", sa.Boolean),
        sa.Column("target", sa.BigInteger),
        _need("state", sa.SmallInteger),
        _need("redone", sa.BigInteger),
        sa.UniqueConstraint("sequence", "id", name="edits_id"),
    )
    op.create_index("edits_stack", "edits", ["sequence", "author", "state", "revision"])
    op.create_index("edits_redone", "edits", ["sequence", "redone"])
    op.create_table(
        "edit_blocks",
        _sequence(),
        _key("revision", sa.BigInteger),
        _key("frame"),
        _key("layer", sa.SmallInteger),
        _key("block"),
        _need("data", sa.LargeBinary),
    )
    op.create_index(
        "edit_blocks_place", "edit_blocks", ["sequence", "frame", "layer", "block", "revision"]
    )
    op.create_table(
        "edit_labels",
        _sequence(),
        _key("revision", sa.BigInteger),
        _key("label"),
        _need("fields", sa.Text),
    )
    op.create_index("edit_labels_label", "edit_labels", ["sequence", "label", "revision"])
    op.create_table(
        "edit_tracks",
        _sequence(),
        _key("revision", sa.BigInteger),
        _key("frame"),
        _key("label"),
        _need("data", sa.Text),
    )
    op.create_index("edit_tracks_place", "edit_tracks", ["sequence", "frame", "label", "revision"])


def _create_state() -> None:
    op.create_table(
        "snapshots",
        _sequence(),
        _key("frame"),
        _key("layer", sa.SmallInteger),
        _key("block"),
        _need("revision", sa.BigInteger),
        _need("data", sa.LargeBinary),
    )
    op.create_table(
        "labels",
        _sequence(),
        _key("id"),
        _need("name", sa.Text),
        _need("category", sa.Text),
        _need("color", sa.String(7)),
        _need("locked", sa.Boolean),
        _need("visible", sa.Boolean),
        sa.Column("instance", sa.Integer),
        sa.Column("position", sa.Integer),
    )
    op.create_table("tracks", _sequence(), _key("frame"), _key("label"), _need("data", sa.Text))
    op.create_table(
        "counts",
        _sequence(),
        _key("frame"),
        _key("label"),
        _need("points", sa.BigInteger),
        _need("painted", sa.BigInteger),
        _need("held", sa.BigInteger),
    )
    op.create_table("frame_changes", _sequence(), _key("frame"), _need("revision", sa.BigInteger))
    op.create_table(
        "categories",
        _key("number"),
        _unique("name", 256),
        _need("color", sa.String(7)),
    )
    op.create_table(
        "dataset_numbers",
        _name(64, "dataset"),
        _key("category"),
        _need("number", sa.Integer),
        sa.UniqueConstraint("dataset", "number"),
    )


def _create_people() -> None:
    op.create_table(
        "tokens",
        _name(16),
        _need("role", sa.String(16)),
        _need("name", sa.Text),
        _unique("digest", 64),
        _need("created", sa.Double),
        sa.Column("expires", sa.Double),
        sa.Column("revoked", sa.Double),
        sa.Column("account", sa.String(256), nullable=False, server_default=""),
    )
    op.create_table("accounts", _name(256), _need("name", sa.Text))
    op.create_table(
        "sign_ins",
        _name(64, "digest"),
        sa.Column("token", sa.String(16)),
        _need("owner", sa.String(64)),
        _need("account", sa.String(256)),
        _need("created", sa.Double),
        _need("expires", sa.Double),
    )
    op.create_table(
        "reviews",
        _sequence(),
        _key("number"),
        _need("time", sa.Double),
        _need("author", sa.String(256)),
        _need("revision", sa.BigInteger),
        sa.Column("first", sa.Integer),
        sa.Column("last", sa.Integer),
        _need("label", sa.Integer),
        sa.Column("state", sa.String(16)),
        sa.Column("note", sa.Text),
        sa.Column("place", sa.Text),
        sa.Column("assignee", sa.String(256)),
    )


def _create_work() -> None:
    op.create_table(
        "works",
        _name(32),
        _need("sequence", sa.String(128)),
        _need("kind", sa.String(16)),
        *_process(),
    )
    _unique_where("works_import", "works", "sequence", "kind = 'import'")
    op.create_table(
        "jobs",
        _name(36),
        _need("kind", sa.String(16)),
        sa.Column("sequence", sa.String(128)),
        _need("state", sa.String(16)),
        _need("progress", sa.Double),
        _need("message", sa.Text),
        sa.Column("result", sa.Text),
        sa.Column("error", sa.Text),
        _need("created", sa.Double),
        sa.Column("author", sa.String(256)),
        sa.Column("edit", sa.String(128)),
        sa.Column("request", sa.Text),
        _need("lost", sa.Integer),
        _need("wish", sa.String(8)),
        *_process(),
    )
    op.create_index("jobs_state", "jobs", ["state", "created"])
