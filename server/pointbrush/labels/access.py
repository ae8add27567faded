"""Roles of people in projects and their recordings, asked at every call."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, field

from sqlalchemy import case, select

from pointbrush.labels.database import Database
from pointbrush.labels.project_tables import project_roles
from pointbrush.labels.projects import OVERSEES, role_in
from pointbrush.labels.schema import LIVE, PROJECT_OF, sequences
from pointbrush.roles import Role, includes

REFRESH_SECONDS = 1.0
"""Longest time for which a change by another server is not seen."""


@dataclass(frozen=True, slots=True)
class _Known:
    """Roles of each project that has any, and its recordings, as of a moment."""

    roles: Mapping[str, Mapping[str, Role]] = field(default_factory=dict)
    projects: Mapping[str, str] = field(default_factory=dict)
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
        known = self._look()
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
            with self._database.read() as connection:
                for row in connection.execute(select(project_roles)):
                    roles.setdefault(row.project, {})[row.account] = row.role
                found = {row.id: row.project for row in connection.execute(held)} if roles else {}
            self._known = _Known(roles, found, time.monotonic())
            return self._known
