"""Projects have webhooks, and an outbox of events for them."""

import sqlalchemy as sa
from alembic import op

revision = "0019"
down_revision = "0018"


def upgrade() -> None:
    op.create_table(
        "webhooks",
        sa.Column("id", sa.String(16), primary_key=True),
        sa.Column("project", sa.String(64), sa.ForeignKey("projects.id"), nullable=False),
        sa.Column("url", sa.Text, nullable=False),
        sa.Column("topics", sa.Text, nullable=False),
        sa.Column("secret", sa.String(64), nullable=False),
        sa.Column("created", sa.Double, nullable=False),
    )
    op.create_table(
        "webhook_cursors",
        sa.Column("webhook", sa.String(16), sa.ForeignKey("webhooks.id"), primary_key=True),
        sa.Column("sequence", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("revision", sa.BigInteger, nullable=False),
    )
    op.create_table(
        "webhook_events",
        sa.Column("id", sa.String(36), primary_key=True),
        sa.Column("webhook", sa.String(16), sa.ForeignKey("webhooks.id"), nullable=False),
        sa.Column("topic", sa.String(16), nullable=False),
        sa.Column("body", sa.Text, nullable=False),
        sa.Column("created", sa.Double, nullable=False),
        sa.Column("due", sa.Double, nullable=False),
        sa.Column("attempts", sa.Integer, nullable=False),
        sa.Column("delivered", sa.Double, nullable=True),
        sa.Column("error", sa.Text, nullable=False),
    )
    op.create_index("webhook_events_due", "webhook_events", ["delivered", "due"])


def downgrade() -> None:
    for table in ("webhook_events", "webhook_cursors", "webhooks"):
        op.drop_table(table)
