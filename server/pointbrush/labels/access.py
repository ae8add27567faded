"""Roles of people in projects and their recordings, asked at every call."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, field

from sqlalchemy import case, select

from pointbrush.labels.database import Database
from pointbrush.labels.project_tables import project_roles, tasks
from pointbrush.labels.projects import OVERSEES, role_in
from pointbrush.labels.schema import LIVE, PROJECT_OF, WHOLE, sequences
from pointbrush.roles import Role, includes

COMPARES: Role = "reviewer"
"""Role that sees everybody's copies of a recording."""
REFRESH_SECONDS = 1.0
"""Longest time for which a change by another server is not seen."""


@dataclass(frozen=True, slots=True)
class _Known:
    """Roles of each project that has any, and its recordings, as of a moment.

    ``copies``: those who have tasks in each copy for one person.
    """

    roles: Mapping[str, Mapping[str, Role]] = field(default_factory=dict)
    projects: Mapping[str, str] = field(default_factory=dict)
    copies: Mapping[str, frozenset[str]] = field(default_factory=dict)
    read: float = -REFRESH_SECONDS


class Access:
    """Roles of people in the recordings of one database; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._lock = threading.Lock()
        self._known = _Known()

    def to_sequence(self, sequence: str, account: str, role: Role) -> Role | None:
        """Role in a recording of an account that has ``role`` in the workspace; None: none."""
        if includes(role, OVERSEES):
            return role
        found = self._in(sequence, account, role)
        if found is None:  # until a moment ago: nobody waits for what they were just given
            self.forget()
            found = self._in(sequence, account, role)
        return found

    def _in(self, sequence: str, account: str, role: Role) -> Role | None:
        known = self._look()
        people = known.copies.get(sequence)
        if people is not None and account not in people and not includes(role, COMPARES):
            return None
        project = known.projects.get(sequence)
        return role if project is None else role_in(known.roles[project], account, role)

    def to_project(self, project: str, account: str, role: Role) -> Role | None:
        """The same in a project."""
        if includes(role, OVERSEES):
            return role
        return role_in(self._look().roles.get(project, {}), account, role)

    def forget(self) -> None:
        """Look anew at the next call."""
        with self._lock:
            self._known = _Known()

    def _look(self) -> _Known:
        with self._lock:
            if time.monotonic() - self._known.read < REFRESH_SECONDS:
                return self._known
            roles: dict[str, dict[str, Role]] = {}
            closed = select(project_roles.c.project)
            # Deleted ones first: one that is there may have the id of one that was deleted.
            held = (
                select(sequences.c.id, PROJECT_OF.label("project"))
                .where(PROJECT_OF.in_(closed))
                .order_by(case((LIVE, 1), else_=0))
            )
            of_copies = (
                select(sequences.c.id, tasks.c.assignee)
                .join(tasks, tasks.c.sequence == sequences.c.number, isouter=True)
                .where(~WHOLE)
            )
            with self._database.read() as connection:
                for row in connection.execute(select(project_roles)):
                    roles.setdefault(row.project, {})[row.account] = row.role
                found = {row.id: row.project for row in connection.execute(held)} if roles else {}
                copies: dict[str, set[str]] = {}
                for row in connection.execute(of_copies):
                    copies.setdefault(row.id, set()).add(row.assignee or "")
            people = {name: frozenset(each) for name, each in copies.items()}
            self._known = _Known(roles, found, people, time.monotonic())
            return self._known
