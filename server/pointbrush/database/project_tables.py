"""The tables of projects: people's roles, tasks, versions and webhooks."""

from __future__ import annotations

from sqlalchemy import (
    BigInteger,
    Column,
    Double,
    ForeignKey,
    ForeignKeyConstraint,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
)

metadata = MetaData()
FIRST = "default"
"""The project of recordings without another project; it cannot be deleted."""


def _project() -> Column[str]:
    return Column("project", String(64), ForeignKey("projects.id"), primary_key=True)


projects = Table(
    "projects",
    metadata,
    Column("id", String(64), primary_key=True),
    Column("name", Text, nullable=False),
    Column("created", Double, nullable=False),
    Column("categories", Text),  # JSON list of the taxonomy's numbers; NULL: all
)

project_roles = Table(
    "project_roles",
    metadata,
    _project(),
    Column("account", String(256), primary_key=True),
    Column("role", String(16), nullable=False),
)

tasks = Table(
    "tasks",
    metadata,
    _project(),
    Column("number", Integer, primary_key=True, autoincrement=False),  # 1, 2, … of the project
    Column("sequence", Integer, ForeignKey("sequences.number"), nullable=False),
    Column("first", Integer, nullable=False),  # frames first to last, both included
    Column("last", Integer, nullable=False),
    Column("state", String(16), nullable=False),
    Column("assignee", String(256)),
    Column("reviewer", String(256)),
    Column("note", Text, nullable=False),
    Column("frame", Integer),  # here and below: position of the note
    Column("place", Text),  # JSON [x, y, z], source coordinates
    Column("created", Double, nullable=False),
    Column("changed", Double, nullable=False),
    Column("batch", String(36)),  # id of the request that made it, against duplicates
    Index("tasks_queue", "project", "state", "number"),
    Index("tasks_sequence", "sequence"),
)

task_events = Table(
    "task_events",
    metadata,
    _project(),
    Column("task", Integer, primary_key=True, autoincrement=False),
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("time", Double, nullable=False),
    Column("author", String(256), nullable=False),
    Column("state", String(16), nullable=False),
    Column("assignee", String(256)),
    Column("note", Text, nullable=False),
    ForeignKeyConstraint(["project", "task"], ["tasks.project", "tasks.number"]),
)

versions = Table(
    "versions",
    metadata,
    Column("id", String(64), primary_key=True),
    Column("project", String(64), ForeignKey("projects.id"), nullable=False),
    Column("name", Text, nullable=False),
    Column("created", Double, nullable=False),
    Column("author", String(256), nullable=False),
    Index("versions_project", "project"),
)

version_recordings = Table(
    "version_recordings",
    metadata,
    Column("version", String(64), ForeignKey("versions.id"), primary_key=True),
    Column("sequence", Integer, ForeignKey("sequences.number"), primary_key=True),
    Column("revision", BigInteger, nullable=False),
    Column("palette", Text, nullable=False),  # JSON list of the labels at that time
)

webhooks = Table(
    "webhooks",
    metadata,
    Column("id", String(16), primary_key=True),
    Column("project", String(64), ForeignKey("projects.id"), nullable=False),
    Column("url", Text, nullable=False),
    Column("topics", Text, nullable=False),  # JSON list
    Column("secret", String(64), nullable=False),
    Column("created", Double, nullable=False),
)

webhook_cursors = Table(
    "webhook_cursors",
    metadata,
    Column("webhook", String(16), ForeignKey("webhooks.id"), primary_key=True),
    Column("sequence", Integer, primary_key=True, autoincrement=False),
    Column("revision", BigInteger, nullable=False),  # last announced revision
)

webhook_events = Table(
    "webhook_events",
    metadata,
    Column("id", String(36), primary_key=True),
    Column("webhook", String(16), ForeignKey("webhooks.id"), nullable=False),
    Column("topic", String(16), nullable=False),
    Column("body", Text, nullable=False),
    Column("created", Double, nullable=False),
    Column("due", Double, nullable=False),  # earliest time of the next attempt
    Column("attempts", Integer, nullable=False),
    Column("delivered", Double),
    Column("error", Text, nullable=False),
    Index("webhook_events_due", "delivered", "due"),
)
