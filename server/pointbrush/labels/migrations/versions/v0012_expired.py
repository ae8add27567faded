"""Deleted recordings note when their time to be restored was first seen to be over."""

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("sequences", sa.Column("expired", sa.Double, nullable=True))


def downgrade() -> None:
    with op.batch_alter_table("sequences") as sequences:
        sequences.drop_column("expired")
