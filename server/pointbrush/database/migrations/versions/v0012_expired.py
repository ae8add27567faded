"""Store when the expiry of a deleted recording was first seen."""

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"


def upgrade() -> None:
    op.add_column("sequences", sa.Column("expired", sa.Double, nullable=True))


def downgrade() -> None:
    with op.batch_alter_table("sequences") as sequences:
        sequences.drop_column("expired")
