"""Projects: groups of recordings with people, roles and selected categories."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from sqlalchemy import Connection, delete, func, insert, select, update

from pointbrush.accounts.accounts import require_name
from pointbrush.accounts.roles import ROLES, Role, includes
from pointbrush.database.database import CHUNK, Database
from pointbrush.database.lost_answers import write_once
from pointbrush.database.project_rows import LONGEST_NAME, REMOVED, forget_tasks, lock_project
from pointbrush.database.project_tables import (
    FIRST,
    project_roles,
    projects,
    tasks,
    version_recordings,
    versions,
    webhooks,
)
from pointbrush.database.schema import LIVE, PROJECT_OF, WHOLE, categories, sequences
from pointbrush.errors import BadInputError, ConflictError, NotFoundError
from pointbrush.labels.classes.selection import selected
from pointbrush.names import require_visible
from pointbrush.teamwork.webhooks import forget_webhooks
from pointbrush.values.base import UNSET
from pointbrush.values.team.projects import ProjectPatch

MOST_PROJECTS = 1_000
"""Limit for a workspace, as the list of projects is read and sent as a whole."""
OVERSEES: Role = "manager"
"""Role in the workspace that includes access to every project."""
_ID = re.compile("[a-z0-9][a-z0-9._-]{0,63}")


@dataclass(frozen=True, slots=True)
class Project:
    """A group of recordings.

    ``roles``: role in the project by account; if empty, all people have their workspace role.
    ``categories``: numbers of the selected categories, None: all.  ``recordings``: their ids.
    """

    id: str
    name: str
    created: float = 0.0
    categories: tuple[int, ...] | None = None
    roles: Mapping[str, Role] = field(default_factory=dict)
    recordings: tuple[str, ...] = ()

    def role_of(self, account: str, role: Role) -> Role | None:
        """Return the role in the project of an account with ``role`` in the workspace, or None."""
        return role_in(self.roles, account, role)


def role_in(roles: Mapping[str, Role], account: str, role: Role) -> Role | None:
    """Return the lower of the roles in project and workspace; managers keep theirs everywhere."""
    if not roles or includes(role, OVERSEES):
        return role
    own = roles.get(account)
    return None if own is None else min(own, role, key=ROLES.index)


class Projects:
    """The projects of one database; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def all(self) -> list[Project]:
        """Return all projects, by name."""
        with self._database.read() as connection:
            known = _projects(connection)
        return sorted(known, key=lambda each: (each.name.lower(), each.id))

    def get(self, project: str) -> Project:
        """Return a project; raises NotFoundError."""
        with self._database.read() as connection:
            return _project(connection, project)

    def create(self, project: str, change: ProjectPatch) -> Project:
        """Create a project with a new id.

        Raises ConflictError if the id is taken, BadInputError for too many projects.
        """
        if not _ID.fullmatch(project):
            raise BadInputError(
                f"id: expected up to 64 letters a-z, digits, '.', '_' and '-', got {project!r}"
            )
        _check(change)
        row = {"id": project, "name": change.name or project}

        def make(connection: Connection) -> Project:
            if connection.execute(select(projects.c.id).where(projects.c.id == project)).first():
                raise ConflictError(f"id: expected one of no project yet, got {project!r}")
            lock_project(connection, FIRST)  # serializes the count among servers
            count = connection.execute(select(func.count()).select_from(projects)).scalar_one()
            if count >= MOST_PROJECTS:
                raise BadInputError(f"projects: expected at most {MOST_PROJECTS:,} in a workspace")
            connection.execute(insert(projects), row | {"created": self._database.now(connection)})
            _apply(connection, project, change)
            return _project(connection, project)

        return write_once(self._database, make, lambda connection: _found(connection, project))

    def change(self, project: str, change: ProjectPatch) -> Project:
        """Apply a change; raises NotFoundError (project, recording, category).

        Raises ConflictError for a recording that has tasks in another project.
        """
        _check(change)
        with self._database.write() as connection:
            lock_project(connection, project)
            _apply(connection, project, change)
            return _project(connection, project)

    def remove(self, project: str) -> None:
        """Delete a project; raises ConflictError if it has recordings."""
        if project == FIRST:
            raise ConflictError(
                f"project: expected another than {FIRST!r}, which cannot be deleted"
            )
        with self._database.write() as connection:
            lock_project(connection, project)
            members = select(sequences.c.id).where(project == PROJECT_OF, LIVE)
            if (one := connection.execute(members.limit(1)).scalar()) is not None:
                raise ConflictError(
                    f"project: expected one without recordings, {project!r} has {one!r}: "
                    "move them to another project first"
                )
            people = select(project_roles.c.account).where(project_roles.c.project == project)
            closed = connection.execute(people.limit(1)).first() is not None
            gone = update(sequences).where(sequences.c.project == project)
            value = REMOVED if closed else None
            connection.execute(gone.values(project=value))  # deleted recordings
            forget_tasks(connection, tasks.c.project == project)
            named = select(versions.c.id).where(versions.c.project == project)
            held_then = version_recordings.c.version.in_(named)
            connection.execute(delete(version_recordings).where(held_then))
            connection.execute(delete(versions).where(versions.c.project == project))
            forget_webhooks(connection, webhooks.c.project == project)
            connection.execute(delete(project_roles).where(project_roles.c.project == project))
            connection.execute(delete(projects).where(projects.c.id == project))

    def selection(self, sequence: str) -> frozenset[str] | None:
        """Return the names of the selected categories of a recording's project; None: all."""
        query = select(sequences.c.number).where(sequences.c.id == sequence, LIVE)
        with self._database.read() as connection:
            return selected(connection, connection.execute(query).scalar() or 0)


def _found(connection: Connection, project: str) -> Project | None:
    try:
        return _project(connection, project)
    except NotFoundError:
        return None


def _project(connection: Connection, project: str) -> Project:
    for known in _projects(connection, project):
        return known
    raise NotFoundError(f"project: expected a known id, got {project!r}")


def _projects(connection: Connection, only: str | None = None) -> list[Project]:
    chosen = select(projects)
    members = (
        select(PROJECT_OF.label("project"), sequences.c.id)
        .where(LIVE, WHOLE)
        .order_by(sequences.c.id)
    )
    roles = select(project_roles)
    if only is not None:
        chosen = chosen.where(projects.c.id == only)
        members, roles = (
            members.where(only == PROJECT_OF),
            roles.where(project_roles.c.project == only),
        )
    people: dict[str, dict[str, Role]] = {}
    recordings: dict[str, list[str]] = {}
    for row in connection.execute(roles):
        people.setdefault(row.project, {})[row.account] = row.role
    for row in connection.execute(members):
        recordings.setdefault(row.project, []).append(row.id)
    return [
        Project(
            row.id,
            row.name,
            row.created,
            None if row.categories is None else tuple(json.loads(row.categories)),
            people.get(row.id, {}),
            tuple(recordings.get(row.id, ())),
        )
        for row in connection.execute(chosen)
    ]


def _check(change: ProjectPatch) -> None:
    if change.name is not None:
        if not change.name.strip() or len(change.name) > LONGEST_NAME:
            raise BadInputError(
                f"name: expected 1 to {LONGEST_NAME} characters, got {len(change.name)}"
            )
        require_visible("name", change.name)
    for account, role in (change.roles or {}).items():
        require_name(account)
        if role not in ROLES:
            raise BadInputError(f"roles: expected one of {', '.join(ROLES)}, got {role!r}")


def _apply(connection: Connection, project: str, change: ProjectPatch) -> None:
    row = update(projects).where(projects.c.id == project)
    if change.name is not None:
        connection.execute(row.values(name=change.name))
    if change.categories is None:
        connection.execute(row.values(categories=None))
    elif change.categories is not UNSET:
        _require_categories(connection, change.categories)
        connection.execute(row.values(categories=json.dumps(sorted(set(change.categories)))))
    if change.roles is not None:
        connection.execute(delete(project_roles).where(project_roles.c.project == project))
        rows = [{"project": project, "account": a, "role": r} for a, r in change.roles.items()]
        if rows:
            connection.execute(insert(project_roles), rows)
    if change.recordings:
        _move(connection, project, change.recordings)


def _require_categories(connection: Connection, wanted: Collection[int]) -> None:
    known = set(connection.execute(select(categories.c.number)).scalars())
    for number in wanted:
        if number not in known:
            raise NotFoundError(f"categories: expected numbers of the taxonomy, got {number}")


def _move(connection: Connection, project: str, wanted: Sequence[str]) -> None:
    names = list(dict.fromkeys(wanted))
    for start in range(0, len(names), CHUNK):
        part = names[start : start + CHUNK]
        chosen = select(sequences.c.id, sequences.c.number).where(sequences.c.id.in_(part), LIVE)
        numbers = {row.id: row.number for row in connection.execute(chosen)}
        if missing := [name for name in part if name not in numbers]:
            raise NotFoundError(f"recordings: expected known ids, got {missing[0]!r}")
        elsewhere = tasks.c.sequence.in_(numbers.values()) & (tasks.c.project != project)
        unfinished = select(tasks.c.sequence).where(elsewhere, tasks.c.state != "accepted")
        busy = connection.execute(unfinished.limit(1)).scalar()
        if busy is not None:
            name = next(name for name, number in numbers.items() if number == busy)
            raise ConflictError(
                f"recordings: {name!r} has tasks in its project that are not accepted yet"
            )
        there = update(sequences).where(sequences.c.number.in_(numbers.values()))
        connection.execute(there.values(project=None if project == FIRST else project))
