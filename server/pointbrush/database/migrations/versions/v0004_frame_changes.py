"""The revision of each frame's last change, taken from the journal."""

import json

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0002"
branch_labels = None
depends_on = None

ROWS = 1000
"""Rows read or written at once."""


def upgrade() -> None:
    made = op.create_table(
        "frame_changes",
        sa.Column("sequence", sa.Integer, sa.ForeignKey("sequences.number"), primary_key=True),
        sa.Column("frame", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("revision", sa.BigInteger, nullable=False),
    )
    last: dict[tuple[int, int], int] = {}
    connection = op.get_bind()
    query = "SELECT sequence, revision, frames FROM edits ORDER BY sequence, revision"
    for rows in connection.execute(sa.text(query)).partitions(ROWS):
        for sequence, number, frames in rows:
            last.update(((sequence, frame), number) for frame in json.loads(frames))
    found = [
        {"sequence": sequence, "frame": frame, "revision": number}
        for (sequence, frame), number in last.items()
    ]
    for first in range(0, len(found), ROWS):
        connection.execute(sa.insert(made), found[first : first + ROWS])


def downgrade() -> None:
    op.drop_table("frame_changes")
