"""Identify recordings by their import, delete and restore them, and guard work on them."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    if op.get_bind().dialect.name == "sqlite":
        _make_sequences_anew()
    else:
        op.drop_constraint("sequences_id_key", "sequences", type_="unique")
        op.add_column("sequences", sa.Column("identity", sa.String(16)))
        op.add_column("sequences", sa.Column("deleted", sa.Double))
    live = sa.text("deleted IS NULL")
    op.create_index(
        "sequences_live", "sequences", ["id"],
        unique=True, sqlite_where=live, postgresql_where=live,
    )  # fmt: skip
    op.create_table(
        "works",
        sa.Column("id", sa.String(32), primary_key=True),
        sa.Column("sequence", sa.String(128), nullable=False),
        sa.Column("kind", sa.String(16), nullable=False),
        sa.Column("host", sa.Text, nullable=False),
        sa.Column("process", sa.Integer, nullable=False),
        sa.Column("owner", sa.String(16), nullable=False),
        sa.Column("beat", sa.Double, nullable=False),
    )
    imports = sa.text("kind = 'import'")
    op.create_index(
        "works_import", "works", ["sequence"],
        unique=True, sqlite_where=imports, postgresql_where=imports,
    )  # fmt: skip


def _make_sequences_anew() -> None:
    """Copy the table, as SQLite cannot drop the unique constraint of the id."""
    op.create_table(
        "sequences_0002",
        sa.Column("number", sa.Integer, primary_key=True, autoincrement=True),
        sa.Column("id", sa.String(128), nullable=False),
        sa.Column("revision", sa.BigInteger, nullable=False),
        sa.Column("highest_label", sa.Integer, nullable=False),
        sa.Column("points", sa.LargeBinary, nullable=False),
        sa.Column("identity", sa.String(16)),
        sa.Column("deleted", sa.Double),
        sqlite_autoincrement=True,
    )
    op.execute(
        "INSERT INTO sequences_0002 (number, id, revision, highest_label, points) "
        "SELECT number, id, revision, highest_label, points FROM sequences"
    )
    op.drop_table("sequences")
    op.rename_table("sequences_0002", "sequences")


def downgrade() -> None:
    raise NotImplementedError("two recordings may have had one id: restore a backup instead")
