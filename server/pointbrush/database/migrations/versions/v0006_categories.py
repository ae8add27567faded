"""Categories have one number in all recordings of a workspace."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    # Empty: a category gets its number at its first export, in the order of the palette, which
    # equals the earlier numbers of a workspace with one recording.
    op.create_table(
        "categories",
        sa.Column("number", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("name", sa.String(256), nullable=False, unique=True),
        sa.Column("color", sa.String(7), nullable=False),
    )


def downgrade() -> None:
    op.drop_table("categories")
