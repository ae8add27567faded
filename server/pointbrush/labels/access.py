"""Roles of people in projects and their recordings, asked at every call."""

from __future__ import annotations

import threading
import time
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from sqlalchemy import Connection, case, select

from pointbrush.labels.database import Database
from pointbrush.labels.project_tables import project_roles, tasks
from pointbrush.labels.projects import OVERSEES, role_in
from pointbrush.labels.schema import LIVE, PROJECT_OF, WHOLE, sequences
from pointbrush.roles import Role, includes

COMPARES: Role = "reviewer"
"""Role that sees everybody's copies of a recording."""
REFRESH_SECONDS = 1.0
"""Longest time for which a change by another server is not seen."""


@dataclass(slots=True)
class _Original:
    """A recording with copies: who has tasks of its own or of a copy; ``truth``: one is scored."""

    people: set[str] = field(default_factory=set)
    copied: set[str] = field(default_factory=set)
    truth: bool = False

    def hides_from(self, account: str) -> bool:
        """Return whether an account has a copy in its place, or might look up its own score."""
        return account not in self.people and (self.truth or account in self.copied)


@dataclass(frozen=True, slots=True)
class Sight:
    """Recordings that an account does not see, and the project of each copy that it has."""

    hidden: frozenset[str] = frozenset()
    copies: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _Known:
    """Roles of each project that has any, and its recordings, as of a moment.

    ``copies``: those who have tasks in each copy for one person; ``homes``: its project.
    """

    roles: Mapping[str, Mapping[str, Role]] = field(default_factory=dict)
    projects: Mapping[str, str] = field(default_factory=dict)
    copies: Mapping[str, set[str]] = field(default_factory=dict)
    homes: Mapping[str, str] = field(default_factory=dict)
    originals: Mapping[str, _Original] = field(default_factory=dict)
    read: float = -REFRESH_SECONDS

    def hides(self, sequence: str, account: str) -> bool:
        """Return whether it is another person's copy, or one that an account has a copy of."""
        people, original = self.copies.get(sequence), self.originals.get(sequence)
        if people is not None:
            return account not in people
        return original is not None and original.hides_from(account)

    def role(self, sequence: str, account: str, role: Role) -> Role | None:
        """See ``Access.to_sequence``."""
        project = self.projects.get(sequence)
        own = role if project is None else role_in(self.roles[project], account, role)
        if own is None or includes(own, COMPARES) or not self.hides(sequence, account):
            return own
        return None


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
        found = self._look().role(sequence, account, role)
        if found is None:  # until a moment ago: nobody waits for what they were just given
            found = self._look_anew().role(sequence, account, role)
        return found

    def to_sequences(self, wanted: Iterable[str], account: str, role: Role) -> dict[str, Role]:
        """Roles in many recordings at once; those that are not for the account are left out."""
        if includes(role, OVERSEES):
            return dict.fromkeys(wanted, role)
        known = self._look_anew()
        roles = ((sequence, known.role(sequence, account, role)) for sequence in wanted)
        return {sequence: own for sequence, own in roles if own is not None}

    def sight(self, account: str) -> Sight:
        """Find the recordings that copies hide from an account, and its own copies."""
        known = self._look_anew()
        names = [*known.copies, *known.originals]
        own = {name: known.homes[name] for name, who in known.copies.items() if account in who}
        return Sight(frozenset(name for name in names if known.hides(name, account)), own)

    def to_project(self, project: str, account: str, role: Role) -> Role | None:
        """The same in a project."""
        if includes(role, OVERSEES):
            return role
        return role_in(self._look().roles.get(project, {}), account, role)

    def forget(self) -> None:
        """Look anew at the next call."""
        with self._lock:
            self._known = _Known()

    def _look_anew(self) -> _Known:
        self.forget()
        return self._look()

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
                copies = _copies(connection)
            self._known = _Known(roles, found, *copies, time.monotonic())
            return self._known


def _copies(
    connection: Connection,
) -> tuple[dict[str, set[str]], dict[str, str], dict[str, _Original]]:
    """Return the people and the project of each copy, and the recordings that have copies."""
    whole = sequences.alias()
    chosen = (
        select(
            sequences.c.id, sequences.c.copy_kind, sequences.c.deleted, PROJECT_OF.label("project"),
            whole.c.id.label("original"), tasks.c.assignee,
        )
        .join(whole, whole.c.number == sequences.c.copy_of)
        .join(tasks, tasks.c.sequence == sequences.c.number, isouter=True)
        .where(~WHOLE)
    )  # fmt: skip
    people: dict[str, set[str]] = defaultdict(set)
    homes: dict[str, str] = {}
    originals: dict[str, _Original] = defaultdict(_Original)
    for row in connection.execute(chosen):
        people[row.id].add(row.assignee or "")
        homes[row.id] = row.project
        if row.deleted is None:
            one = originals[row.original]
            one.copied.add(row.assignee or "")
            one.truth |= row.copy_kind == "truth"
    known = [*people, *originals]
    own = select(sequences.c.id, tasks.c.assignee).where(LIVE, WHOLE, sequences.c.id.in_(known))
    own = own.join(tasks, tasks.c.sequence == sequences.c.number, isouter=True)
    for name, account in connection.execute(own) if known else ():
        people.pop(name, None)  # of a copy that was deleted before there was another one
        if name in originals:
            originals[name].people.add(account or "")
    return people, homes, originals
