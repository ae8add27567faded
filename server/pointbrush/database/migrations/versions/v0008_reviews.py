"""Reviews of frames and labels, and assigned frames."""

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "reviews",
        sa.Column("sequence", sa.Integer, sa.ForeignKey("sequences.number"), primary_key=True),
        sa.Column("number", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("time", sa.Double, nullable=False),
        sa.Column("author", sa.String(256), nullable=False),
        sa.Column("revision", sa.BigInteger, nullable=False),
        sa.Column("first", sa.Integer, nullable=True),
        sa.Column("last", sa.Integer, nullable=True),
        sa.Column("label", sa.Integer, nullable=False),
        sa.Column("state", sa.String(16), nullable=True),
        sa.Column("note", sa.Text, nullable=True),
        sa.Column("place", sa.Text, nullable=True),
        sa.Column("assignee", sa.String(256), nullable=True),
    )


def downgrade() -> None:
    op.drop_table("reviews")
