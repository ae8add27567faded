"""Studies of labelling: participants, their steps, copies of recordings and logs."""

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
        sa.Column("step", sa.Integer, nullable=False),
        sa.Column("began", sa.Double),
        sa.Column("paused", sa.Double),
        sa.Column("paused_s", sa.Double, nullable=False),
        sa.Column("records", sa.Integer, nullable=False),
        sa.Column("seen", sa.Double),
        sa.UniqueConstraint("study", "number"),
    )
    op.create_table(
        "study_steps",
        *_keys("step"),
        sa.Column("began", sa.Double, nullable=False),
        sa.Column("ended", sa.Double, nullable=False),
        sa.Column("paused_s", sa.Double, nullable=False),
        sa.Column("answers", sa.Text, nullable=False),
    )
    op.create_table(
        "study_copies", *_keys("step"), sa.Column("sequence", sa.Integer, nullable=False)
    )
    op.create_index("study_copies_sequence", "study_copies", ["sequence"])
    op.create_table(
        "study_log",
        *_keys("first"),
        sa.Column("received", sa.Double, nullable=False),
        sa.Column("records", sa.LargeBinary, nullable=False),
    )


def _keys(number: str) -> tuple[sa.Column[str], sa.Column[int]]:
    participant = sa.ForeignKey("study_participants.account")
    return (
        sa.Column("participant", sa.String(64), participant, primary_key=True),
        sa.Column(number, sa.Integer, primary_key=True, autoincrement=False),
    )


def downgrade() -> None:
    for table in ("study_log", "study_copies", "study_steps", "study_participants"):
        op.drop_table(table)
