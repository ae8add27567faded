"""Copies of recordings for one person: the original recording, and the kind of copy."""

import sqlalchemy as sa
from alembic import op

revision = "0018"
down_revision = "0017"


def upgrade() -> None:
    op.add_column("sequences", sa.Column("copy_of", sa.Integer, nullable=True))
    op.add_column("sequences", sa.Column("copy_kind", sa.String(16), nullable=True))


def downgrade() -> None:
    with op.batch_alter_table("sequences") as sequences:
        sequences.drop_column("copy_kind")
        sequences.drop_column("copy_of")
