"""The first schema."""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None


def _sequence() -> sa.Column[int]:
    return sa.Column("sequence", sa.Integer, sa.ForeignKey("sequences.number"), primary_key=True)


def _key(name: str, kind: type[sa.types.TypeEngine[int]] = sa.Integer) -> sa.Column[int]:
    return sa.Column(name, kind, primary_key=True, autoincrement=False)


def _need(
    name: str, kind: type[sa.types.TypeEngine[Any]] | sa.types.TypeEngine[Any]
) -> sa.Column[Any]:
    return sa.Column(name, kind, nullable=False)


def upgrade() -> None:
    op.create_table(
        "sequences",
        sa.Column("number", sa.Integer, primary_key=True, autoincrement=True),
        sa.Column("id", sa.String(128), nullable=False, unique=True),
        _need("revision", sa.BigInteger),
        _need("highest_label", sa.Integer),
        _need("points", sa.LargeBinary),
        sqlite_autoincrement=True,
    )
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
    op.create_table(
        "tokens",
        sa.Column("id", sa.String(16), primary_key=True),
        _need("role", sa.String(16)),
        _need("name", sa.Text),
        sa.Column("digest", sa.String(64), nullable=False, unique=True),
        _need("created", sa.Double),
        sa.Column("expires", sa.Double),
        sa.Column("revoked", sa.Double),
    )


def downgrade() -> None:
    for name in (
        "tokens", "counts", "tracks", "labels", "snapshots", "edit_tracks", "edit_labels",
        "edit_blocks", "edits", "sequences",
    ):  # fmt: skip
        op.drop_table(name)
