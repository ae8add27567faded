"""Reports of headset checks."""

import sqlalchemy as sa
from alembic import op

revision = "0022"
down_revision = "0021"


def upgrade() -> None:
    op.create_table(
        "headset_reports",
        sa.Column("id", sa.String(32), primary_key=True),
        sa.Column("account", sa.String(256), nullable=False),
        sa.Column("received", sa.Double, nullable=False),
        sa.Column("report", sa.Text, nullable=False),
    )


def downgrade() -> None:
    op.drop_table("headset_reports")
