"""Attributes that boxes may have, and the sizes of the classes' objects."""

import sqlalchemy as sa
from alembic import op

revision = "0016"
down_revision = "0015"


def upgrade() -> None:
    op.create_table(
        "box_attributes",
        sa.Column("name", sa.String(64), primary_key=True),
        sa.Column("position", sa.Integer, nullable=False),
        sa.Column("kind", sa.String(8), nullable=False),
        sa.Column("scope", sa.String(8), nullable=False),
        sa.Column("choices", sa.Text, nullable=False),
    )
    op.add_column("categories", sa.Column("size", sa.Text, nullable=True))
    op.add_column("categories", sa.Column("spread", sa.Text, nullable=True))


def downgrade() -> None:
    with op.batch_alter_table("categories") as categories:
        categories.drop_column("spread")
        categories.drop_column("size")
    op.drop_table("box_attributes")
