"""Recordings are grouped in projects, with people's roles and a queue of tasks.

All existing recordings are in the first project, "default".
"""

import time

import sqlalchemy as sa
from alembic import op

revision = "0015"
down_revision = "0014"


def upgrade() -> None:
    project = sa.Column("project", sa.String(64), nullable=True)
    op.add_column("sequences", project)
    op.create_index("sequences_project", "sequences", ["project"])
    made = op.create_table(
        "projects",
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("created", sa.Double, nullable=False),
        sa.Column("categories", sa.Text, nullable=True),
    )
    op.bulk_insert(made, [{"id": "default", "name": "Default", "created": time.time()}])
    op.create_table(
        "project_roles",
        _project(),
        sa.Column("account", sa.String(256), primary_key=True),
        sa.Column("role", sa.String(16), nullable=False),
    )
    op.create_table(
        "tasks",
        _project(),
        sa.Column("number", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("sequence", sa.Integer, sa.ForeignKey("sequences.number"), nullable=False),
        sa.Column("first", sa.Integer, nullable=False),
        sa.Column("last", sa.Integer, nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("assignee", sa.String(256), nullable=True),
        sa.Column("reviewer", sa.String(256), nullable=True),
        sa.Column("note", sa.Text, nullable=False),
        sa.Column("frame", sa.Integer, nullable=True),
        sa.Column("place", sa.Text, nullable=True),
        sa.Column("created", sa.Double, nullable=False),
        sa.Column("changed", sa.Double, nullable=False),
        sa.Column("batch", sa.String(36), nullable=True),
    )
    op.create_index("tasks_queue", "tasks", ["project", "state", "number"])
    op.create_index("tasks_sequence", "tasks", ["sequence"])
    op.create_table(
        "task_events",
        _project(),
        sa.Column("task", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("number", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("time", sa.Double, nullable=False),
        sa.Column("author", sa.String(256), nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("assignee", sa.String(256), nullable=True),
        sa.Column("note", sa.Text, nullable=False),
        sa.ForeignKeyConstraint(["project", "task"], ["tasks.project", "tasks.number"]),
    )


def _project() -> sa.Column[str]:
    return sa.Column("project", sa.String(64), sa.ForeignKey("projects.id"), primary_key=True)


def downgrade() -> None:
    for table in ("task_events", "tasks", "project_roles", "projects"):
        op.drop_table(table)
    op.drop_index("sequences_project", "sequences")
    with op.batch_alter_table("sequences") as sequences:
        sequences.drop_column("project")
