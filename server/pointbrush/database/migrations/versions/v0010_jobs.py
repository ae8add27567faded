"""Store jobs, so that they outlive the server that ran them."""

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "jobs",
        sa.Column("id", sa.String(36), primary_key=True),
        sa.Column("kind", sa.String(16), nullable=False),
        sa.Column("sequence", sa.String(128)),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("progress", sa.Double, nullable=False),
        sa.Column("message", sa.Text, nullable=False),
        sa.Column("result", sa.Text),
        sa.Column("error", sa.Text),
        sa.Column("created", sa.Double, nullable=False),
        sa.Column("author", sa.String(256)),
        sa.Column("edit", sa.String(128)),
        sa.Column("request", sa.Text),
        sa.Column("lost", sa.Integer, nullable=False),
        sa.Column("wish", sa.String(8), nullable=False),
        sa.Column("host", sa.Text, nullable=False),
        sa.Column("process", sa.Integer, nullable=False),
        sa.Column("owner", sa.String(16), nullable=False),
        sa.Column("beat", sa.Double, nullable=False),
    )
    op.create_index("jobs_state", "jobs", ["state", "created"])


def downgrade() -> None:
    op.drop_table("jobs")
