"""A project's labels have named versions: a revision and a palette of each recording."""

import sqlalchemy as sa
from alembic import op

revision = "0017"
down_revision = "0016"


def upgrade() -> None:
    op.create_table(
        "versions",
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("project", sa.String(64), sa.ForeignKey("projects.id"), nullable=False),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("created", sa.Double, nullable=False),
        sa.Column("author", sa.String(256), nullable=False),
    )
    op.create_index("versions_project", "versions", ["project"])
    op.create_table(
        "version_recordings",
        sa.Column("version", sa.String(64), sa.ForeignKey("versions.id"), primary_key=True),
        sa.Column("sequence", sa.Integer, sa.ForeignKey("sequences.number"), primary_key=True),
        sa.Column("revision", sa.BigInteger, nullable=False),
        sa.Column("palette", sa.Text, nullable=False),
    )


def downgrade() -> None:
    op.drop_table("version_recordings")
    op.drop_table("versions")
