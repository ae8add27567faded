"""Rows of projects and tasks that registering or erasing a recording changes as well."""

from __future__ import annotations

from contextlib import suppress

from sqlalchemy import ColumnElement, Connection, delete, select, tuple_, update

from pointbrush.database.project_tables import projects, task_events, tasks
from pointbrush.database.schema import LIVE, sequences
from pointbrush.errors import NotFoundError

LONGEST_NAME = 200
"""Limit of the characters in the name of a project or a version."""
REMOVED = ".removed"
"""Project of deleted recordings after the removal of their closed project: only managers see them.
No project can have this id."""


def lock_project(connection: Connection, project: str) -> None:
    """Lock a project's queue and settings until the commit; raises NotFoundError."""
    row = select(projects.c.id).where(projects.c.id == project).with_for_update()
    if connection.execute(row).first() is None:
        raise NotFoundError(f"project: expected a known id, got {project!r}")


def forget_tasks(connection: Connection, gone: ColumnElement[bool]) -> None:
    """Delete the tasks that match ``gone``, with their history."""
    keys = select(tasks.c.project, tasks.c.number).where(gone)
    of_them = tuple_(task_events.c.project, task_events.c.task).in_(keys)
    connection.execute(delete(task_events).where(of_them))
    connection.execute(delete(tasks).where(gone))


def put_in(connection: Connection, project: str, sequence: str) -> None:
    """Put a new recording into a project; without one of this id it stays in the first project."""
    with suppress(NotFoundError):
        lock_project(connection, project)
        row = update(sequences).where(sequences.c.id == sequence, LIVE)
        connection.execute(row.values(project=project))
