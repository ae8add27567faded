"""Labels have a position in their palette."""

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("labels", sa.Column("position", sa.Integer, nullable=True))


def downgrade() -> None:
    with op.batch_alter_table("labels") as labels:
        labels.drop_column("position")
