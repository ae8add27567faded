"""Queries over all recordings: matches of a search, and a project's statistics."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection
from dataclasses import dataclass

from sqlalchemy import ColumnElement, Connection, and_, case, exists, func, or_, select

from pointbrush.database.class_names import read_names
from pointbrush.database.database import Database
from pointbrush.database.project_tables import FIRST, tasks
from pointbrush.database.schema import LIVE, PROJECT_OF, WHOLE, counts, edits, labels, sequences
from pointbrush.values.kinds import TaskState
from pointbrush.values.team.projects import ClassFigures, PersonFigures, Statistics

_CLASS = case((labels.c.category != "", labels.c.category), else_=labels.c.name)
"""The key of a label's class; a label without a category has its own class."""
_OF_LABEL = and_(
    counts.c.sequence == labels.c.sequence, counts.c.label == labels.c.id, counts.c.points > 0
)


@dataclass(frozen=True, slots=True)
class Search:
    """Conditions on recordings; None: any.

    ``project``  the project of the recordings.
    ``category``, ``label``  a class, or the name of a label, with points in them.
    ``state``    of a task.
    ``person``   account of a task's assignee or an edit's author.
    """

    project: str | None = None
    category: str | None = None
    label: str | None = None
    state: TaskState | None = None
    person: str | None = None


@dataclass(frozen=True, slots=True)
class Match:
    """A matching recording: the revision of its labels, its project.

    ``copy_of``: the original of a copy for one person, or None.
    """

    revision: int
    project: str
    copy_of: str | None


@dataclass(frozen=True, slots=True)
class Effort:
    """Parameters of the estimate of working time from the times of edits.

    ``idle`` seconds without an edit are a pause; ``first``: seconds counted for an edit after a
    pause.  ``machine``: kinds of automatic edits, not counted; ``strokes``: kinds of manual edits.
    """

    idle: float
    first: float
    machine: Collection[str]
    strokes: Collection[str]


Counts = dict[str, dict[tuple[str, TaskState], int]]
"""Number of tasks of each project by assignee ("": none) and state."""


class Summaries:
    """Queries over all recordings of one database; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def tasks(self, without: Collection[str] = ()) -> Counts:
        """Count tasks, except tasks of the recordings ``without``."""
        chosen = (
            select(tasks.c.project, tasks.c.assignee, tasks.c.state, func.count())
            .join(sequences, sequences.c.number == tasks.c.sequence)
            .where(LIVE, sequences.c.id.not_in(without))
            .group_by(tasks.c.project, tasks.c.assignee, tasks.c.state)
        )
        found: Counts = {}
        with self._database.read() as connection:
            for project, assignee, state, count in connection.execute(chosen):
                found.setdefault(project, {})[assignee or "", state] = count
        return found

    def projects(self) -> dict[str, str]:
        """Return the project of each recording, by id."""
        with self._database.read() as connection:
            chosen = select(sequences.c.id, PROJECT_OF.label("project")).where(LIVE)
            return {row.id: row.project for row in connection.execute(chosen)}

    def project(self, sequence: str) -> str:
        """Return the project of a recording."""
        chosen = select(PROJECT_OF).where(LIVE, sequences.c.id == sequence)
        with self._database.read() as connection:
            return str(connection.execute(chosen).scalar() or FIRST)

    def matching(self, search: Search) -> dict[str, Match]:
        """Return the recordings that match a search, by id."""
        whole = sequences.alias()
        original = select(whole.c.id).where(whole.c.number == sequences.c.copy_of)
        chosen = select(
            sequences.c.id, sequences.c.revision, PROJECT_OF, original.scalar_subquery()
        ).where(LIVE)
        with self._database.read() as connection:
            chosen = chosen.where(*_conditions(connection, search))
            return {name: Match(*rest) for name, *rest in connection.execute(chosen)}

    def figures(self, project: str, effort: Effort, without: Collection[str] = ()) -> Statistics:
        """Return the statistics of a project except the recordings ``without``.

        A class gets the same share of each recording's time as of its painted points.
        """
        is_counted = and_(project == PROJECT_OF, LIVE, WHOLE, sequences.c.id.not_in(without))
        with self._database.read() as connection:
            number = connection.execute(select(func.count()).where(is_counted)).scalar_one()
            frames = select(counts.c.sequence, counts.c.frame).distinct()
            frames = frames.join(sequences, sequences.c.number == counts.c.sequence)
            labelled = frames.where(is_counted, counts.c.points > 0, counts.c.label > 0).subquery()
            count = connection.execute(select(func.count()).select_from(labelled)).scalar_one()
            people, spent = _people(connection, is_counted, effort)
            classes = _classes(connection, is_counted, spent)
        points, objects = (sum(getattr(c, n) for c in classes) for n in ("points", "objects"))
        hours = sum(each.hours for each in people)
        return Statistics(number, count, points, objects, hours, classes, people)


def _conditions(connection: Connection, search: Search) -> list[ColumnElement[bool]]:
    own = sequences.c.number
    found: list[ColumnElement[bool]] = []
    if search.project is not None:
        found.append(search.project == PROJECT_OF)
    called = []
    if search.category is not None:
        called.append(_of_class(connection, search.category.lower()))
    if search.label is not None:
        called.append(func.lower(labels.c.name) == search.label.lower())
    shown = select(labels.c.id).where(labels.c.sequence == own)
    there = exists(select(counts.c.frame).where(_OF_LABEL))
    found += [exists(shown.where(each, there)) for each in called]
    of_it = select(tasks.c.number).where(tasks.c.sequence == own)
    if search.state is not None:
        found.append(exists(of_it.where(tasks.c.state == search.state)))
    if search.person is not None:
        wrote = select(edits.c.revision).where(
            edits.c.sequence == own, edits.c.author == search.person
        )
        found.append(or_(exists(of_it.where(tasks.c.assignee == search.person)), exists(wrote)))
    return found


def _of_class(connection: Connection, wanted: str) -> ColumnElement[bool]:
    """Return the condition for labels of a class by its name in lower case."""
    names = read_names(connection)
    used = connection.execute(select(labels.c.category).distinct()).scalars()
    keys = [key for key in used if key and names.name(key).lower() == wanted]
    own = and_(labels.c.category == "", func.lower(labels.c.name) == wanted)
    return or_(labels.c.category.in_(keys), own)


def _people(
    connection: Connection, is_counted: ColumnElement[bool], effort: Effort
) -> tuple[tuple[PersonFigures, ...], dict[int, float]]:
    """Return the statistics of accounts, longest time first, and hours by recording."""
    before = func.lag(edits.c.time).over(
        partition_by=(edits.c.sequence, edits.c.author), order_by=edits.c.revision
    )
    gap = edits.c.time - before
    spans = (
        select(
            edits.c.sequence,
            edits.c.author,
            case((edits.c.kind.in_(effort.strokes), edits.c.points), else_=0).label("points"),
            case((gap.between(0, effort.idle), gap), else_=effort.first).label("seconds"),
        )
        .join(sequences, sequences.c.number == edits.c.sequence)
        .where(is_counted, edits.c.kind.not_in(effort.machine))
        .subquery()
    )
    chosen = select(
        spans.c.sequence,
        spans.c.author,
        func.sum(spans.c.seconds),
        func.count(),
        func.sum(spans.c.points),
    ).group_by(spans.c.sequence, spans.c.author)
    spent: dict[int, float] = defaultdict(float)
    people: dict[str, PersonFigures] = {}
    for number, account, seconds, count, points in connection.execute(chosen):
        hours = seconds / 3600
        spent[number] += hours
        old = people.get(account, PersonFigures(account, 0.0, 0, 0))
        people[account] = PersonFigures(
            account, old.hours + hours, old.edits + count, old.points + int(points)
        )
    return tuple(sorted(people.values(), key=lambda each: -each.hours)), spent


def _classes(
    connection: Connection, is_counted: ColumnElement[bool], spent: dict[int, float]
) -> tuple[ClassFigures, ...]:
    chosen = (
        select(
            labels.c.sequence,
            _CLASS.label("key"),
            func.sum(counts.c.points),
            func.sum(counts.c.painted),
            func.count(labels.c.id.distinct()),
        )
        .join(counts, _OF_LABEL)
        .join(sequences, sequences.c.number == labels.c.sequence)
        .where(is_counted)
        .group_by(labels.c.sequence, _CLASS)
    )
    rows, classes = connection.execute(chosen).all(), read_names(connection)
    painted: dict[int, int] = defaultdict(int)
    for number, _, _, by_hand, _ in rows:
        painted[number] += int(by_hand)
    found: dict[str, ClassFigures] = {}
    for number, key, points, by_hand, objects in rows:
        name = classes.name(key)
        old = found.get(name, ClassFigures(name, 0, 0, 0.0))
        share = int(by_hand) / painted[number] if painted[number] else 0.0
        hours = old.hours + share * spent.get(number, 0.0)
        found[name] = ClassFigures(name, old.points + int(points), old.objects + objects, hours)
    return tuple(sorted(found.values(), key=lambda each: -each.points))
