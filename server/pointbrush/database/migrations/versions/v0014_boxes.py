"""Oriented boxes: the changes by each edit, and the current boxes."""

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"


def upgrade() -> None:
    op.add_column(
        "edits", sa.Column("boxes", sa.Boolean, nullable=False, server_default=sa.false())
    )
    op.create_table(
        "edit_boxes",
        sa.Column("sequence", sa.Integer, sa.ForeignKey("sequences.number"), primary_key=True),
        sa.Column("revision", sa.BigInteger, primary_key=True, autoincrement=False),
        sa.Column("box", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("data", sa.Text, nullable=False),
    )
    op.create_index("edit_boxes_box", "edit_boxes", ["sequence", "box", "revision"])
    op.create_table(
        "boxes",
        sa.Column("sequence", sa.Integer, sa.ForeignKey("sequences.number"), primary_key=True),
        sa.Column("id", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("label", sa.Integer, nullable=False),
        sa.Column("data", sa.Text, nullable=False),
    )


def downgrade() -> None:
    op.drop_table("boxes")
    op.drop_table("edit_boxes")
    with op.batch_alter_table("edits") as edits:
        edits.drop_column("boxes")
