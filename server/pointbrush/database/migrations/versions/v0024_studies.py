"""Studies of labelling: participants and their logs."""

import sqlalchemy as sa
from alembic import op

revision = "0024"
down_revision = "0023"


def upgrade() -> None:
    op.create_table(
        "study_participants",
        sa.Column("account", sa.String(64), primary_key=True),
        sa.Column("study", sa.String(64), nullable=False),
        sa.Column("number", sa.Integer, nullable=False),
        sa.Column("digest", sa.String(64), nullable=False, unique=True),
        sa.Column("conditions", sa.Text, nullable=False),
        sa.Column("finished", sa.Text, nullable=False),
        sa.Column("copies", sa.Text, nullable=False),
        sa.Column("began", sa.Double),
        sa.Column("paused", sa.Double),
        sa.Column("paused_s", sa.Double, nullable=False),
        sa.Column("records", sa.Integer, nullable=False),
        sa.UniqueConstraint("study", "number"),
    )
    account = sa.ForeignKey("study_participants.account")
    op.create_table(
        "study_log",
        sa.Column("participant", sa.String(64), account, primary_key=True),
        sa.Column("first", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("received", sa.Double, nullable=False),
        sa.Column("records", sa.LargeBinary, nullable=False),
    )


def downgrade() -> None:
    op.drop_table("study_log")
    op.drop_table("study_participants")
