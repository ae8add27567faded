"""Store the number of a category in each known dataset, and the instance number of a label."""

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "dataset_numbers",
        sa.Column("dataset", sa.String(64), primary_key=True),
        sa.Column("category", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("number", sa.Integer, nullable=False),
        sa.UniqueConstraint("dataset", "number"),
    )
    op.add_column("labels", sa.Column("instance", sa.Integer, nullable=True))


def downgrade() -> None:
    op.drop_table("dataset_numbers")
    with op.batch_alter_table("labels") as labels:
        labels.drop_column("instance")
