"""Roles of people in projects and their recordings, checked at every call."""

from __future__ import annotations

import json
import math
import threading
import time
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from sqlalchemy import Connection, select

from pointbrush.accounts.accounts import MARK, PARTICIPANT
from pointbrush.accounts.roles import Role, includes
from pointbrush.database.database import Database
from pointbrush.database.project_rows import REMOVED
from pointbrush.database.project_tables import project_roles, tasks
from pointbrush.database.schema import PROJECT_OF, WHOLE, sequences
from pointbrush.database.study_tables import study_participants
from pointbrush.names import SCRATCH
from pointbrush.teamwork.projects import OVERSEES, role_in

COMPARES: Role = "reviewer"
"""Role that sees the copies of all people."""
REFRESH_SECONDS = 1.0
"""Longest delay until a change by another server takes effect."""


@dataclass(slots=True)
class _Original:
    """A recording with copies; ``people`` and ``copied`` have tasks in it and in its copies."""

    people: set[str] = field(default_factory=set)
    copied: set[str] = field(default_factory=set)
    truth: bool = False

    def hides_from(self, account: str) -> bool:
        """Return whether an account works on a copy instead, or could look up its own score."""
        return account not in self.people and (self.truth or account in self.copied)


def is_participant(account: str) -> bool:
    """Return whether an account is that of a study's participant, who sees their copies alone."""
    return account.startswith(f"{PARTICIPANT}{MARK}")


@dataclass(frozen=True, slots=True)
class Sight:
    """Recordings that an account does not see, and the project of each copy that it has."""

    hidden: frozenset[str] = frozenset()
    copies: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _Known:
    """Snapshot of the roles in each project and of its recordings.

    ``numbers``: by id, the recordings that had it in turn, each with the time of its deletion.  The
    other maps are by permanent number.  ``copies``: the people with tasks in each copy for one
    person; ``homes``: its project; ``participants``: the participant with each copy of a study.
    """

    roles: Mapping[str, Mapping[str, Role]] = field(default_factory=dict)
    numbers: Mapping[str, Sequence[tuple[float, int]]] = field(default_factory=dict)
    projects: Mapping[int, str] = field(default_factory=dict)
    copies: Mapping[int, set[str]] = field(default_factory=dict)
    homes: Mapping[int, str] = field(default_factory=dict)
    originals: Mapping[int, _Original] = field(default_factory=dict)
    participants: Mapping[int, str] = field(default_factory=dict)
    read: float = -REFRESH_SECONDS

    def number(self, sequence: str, at: float | None) -> int | None:
        """Return the recording that had an id at a time; None: the current or last one."""
        lives = self.numbers.get(sequence, ())
        when = math.inf if at is None else at
        return next(
            (number for end, number in lives if end >= when), lives[-1][1] if lives else None
        )

    def has(self, sequence: str) -> bool:
        """Return whether a recording has an id now."""
        lives = self.numbers.get(sequence)
        return lives is not None and lives[-1][0] == math.inf

    def hides(self, number: int, account: str) -> bool:
        """Return whether it is another person's copy, or the original of the account's copy."""
        people, original = self.copies.get(number), self.originals.get(number)
        if people is not None:
            return account not in people
        return original is not None and original.hides_from(account)

    def role_in(
        self, sequence: str, account: str, role: Role, at: float | None = None
    ) -> Role | None:
        """Return the role of an account in the recording that had an id at a time, as ``role``.

        A recording is not shown before it has a number: until then its project is not known.
        """
        if at is None and not self.has(sequence):
            return None
        return self.role(self.number(sequence, at), account, role)

    def role(self, number: int | None, account: str, role: Role) -> Role | None:
        """Return the role of an account in a recording; None: the recording is not for it."""
        if is_participant(account):
            return role if number and self.participants.get(number) == account else None
        if number is None:
            return role
        project = self.projects.get(number)
        if project == REMOVED:
            return None
        own = role if project is None else role_in(self.roles[project], account, role)
        if own is None or includes(own, COMPARES) or not self.hides(number, account):
            return own
        return None


class Access:
    """Roles of people in the recordings of one database; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._lock = threading.Lock()
        self._known = _Known()

    def to_sequence(
        self, sequence: str, account: str, role: Role, at: float | None = None
    ) -> Role | None:
        """Return the role in a recording of an account with ``role`` in the workspace; None: none.

        ``at``: a time, seconds since the epoch; the recording is the one that had the id then.
        """
        if includes(role, OVERSEES) or (sequence == SCRATCH and not is_participant(account)):
            return role
        known = self._look()
        found = known.role_in(sequence, account, role, at)
        if found is None or not known.has(sequence):  # the snapshot may be out of date
            found = self._look_anew().role_in(sequence, account, role, at)
        return found

    def is_of(self, sequence: str, at: float) -> bool:
        """Return whether the recording that had an id at a time is the one that has it now."""
        known = self._look()
        return known.number(sequence, at) == known.number(sequence, None)

    def to_number(self, number: int, account: str, role: Role) -> Role | None:
        """Return the role in a recording by its permanent number, deleted or not."""
        return role if includes(role, OVERSEES) else self._look_anew().role(number, account, role)

    def to_sequences(self, wanted: Iterable[str], account: str, role: Role) -> dict[str, Role]:
        """Return the roles in many recordings; recordings hidden from the account are left out."""
        if includes(role, OVERSEES):
            return dict.fromkeys(wanted, role)
        known = self._look_anew()
        roles = ((sequence, known.role_in(sequence, account, role)) for sequence in wanted)
        return {sequence: own for sequence, own in roles if own is not None}

    def sight(self, account: str) -> Sight:
        """Find the recordings that copies hide from an account, and its own copies."""
        known = self._look_anew()
        names = {
            lives[-1][1]: name for name, lives in known.numbers.items() if lives[-1][0] == math.inf
        }
        numbers = [number for number in (*known.copies, *known.originals) if number in names]
        own = {
            names[number]: known.homes[number]
            for number, people in known.copies.items()
            if account in people and number in names
        }
        hidden = (names[number] for number in numbers if known.hides(number, account))
        return Sight(frozenset(hidden), own)

    def to_project(self, project: str, account: str, role: Role) -> Role | None:
        """Return the role of an account in a project."""
        if includes(role, OVERSEES):
            return role
        if is_participant(account):
            return None
        return role_in(self._look().roles.get(project, {}), account, role)

    def forget(self) -> None:
        """Read the database again at the next call."""
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
            numbers: dict[str, list[tuple[float, int]]] = defaultdict(list)
            projects: dict[int, str] = {}
            rows = select(
                sequences.c.id, sequences.c.number, sequences.c.deleted,
                PROJECT_OF.label("project"),
            )  # fmt: skip
            with self._database.read() as connection:
                for row in connection.execute(select(project_roles)):
                    roles.setdefault(row.project, {})[row.account] = row.role
                for row in connection.execute(rows):
                    end = math.inf if row.deleted is None else row.deleted
                    numbers[row.id].append((end, row.number))
                    if row.project in roles or row.project == REMOVED:
                        projects[row.number] = row.project
                copies = _copies(connection)
                # A finished session reaches nothing.
                given = select(study_participants.c.account, study_participants.c.copies).where(
                    study_participants.c.began.is_not(None)
                )
                participants = {
                    number: row.account
                    for row in connection.execute(given)
                    for number in json.loads(row.copies).values()
                }
            for lives in numbers.values():
                lives.sort()
            self._known = _Known(roles, numbers, projects, *copies, participants, time.monotonic())
            return self._known


def _copies(
    connection: Connection,
) -> tuple[dict[int, set[str]], dict[int, str], dict[int, _Original]]:
    """Return the people and the project of each copy, and the recordings that have copies."""
    chosen = (
        select(
            sequences.c.number, sequences.c.copy_of, sequences.c.copy_kind, sequences.c.deleted,
            PROJECT_OF.label("project"), tasks.c.assignee,
        )
        .join(tasks, tasks.c.sequence == sequences.c.number, isouter=True)
        .where(~WHOLE)
    )  # fmt: skip
    people: dict[int, set[str]] = defaultdict(set)
    homes: dict[int, str] = {}
    originals: dict[int, _Original] = defaultdict(_Original)
    for row in connection.execute(chosen):
        people[row.number].add(row.assignee or "")
        homes[row.number] = row.project
        if row.deleted is None:
            one = originals[row.copy_of]
            one.copied.add(row.assignee or "")
            one.truth |= row.copy_kind == "truth"
    own = select(tasks.c.sequence, tasks.c.assignee).where(tasks.c.sequence.in_(list(originals)))
    for number, account in connection.execute(own) if originals else ():
        originals[number].people.add(account or "")
    return people, homes, originals
