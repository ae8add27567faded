"""Keyboard shortcuts of the page's commands by account."""

import sqlalchemy as sa
from alembic import op

revision = "0020"
down_revision = "0019"


def upgrade() -> None:
    op.create_table(
        "own_keys",
        sa.Column("account", sa.String(256), primary_key=True),
        sa.Column("keys", sa.Text, nullable=False),
    )


def downgrade() -> None:
    op.drop_table("own_keys")
